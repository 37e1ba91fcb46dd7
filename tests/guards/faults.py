#!/usr/bin/env python3
"""Lets every call that can fail fail once, one a run: the exit code tells what it was, files are whole or as they were.

  faults.py [--all]     --all: every allocation of the program, not a sample of them

tests/support/faults/fail_call.cpp makes one call of a small render fail. Own calls of open, write, fsync, rename and
mmap fail one after the other, until a render passes untouched; of allocations, and of calls within libraries, a sample
that is the same in every run; oneTBB aborts in some of them and hangs, rarely: both are counted. Ends with 77 (skipped) where the shim cannot be loaded, as under sanitizers.
"""
import collections
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile

program = os.environ["TYNDALL_BINARY"]
shim = pathlib.Path(os.environ["TYNDALL_BUILD_DIR"]) / "tests" / "fail-call.so"
scene = """{"tyndall": 1,
 "medium": {"components": [{"field": {"type": "sphere", "radius": 0.4}, "extinction": 10, "albedo": 0.9}]},
 "lights": [{"type": "point", "position": [1.5, 2, 0.5], "power": 100}],
 "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "resolution": [16, 16]},
 "photons": {"count": 1000, "illumination": {"resolution": 8}}, "gather": {"samples": 2}}"""
outputs = ["a.pfm", "a.tyn", "r.json"]
# What may come of it: an exit code that names the cause, or 0 where it does not matter (a lost line on stderr, another
# way to the same memory).
codes = {
    "malloc": {0, 6},
    "open": {0, 4, 5},
    "write": {0, 5},
    "read": {0, 3, 4},
    "fsync": {0, 5},
    "rename": {0, 5},
    "mmap": {0, 6},
}
# Within a library that allows nothing else, or reports a stream without memory as a file that cannot be read: counted.
abort = -6
in_libraries = {abort, 4}


def render(folder, call="", at=0, origin="all"):
    environment = {**os.environ, "LD_PRELOAD": str(shim), "FAIL_CALL": call, "FAIL_AT": str(at), "FAIL_FROM": origin,
                   "FAIL_COUNT": str(folder / "count")}
    arguments = ["render", "scene.json", "--threads", "1", "--checkpoint", "c.tyn", "--checkpoint-every", "0"]
    for output in outputs[:2]:
        arguments += ["-o", output]
    return subprocess.run([program, *arguments, "--report", "r.json"], cwd=folder, env=environment, capture_output=True,
                          text=True, timeout=20)


def fresh():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tyndall-faults-"))
    (folder / "scene.json").write_text(scene)
    for output in outputs:
        (folder / output).write_text("old")
    return folder


def remove(folder):
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()


def is_whole(folder, output):
    data = (folder / output).read_bytes()
    # Times and the order of checkpoints may differ, what was rendered may not.
    return data == b"old" or output == "r.json" and data.endswith(b"}\n") or data == reference[output]


def attempt(call, at, origin):
    """Returns the exit code and what is wrong."""
    folder = fresh()
    try:
        try:
            done = render(folder, call, at, origin)
        except subprocess.TimeoutExpired:
            return "hang", "hangs" if origin == "own" else ""
        wrong = []
        if done.returncode not in codes[call] | (in_libraries if origin == "libraries" else set()):
            wrong.append(f"exit code {done.returncode}")
        if done.returncode > 0 and "tyndall: " not in done.stderr:
            wrong.append("without a word")
        for output in outputs:
            if not (folder / output).exists():
                wrong.append(f"{output} is gone")
            elif not is_whole(folder, output):
                wrong.append(f"{output} is torn")
            elif done.returncode == 0 and (folder / output).read_bytes() == b"old":
                wrong.append(f"{output} was not written, and nobody said so")
        left = {file.name for file in folder.iterdir()} - {"scene.json", "count", "c.tyn", *outputs}
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
    folder = fresh()
    done = render(folder)
    if done.returncode != 0:
        print(f"SKIPPED: the shim cannot be loaded here: {done.stderr.strip()}")
        return 77
    for output in outputs:
        reference[output] = (folder / output).read_bytes()
    remove(folder)

    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for call in codes:
            for origin in ["own", "libraries"]:
                folder = fresh()
                render(folder, call, 0, origin)
                count = int((folder / "count").read_text())
                remove(folder)
                most = max(count, 1) if "--all" in sys.argv or (origin == "own" and call != "malloc") else 150
                step = max(1, count / most)
                places = sorted({1 + int(i * step) for i in range(min(count, most))})
                results = list(pool.map(lambda at: attempt(call, at, origin), places))
                seen = collections.Counter(code for code, _ in results)
                said = ", ".join(f"{n} x {'abort' if code == abort else code}" for code, n in sorted(seen.items(), key=str))
                if places:
                    print(f"{call:7} {origin:9} {len(places):6} of {count:6} calls failed: exit codes {said}", flush=True)
                for at, (_, wrong) in zip(places, results):
                    if wrong:
                        print(f"  call {at}: {wrong}", flush=True)
                        failed = 1
    return failed


reference = {}
sys.exit(main())
