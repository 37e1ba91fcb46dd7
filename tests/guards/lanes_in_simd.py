#!/usr/bin/env python3
"""The processors' lanes are SIMD only as long as GCC vectorises their loops, and none of their results tells: a step that
was no longer vectorised once made photons three times slower. Compiles the loops as the build does and counts those that
became vectors. Ends with 77 (skipped) where the build is not of GCC 12, whose count this is, or has no such lanes.
"""
import json
import os
import re
import shlex
import subprocess
import sys

LOOPS = 23

build = os.path.dirname(os.path.realpath(os.environ.get("TYNDALL_BINARY", "build/release/tyndall")))
commands = json.load(open(os.path.join(build, "compile_commands.json"), encoding="utf-8"))
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
    said = subprocess.run(command + ["-fopt-info-vec-optimized"], cwd=entry["directory"], capture_output=True, text=True,
                          check=True).stderr
    loops = len(re.findall(r"lane_stages\.cpp:\d+:\d+: optimized: loop vectorized", said))
    print(f"{isa[1]}: {loops} loops vectorised")
    checked += 1
    if loops < LOOPS:
        print(f"they were {LOOPS}: look for branches in what src/host/lane_stages.cpp calls (-fopt-info-vec-missed)")
        bad = 1
if not checked:
    print("SKIPPED: no lanes by GCC 12 at -O3 in this build")
    sys.exit(77)
sys.exit(bad)
