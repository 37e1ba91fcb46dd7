#!/usr/bin/env python3
"""Damaged volumes give pictures or errors that name the file: no crash, no hang, no process left behind.

    damaged_volumes.py [MUTANTS]     mutants of each sample (default 60; the table of docs/volumes.md has 2000)

Renders with files in which bits are flipped, blocks zeroed or overwritten, or the end is cut.
"""

import collections
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SAMPLES = ("ball.vdb", "ball_uncompressed.vdb", "ball_blosc.nvdb", "ball.nvdb")
LONGEST = 60  # [s] longer is a hang


def flip(data, rng, bits):
    for _ in range(bits):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def overwrite(data, rng, new):
    at = rng.randrange(max(1, len(data) - len(new)))
    data[at:at + len(new)] = new[:len(data) - at]


MUTATIONS = {
    "1 bit flipped": lambda data, rng: flip(data, rng, 1),
    "16 bits flipped": lambda data, rng: flip(data, rng, 16),
    "64 bytes zeroed": lambda data, rng: overwrite(data, rng, bytes(64)),
    "4 bytes random": lambda data, rng: overwrite(data, rng, rng.randbytes(4)),
    "cut short": lambda data, rng: data.__delitem__(slice(rng.randrange(len(data)), None)),
}

OUTCOMES = (  # words of an error, and their name in the table
    ("crashed", "reader crashed"),
    ("given up", "too slow"),
    ("was stopped", "too slow"),
    ("more memory", "too large"),
    ("damaged", "damaged"),
    ("not a ", "not a volume"),
    ("its grids:", "no such grid"),
    ("nothing to render", "nothing in it"),
    ("version", "unknown version"),
    ("too dense", "too dense"),
)


def outcome(result, file):
    if result.returncode == 0:
        return "rendered, with a warning" if "warning" in result.stderr else "rendered"
    if result.returncode not in (3, 4):
        return None
    if result.returncode == 4 and str(file) not in result.stderr:
        return None
    return next((name for words, name in OUTCOMES if words in result.stderr), "another error")


def orphans():
    """Returns readers whose parent process has ended."""
    found = []
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            fields = dict(line.split(":\t", 1) for line in status.read_text(encoding="utf-8").splitlines() if ":\t" in line)
        except OSError:  # it has just ended
            continue
        if fields.get("Name") == "tyndall-vdb" and fields.get("PPid") == "1":
            found.append(status.parent.name)
    return found


def main():
    program, volumes = os.environ["TYNDALL_BINARY"], os.environ.get("TYNDALL_TEST_VOLUMES", "")
    if not Path(volumes, "ball.vdb").is_file():
        print("SKIPPED: built without OpenVDB")
        return 77
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    faults, slowest = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for sample in SAMPLES:
            whole = Path(volumes, sample).read_bytes()
            file, scene = Path(folder, "mutant" + Path(sample).suffix), Path(folder, "scene.json")
            scene.write_text(json.dumps({
                "tyndall": 1, "background": 1, "camera": {"resolution": [8, 8]}, "gather": {"samples": 1},
                "photons": {"count": 200, "illumination": {"resolution": 4}},
                "medium": {"components": [
                    {"field": {"type": "vdb", "file": str(file), "fit": "unit_cube"}, "extinction": 20}]},
                "lights": [{"type": "environment", "radiance": 1}]}), encoding="utf-8")
            rng, table = random.Random(sample), collections.Counter()
            for i in range(count):
                kind = list(MUTATIONS)[i % len(MUTATIONS)]
                mutant = bytearray(whole)
                MUTATIONS[kind](mutant, rng)
                file.write_bytes(mutant)
                start = time.monotonic()
                result = subprocess.run([program, "render", str(scene), "-o", str(Path(folder, "picture.pfm"))],
                                        capture_output=True, text=True, check=False)
                seconds = time.monotonic() - start
                slowest = max(slowest, seconds)
                name = outcome(result, file)
                table[name] += 1
                if name is None or seconds > LONGEST:
                    faults.append(f"{sample}, mutant {i} ({kind}): exit {result.returncode} after {seconds:.1f} s: "
                                  f"{result.stderr[-300:]}")
            print(f"{sample}: " + ", ".join(f"{n} {name}" for name, n in table.most_common()))
    if left := orphans():
        faults.append(f"readers were left behind: {left}")
    print(f"slowest: {slowest:.2f} s")
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
