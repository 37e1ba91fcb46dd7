#!/usr/bin/env python3
"""GCC vectorises the loops of the lanes. Results do not show whether it does, but photons once became three times slower
when it did not. Compiles src/host/lane_stages.cpp as the build does: every loop over whole registers (from 0 to `used`,
`count` or `whole_registers(...)`) must be vectorised in each function that it is inlined into. Exits with 77 (skipped) if
the build has no such lanes or does not use GCC 12, for which they are written.
"""
import json
import os
import re
import shlex
import subprocess
import sys

LOOP = re.compile(r"\s*for \(int ([lm]) = 0; \1 < (used|count|whole_registers\([\w.]+\)); \+\+\1\)(.*)")
FILL = re.compile(r" [\w.]+\[\w\] = [\w.]+;$")  # GCC calls memset
FUNCTION = re.compile(r"(?:template .*\n)?\[\[gnu::(always_inline|flatten)\]\].*?(\w+)\(")
SEARCHES = "tabulated"  # not shared by lanes: functions of this kind have no vectors


def loops(path):
    """Returns, for the line of each loop over whole registers, the number of functions that contain it."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    functions = [(text.count("\n", 0, found.end()) + 1, found) for found in FUNCTION.finditer(text)]
    needed = {}
    for number, line in enumerate(text.split("\n"), 1):
        loop = LOOP.match(line)
        if not loop or FILL.match(loop[3]):
            continue
        function = [found for at, found in functions if at <= number][-1]
        copies = 1
        if function[1] == "always_inline" or function[0].startswith("template"):
            calls = re.findall(r"^  .*\b%s(?:<[^>]*>)?\(.*;$" % function[2], text, re.M)
            copies = sum(SEARCHES not in call for call in calls)
        needed[number] = copies
    return needed


build = os.path.dirname(os.path.realpath(os.environ.get("TYNDALL_BINARY", "build/release/tyndall")))
with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
    commands = json.load(file)
bad = checked = 0
for entry in commands:
    isa = re.search(r"-DTYNDALL_ISA=(v\d)", entry["command"])
    if not entry["file"].endswith("/lane_stages.cpp") or not isa:
        continue
    command = shlex.split(entry["command"])
    while os.path.basename(command[0]) == "ccache":
        command.pop(0)
    version = subprocess.run([command[0], "--version"], capture_output=True, text=True, check=True).stdout
    if "clang" in version or not re.search(r"\b12\.\d+\.\d+", version) or "-O3" not in command:
        continue
    command[command.index("-o") + 1] = os.devnull
    command[command.index("-c")] = "-S"
    report = subprocess.run(command + ["-fopt-info-vec-optimized"], cwd=entry["directory"], capture_output=True, text=True,
                            check=True).stderr
    vectorised = re.findall(r"lane_stages\.cpp:(\d+):\d+: optimized: loop vectorized", report)
    needed = loops(entry["file"])
    if not needed:
        sys.exit("no loops found in " + entry["file"])
    for line, copies in needed.items():
        found = vectorised.count(str(line))
        if found < copies:
            print(f"src/host/lane_stages.cpp:{line}: {isa[1]}: {found} of {copies} copies of this loop are vectors: look for "
                  "branches in what it calls (-fopt-info-vec-missed)")
            bad = 1
    print(f"{isa[1]}: {len(needed)} loops over whole registers, all of vectors" if not bad else f"{isa[1]}: not all of vectors")
    checked += 1
if not checked:
    print("SKIPPED: no lanes by GCC 12 at -O3 in this build")
    sys.exit(77)
sys.exit(bad)
