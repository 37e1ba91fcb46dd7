#!/usr/bin/env python3
"""Makes every call that can fail fail once, one per run: the exit code names the cause, files are complete or unchanged.

  faults.py [--all]     --all: every allocation of the program, not a sample of them

tests/support/faults/fail_call.cpp makes one call of a small run fail: of a render, of a render resumed from a checkpoint
with a volume from a file, of a merge. The program's own calls of open, read, write, fsync, rename and mmap fail one after
the other, until a run passes without a failure. Of allocations and of calls within libraries a fixed sample fails; oneTBB
aborts in some of them and rarely hangs: both are counted. Exits with 77 (skipped) if the shim cannot be loaded, as under
sanitizers.
"""
import collections
import concurrent.futures
import itertools
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

program = os.environ["TYNDALL_BINARY"]
volumes = pathlib.Path(os.environ.get("TYNDALL_TEST_VOLUMES", "none"))
shim = pathlib.Path(os.environ["TYNDALL_BUILD_DIR"]) / "tests" / "fail-call.so"
scene = """{"tyndall": 1,
 "medium": {"components": [{"field": {"type": "sphere", "radius": 0.4}, "extinction": 10, "albedo": 0.9}]},
 "lights": [{"type": "point", "position": [1.5, 2, 0.5], "power": 100}],
 "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "resolution": [16, 16]},
 "photons": {"count": 1000, "illumination": {"resolution": 8}}, "gather": {"samples": 2}}"""
volume = """{"tyndall": 1,
 "medium": {"components": [{"field": {"type": "vdb", "file": "ball.vdb"}, "extinction": 1, "albedo": 0.9}]},
 "lights": [{"type": "environment", "radiance": 1}], "camera": {"resolution": [16, 16]},
 "photons": {"count": 1000, "illumination": {"resolution": 8}}, "gather": {"samples": 2}}"""
outputs = ["a.pfm", "a.tyn", "r.json"]
common = ["--threads", "1", "-o", "a.pfm", "-o", "a.tyn", "--report", "r.json"]
checkpoint = ["--checkpoint", "c.tyn", "--checkpoint-every", "0"]
# Name: the arguments, and those of the runs that make its inputs.
runs = {
    "render": (["render", "scene.json", *common, *checkpoint], []),
    "resume": (["render", "volume.json", *common, *checkpoint, "--resume"],
               [["render", "volume.json", "--sample-range", "0:1", "-o", "c.tyn"]]),
    "merge": (["merge", "p.tyn", "q.tyn", *common[2:-2]],
              [["render", "scene.json", "--sample-range", "0:1", "-o", "p.tyn"],
               ["render", "scene.json", "--sample-range", "1:2", "-o", "q.tyn"]]),
}
# Allowed exit codes: one that names the cause, or 0 for a harmless failure (a lost line on stderr, another way to the
# same memory).
codes = {
    "malloc": {0, 6},
    "open": {0, 4, 5, 6},  # 6: too few file descriptors for a reader
    "write": {0, 5},
    "read": {0, 3, 4},
    "fsync": {0, 5},
    "rename": {0, 5},
    "mmap": {0, 4, 6},
}
# Counted, not errors: failures in a library that aborts, or that reports lack of memory as an unreadable file.
abort = -6
in_libraries = {abort, 4}


def start(folder, name, call="", at=0, origin="all"):
    environment = {**os.environ, "LD_PRELOAD": str(shim), "FAIL_CALL": call, "FAIL_AT": str(at), "FAIL_FROM": origin,
                   "FAIL_COUNT": str(folder / "count")}
    return subprocess.run([program, *runs[name][0]], cwd=folder, env=environment, capture_output=True, text=True, timeout=20)


def inputs_of(name):
    """Returns the files that a run begins with; the runs before it are made only once."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tyndall-faults-"))
    (folder / "scene.json").write_text(scene)
    if name == "resume":
        (folder / "volume.json").write_text(volume)
        shutil.copy(volumes / "ball.vdb", folder)
    for arguments in runs[name][1]:
        subprocess.run([program, *arguments], cwd=folder, check=True, capture_output=True)
    for output in outputs:
        (folder / output).write_text("old")
    files = {file.name: file.read_bytes() for file in folder.iterdir()}
    remove(folder)
    return files


def fresh(name):
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tyndall-faults-"))
    for file, data in inputs[name].items():
        (folder / file).write_bytes(data)
    return folder


def remove(folder):
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()


def is_whole(folder, name, output):
    data = (folder / output).read_bytes()
    # Times and the order of checkpoints may differ, but not the result.
    return data == b"old" or output == "r.json" and data.endswith(b"}\n") or data == reference[name, output]


def attempt(name, call, at, origin):
    """Returns the exit code and the errors found."""
    folder = fresh(name)
    written = [output for output in outputs if output in runs[name][0]]
    try:
        try:
            done = start(folder, name, call, at, origin)
        except subprocess.TimeoutExpired:
            return "hang", "hangs" if origin == "own" else ""
        wrong = []
        if done.returncode not in codes[call] | (in_libraries if origin == "libraries" else set()):
            wrong.append(f"exit code {done.returncode}")
        if done.returncode > 0 and "tyndall: " not in done.stderr:
            wrong.append("without a message")
        for output in written:
            if not (folder / output).exists():
                wrong.append(f"{output} is gone")
            elif not is_whole(folder, name, output):
                wrong.append(f"{output} is torn")
            elif done.returncode == 0 and (folder / output).read_bytes() == b"old":
                wrong.append(f"{output} was not written, and nobody said so")
        left = {file.name for file in folder.iterdir()} - {"count", "c.tyn", *inputs[name]}
        if left and done.returncode != abort:
            wrong.append(f"left behind: {', '.join(sorted(left))}")
        if (folder / "c.tyn").exists():
            info = subprocess.run([program, "info", folder / "c.tyn"], capture_output=True, text=True)
            if info.returncode != 0:
                wrong.append(f"the checkpoint is damaged: {info.stderr}")
        if wrong:
            wrong.append(done.stderr.strip()[-300:])
        return done.returncode, "; ".join(wrong)
    finally:
        remove(folder)


def main():
    if not shim.exists():
        print("SKIPPED: the shim was not built")
        return 77
    for name in runs:
        if name == "resume" and not (volumes / "ball.vdb").exists():
            print("SKIPPED: resume: built without OpenVDB")
            continue
        inputs[name] = inputs_of(name)
        folder = fresh(name)
        done = start(folder, name)
        if done.returncode != 0:
            print(f"SKIPPED: the shim cannot be loaded here: {done.stderr.strip()}")
            return 77
        for output in outputs:
            reference[name, output] = (folder / output).read_bytes()
        remove(folder)

    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, call, origin in itertools.product(inputs, codes, ["own", "libraries"]):
            folder = fresh(name)
            start(folder, name, call, 0, origin)
            count = int((folder / "count").read_text())
            remove(folder)
            most = 150 if name == "render" else 50
            if "--all" in sys.argv or (origin == "own" and call != "malloc"):
                most = max(count, 1)
            step = max(1, count / most)
            places = sorted({1 + int(i * step) for i in range(min(count, most))})
            results = list(pool.map(lambda at: attempt(name, call, at, origin), places))
            seen = collections.Counter(code for code, _ in results)
            said = ", ".join(f"{n} x {'abort' if code == abort else code}" for code, n in sorted(seen.items(), key=str))
            if places:
                print(f"{name:6} {call:6} {origin:9} {len(places):6} of {count:6} calls failed: exit codes {said}", flush=True)
            for at, (_, wrong) in zip(places, results):
                if wrong:
                    print(f"  call {at}: {wrong}", flush=True)
                    failed = 1
    return failed


inputs = {}
reference = {}
sys.exit(main())
