#!/usr/bin/env python3
"""Runs every command of README.md, CONTRIBUTING.md, docs/ and bench/README.md, or checks that another test named here runs
it. docs/errors.md has a test of its own (ErrorsTable), which compares every message.

Commands are lines of indented blocks and spans between backticks that begin with one of PROGRAMS. Each document has a
folder that looks like a clone, with a scene and a volume. Its lines run there in order and unchanged, except that SHORTER
reduces large numbers.

    documented_commands.py [PART OF A DOCUMENT'S NAME]
"""

import glob
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
BUILD = os.path.abspath(os.environ.get("TYNDALL_BUILD_DIR", os.path.join(ROOT, "build/release")))
VOLUMES = os.environ.get("TYNDALL_TEST_VOLUMES", os.path.join(BUILD, "tests/volumes"))

PROGRAMS = re.compile(r"(\./|build/|scripts/|tests/long/\w+(?![\w./])|bench/compare\.py|packaging/package|mi/bin/|"
                      r"tyndall(-\w+)? |(cmake|ctest|pip|python3|bash|blender|mpirun|perf|pbrt|imgtool|sbatch|man|git|"
                      r"apt|apt-get|sudo|docker|for) |\w=\$\(sbatch)")

# Commands that run elsewhere: the file that contains the text, or the test of ctest. "nobody": not run, with the reason.
ELSEWHERE = [
    (r"scripts/test\b", "text", ".ci/run", "scripts/test full"),
    (r"scripts/format\b", "text", ".ci/run", "scripts/format"),
    (r"bash \.ci/run", "nobody", "it runs this guard"),
    (r"python3 tests/guards/(scene_reference)\.py --write", "test", r"guards.\1"),
    (r"scripts/setup", "text", ".ci/run", "scripts/setup --dev"),
    (r"scripts/pictures", "text", "tests/long/check_all", "scripts/pictures"),
    (r"(tests/long/(measure_volumes|kill_check|fuzz))", "text", "tests/long/check_all", r"\1"),
    (r"packaging/package", "text", "tests/package/run.sh", "packaging/package"),
    (r"bash (tests/\w+/run\.sh)", "text", "tests/long/check_all", r"\1"),
    (r"pip install \.", "text", "tests/python/run.sh", "install -q ."),
    (r"cmake --install build/release", "test", "guards.installed_package_works"),
    (r"cmake --preset cuda", "test", "guards.cuda"),
    (r"tests/long/gpu_(pack|check)", "test", "guards.cuda"),
    (r"blender ", "test", "guards.blender"),
    (r"python3 tests/guards/(page_in_browser)\.py", "test", r"guards.\1"),
    (r"tyndall-bench --device cuda", "text", "tests/long/gpu_check", "--device cuda"),
    (r"mi/bin/|python3 -m venv mi", "test", "Convert.*MitsubaRendersTheSamePicture"),
    (r"pbrt |imgtool ", "nobody", "pbrt is in no package"),
    (r"man tyndall", "test", "CliTest.TheManualHasEveryOption"),
    (r"build/cuda/", "text", "tests/long/gpu_check", "--device cuda"),
    (r"tests/long/check_all", "nobody", "hours, by hand: it runs the tests and all that they leave out"),
    (r"scripts/render$", "test", "guards.documented_commands"),
    (r"cmake --preset release", "text", ".ci/run", "cmake --preset release -DTYNDALL_TESTS=ON"),
]

SHORTER = [
    (r"\b[1-9]e[67]\b", "1e4"),
    (r"--grids 64 128 --bounces 0 1 2", "--grids 16 --bounces 0"),
    (r"--photons 3000000 --samples 256 --path-samples 1024", "--photons 3000 --samples 8 --path-samples 8"),
    (r"tyndall-bias --slabs .*", "tyndall-bias --slabs --bounces 0 --seeds 3 --width 4 --photons 1000 --samples 1 --path-samples 1"),
    (r"scenes/NAME\.json --photons 8000000", "scenes/lonely_cloud.json --photons 1e4"),
    (r"--benchmark_repetitions=9 --benchmark_min_time=0\.1", "--benchmark_repetitions=2 --benchmark_min_time=0.001"),
    (r"^perf stat -r 60 ", ""),
    (r"--seconds 5\b", "--seconds 0.01"),
    # Without Mitsuba, with one picture of each setting.
    (r"--mitsuba 8 --mitsuba-seeds 3", "--python python3"),
    (r"--python mi/bin/python --sheet sheet\.png", ""),
    (r"--work /tmp/compare --seeds 8", "--work compare --seeds 1"),
    (r"--samples (64|256|128|1024)'", "--samples 2'"),
]
# (program, an option that the line may have, arguments that are added if it does not)
SHORT_OPTIONS = [
    (r"(render|mpirun|tyndall render) .*scenes/", "--photons", "--photons 1e4"),
    (r"(render|mpirun|tyndall render) .*scenes/", "--samples", "--samples 8"),
    (r"tyndall bake scenes/", "--voxels", "--voxels 16"),
    (r"tyndall convert", "--voxels", "--voxels 16"),
    (r"tyndall-micro", "--benchmark_min_time", "--benchmark_min_time=0.001"),
    (r"tyndall-bench --table", "--seconds", "--seconds 0.01 --repeats 1"),
    (r"tyndall-bench --table", "--filter", "--photons 2000 --filter LV/256"),
]
# Runs jobs as Slurm would: all tasks of an array, one after the other, then the jobs that depend on them.
SBATCH = r"""#!/bin/bash
[[ $* == *--wrap* ]] && exec >&2 bash -ec "${*: -1}"
script=${*: -1}
last=$(sed -n 's/^#SBATCH --array=0-\([0-9]*\).*/\1/p' "$script")
for ((i = 0; i <= last; ++i)); do SLURM_ARRAY_TASK_ID=$i bash -e "$script" >&2 || exit; done
echo 1
"""

SCENE = {
    "tyndall": 1,
    "medium": {"components": [{"field": {"type": "sphere", "radius": 0.4}, "extinction": 1, "albedo": 0.5}]},
    "lights": [{"type": "point", "position": [1.5, 2, 0.5], "power": 100}],
    "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "resolution": [16, 12]},
    "photons": {"count": 8000000, "illumination": {"resolution": 8}},
    "gather": {"samples": 128}}

failures = 0


def fail(where, text):
    global failures
    failures += 1
    print("FAILED %s: %s" % (where, text))


def blocks(text):
    """Returns (line number, lines) of blocks indented by four after an empty line; not in fences."""
    found, fenced, block = [], False, None
    for number, line in enumerate(text.split("\n") + [""], 1):
        if line.startswith("```"):
            fenced = not fenced
        if line.startswith("    ") and not fenced:
            block = block or (number, [])
            block[1].append(line[4:])
        elif block:
            found.append(block)
            block = None
    return found


def commands(lines):
    """Returns (offset, command): continued lines and loops are one command."""
    found, command, start = [], "", 0
    for offset, line in enumerate(lines):
        if not command:
            start = offset
        command += line + "\n"
        loops = len(re.findall(r"\bfor .*; do$", command, re.M)) - len(re.findall(r"^done\b", command, re.M))
        if line.endswith("\\") or loops:
            continue
        found.append((start, command.strip()))
        command = ""
    return [(offset, re.sub(r"\s+# .*", "", command)) for offset, command in found]


def is_known_test(pattern):
    listed = subprocess.run(["ctest", "--test-dir", BUILD, "-N", "-R", pattern], capture_output=True, text=True).stdout
    return re.search(r"Total Tests: [1-9]", listed)


def elsewhere(where, command):
    for pattern, kind, *what in ELSEWHERE:
        found = re.match(pattern, command)
        if not found:
            continue
        if kind == "text":
            path, text = what[0], found.expand(what[1])
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                if text not in file.read():
                    fail(where, "%s does not run it: no '%s' there" % (path, text))
        elif kind == "test" and not is_known_test(found.expand(what[0])):
            fail(where, "no test is called %s" % found.expand(what[0]))
        for script in re.findall(r"(?:scripts|tests|bench|packaging|tools)/[\w./]+", command):
            if not os.path.exists(os.path.join(ROOT, script)):
                fail(where, "there is no " + script)
        return True
    return False


def run(where, command, folder, environment):
    if elsewhere(where, command):
        return
    tests = re.match(r"ctest -R (\S+)$", command)
    if tests:
        if not is_known_test(tests[1]):
            fail(where, "no test is called " + tests[1])
        return
    if re.match(r"(scripts|bench|packaging)/[\w.]+$", command):  # a mention
        if not os.path.exists(os.path.join(ROOT, command)):
            fail(where, "there is no " + command)
        return
    if command.startswith("bench/compare.py") and not has_numpy():
        print("SKIPPED %s: no numpy here" % where)
        return
    program = re.search(r"\btyndall-\w+|mpirun", command)
    if program and not (shutil.which(program[0], path=environment["PATH"])):
        print("SKIPPED %s: no %s here" % (where, program[0]))
        return
    mention = re.match(r"(?:build/release/)?tyndall[\w-]*(?: [a-z]+)?( --[\w-]+)?$", command)
    if mention:
        command += " --help" + (" | grep -e '%s'" % mention[1].strip() if mention[1] else "")
    for pattern, short in SHORTER:
        command = re.sub(pattern, short, command)
    for pattern, option, added in SHORT_OPTIONS:
        if re.search(pattern, command) and option not in command and not mention:
            command += " " + added
    done = subprocess.run(["bash", "-ec", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    if done.returncode:
        fail(where, "%s\n  ended with %d:\n  %s" % (command, done.returncode, done.stdout[-1500:].replace("\n", "\n  ")))
    else:
        print("%s: %s" % (where, command.split("\n")[0]))


def make_folder(folder, path):
    """Fills the folder with the files that a reader of the document has."""
    for name in os.listdir(ROOT):
        if name not in ("build", ".git"):
            os.symlink(os.path.join(ROOT, name), os.path.join(folder, name))
    os.mkdir(os.path.join(folder, "build"))
    os.symlink(BUILD, os.path.join(folder, "build/release"))
    shutil.copy(os.path.join(VOLUMES, "ball.vdb"), os.path.join(folder, "smoke.vdb"))
    os.mkdir(os.path.join(folder, "bin"))
    with open(os.path.join(folder, "bin/sbatch"), "w") as file:
        file.write(SBATCH)
    os.chmod(os.path.join(folder, "bin/sbatch"), 0o755)
    with open(os.path.join(folder, "scene.json"), "w") as file:
        json.dump(SCENE, file)
    if path.endswith("comparison.md") and has_numpy():
        subprocess.run(["python3", "-c", "import numpy as n\n"
                        "n.save('cloud_hv_256.npy', n.random.default_rng(1).random((8, 8, 8), dtype=n.float32) / 9)\n"
                        "n.savez('reference_hv_0.99.npz', img=n.ones((12, 16)), rel_err=0.01)"], cwd=folder, check=True)
    if path.endswith("images.md"):
        subprocess.run([os.path.join(BUILD, "tyndall"), "render", "scene.json", "-o", "sky.exr"], cwd=folder, check=True,
                       capture_output=True)
    if path.endswith("reliability.md"):
        tyndall = os.path.join(BUILD, "tyndall")
        subprocess.run([tyndall, "render", "scene.json", "--sample-range", "0:1", "-o", "part.tyn"], cwd=folder,
                       check=True, capture_output=True)


def has_numpy():
    return subprocess.run(["python3", "-c", "import numpy"], capture_output=True).returncode == 0


def scenes_with(lines):
    """Yields a scene for each component and each '"key": value' in the lines."""
    text = re.sub(r"//.*", "", "\n".join(lines))
    text = re.sub(r'"grid": "\w+"', '"grid": "density"', text.replace("fire.vdb", "smoke.vdb")).strip()
    while text:
        key = re.match(r'"(\w+)":\s*', text)
        value, end = json.JSONDecoder().raw_decode(text, key.end() if key else 0)
        text = text[end:].strip()
        component = SCENE["medium"]["components"][0]
        if key and key[1] != "emission":
            yield {**SCENE, key[1]: value}
        else:
            yield {**SCENE, "medium": {"components": [{**component, "emission": value} if key else value]}}


def run_document(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        text = file.read()
    with tempfile.TemporaryDirectory() as folder:
        make_folder(folder, path)
        environment = {**os.environ, "PATH": os.path.join(folder, "bin") + ":" + BUILD + ":" + os.environ["PATH"],
                       "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                       "OMPI_MCA_rmaps_base_oversubscribe": "1"}
        for number, lines in blocks(text):
            where = "%s:%d" % (path, number)
            if re.match(r'"|{ "field"', lines[0]):  # a part of a scene, for what comes next
                for scene in scenes_with(lines):
                    with open(os.path.join(folder, "scene.json"), "w") as file:
                        json.dump(scene, file)
                    run(where, "tyndall validate scene.json", folder, environment)
            elif lines[0].startswith('{ "tyndall": 1,'):  # a scene, whose name stands before it
                before = "\n".join(text.split("\n")[max(number - 5, 0):number])
                for name in re.findall(r"`(\w+\.json)`", before):
                    with open(os.path.join(folder, name), "w") as file:
                        file.write("\n".join(lines))
            elif lines[0].startswith("import "):
                if not has_numpy():
                    print("SKIPPED %s: no numpy here" % where)
                    continue
                with open(os.path.join(folder, "read.py"), "w") as file:
                    file.write("\n".join(lines))
                run(where, "python3 read.py", folder, environment)
            elif lines[0].startswith("#!"):
                name = next(re.match(r"# (\w+\.sh)", line)[1] for line in lines if re.match(r"# \w+\.sh", line))
                with open(os.path.join(folder, name), "w") as file:
                    file.write("\n".join(lines))
            elif any(PROGRAMS.match(line) for line in lines):
                slurm = any("sbatch" in line for line in lines)  # its lines hand variables on
                for offset, command in [(0, "\n".join(lines))] if slurm else commands(lines):
                    run("%s:%d" % (path, number + offset), command, folder, environment)
        for number, line in enumerate(text.split("\n"), 1):
            for command in re.findall(r"`([^`]+)`", "" if line.startswith("    ") else line):
                if PROGRAMS.match(command):
                    run("%s:%d" % (path, number), command, folder, environment)


def main():
    if not os.path.exists(os.path.join(BUILD, "tyndall-vdb")):
        print("SKIPPED: built without OpenVDB")
        return 77
    documents = ["README.md", "CONTRIBUTING.md", "bench/README.md"]
    documents += sorted(os.path.relpath(p, ROOT) for p in glob.glob(ROOT + "/docs/*.md"))
    for path in documents:
        if path != "docs/errors.md" and (len(sys.argv) < 2 or sys.argv[1] in path):
            run_document(path)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
