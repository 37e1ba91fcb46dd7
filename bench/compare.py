#!/usr/bin/env python3
"""Compares Tyndall and Mitsuba 3 on one cloud: error against a reference, and processor seconds.

Makes a scene of a cube of densities (sigma_t = SCALE x density, isotropic, before a point light of
10 W/sr), renders it with each of the settings and seeds, and prints a table. The runs are interleaved,
so that other load on the machine affects all settings alike. CPU is user seconds of the whole process
and its children, set-up included. Error is the root mean square of picture minus reference over the
mean of the reference, with the reference's own noise removed. As long as the error is noise,
error^2 x CPU is a renderer's cost for a given error, independent of the number of samples.

  bench/compare.py --grid cloud.npy --reference reference.npz --work /tmp/compare \\
      --tyndall='-D integrator=path --samples 16' --tyndall='--photons 1e6 --samples 16' --mitsuba 4

It requires numpy, and with --mitsuba the package mitsuba (pip install mitsuba numpy): docs/comparison.md."""
import argparse
import json
import os
import shlex
import subprocess
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grid", required=True, metavar="FILE",
                        help="densities of n^3 voxels of the unit cube, x fastest: .npy, or raw 32-bit floats")
    parser.add_argument("--reference", required=True, metavar="FILE",
                        help=".npz: img (height x width), rel_err (relative error of its noise)")
    parser.add_argument("--work", required=True, metavar="FOLDER", help="folder for scene, grids and pictures")
    parser.add_argument("--scale", type=float, default=270, help="extinction at density 1 (270)")
    parser.add_argument("--albedo", type=float, default=0.99, help="single-scattering albedo (0.99)")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="runs of each setting (3)")
    parser.add_argument("--tyndall", action="append", default=[], metavar="OPTIONS",
                        help="options of `tyndall render`; may be repeated, one setting each")
    parser.add_argument("--mitsuba", action="append", default=[], type=int, metavar="SPP",
                        help="samples per pixel of Mitsuba; may be repeated")
    parser.add_argument("--mitsuba-seeds", type=int, metavar="N", help="runs of each --mitsuba (as --seeds)")
    parser.add_argument("--variant", default="scalar_rgb", help="variant of Mitsuba (scalar_rgb)")
    parser.add_argument("--python", default=sys.executable, metavar="FILE",
                        help="Python interpreter with Mitsuba (this one)")
    parser.add_argument("--binary", default=os.path.join(ROOT, "build/release/tyndall"), metavar="FILE",
                        help="tyndall (build/release/tyndall)")
    parser.add_argument("--json", metavar="FILE", help="writes all runs")
    parser.add_argument("--sheet", metavar="FILE.png",
                        help="writes the reference and each setting's picture of seed 1 above their differences: "
                        "red too bright, blue too dark, saturated at the mean of the reference (needs pillow)")
    return parser.parse_args()


def make_scene(a, size):
    """Returns the path of the scene; its grid lies beside it."""
    densities = np.load(a.grid) if a.grid.endswith(".npy") else np.fromfile(a.grid, "<f4")
    n = round(densities.size ** (1 / 3))
    if n ** 3 != densities.size:
        sys.exit(f"{a.grid}: expected n^3 densities, got {densities.size}")
    densities.astype("<f4").tofile(os.path.join(a.work, "cloud.raw"))
    scene = {
        "tyndall": 1,
        "medium": {"components": [{"field": {"type": "grid", "size": [n, n, n], "file": "cloud.raw"},
                                   "extinction": a.scale, "albedo": a.albedo}]},
        "lights": [{"type": "point", "position": [1.5, 1.8, -0.5], "intensity": 10}],
        "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "fov": 45, "resolution": size}}
    path = os.path.join(a.work, "cloud.json")
    with open(path, "w") as file:
        json.dump(scene, file, indent=1)
    return path


def user_seconds(command):
    """Runs a command; returns the user CPU seconds of it and its children."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    messages = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{shlex.join(command)}: exit code {process.returncode}\n{messages}")
    return usage.ru_utime


def green(path):
    """Returns the green channel of a .npy or .pfm picture, rows from the top."""
    if path.endswith(".npy"):
        return np.load(path)[..., 1].astype(np.float64)
    with open(path, "rb") as file:
        kind, size, scale = (file.readline().split() for _ in range(3))
        width, height = map(int, size)
        if kind != [b"PF"]:
            sys.exit(f"{path}: not a .pfm picture in colour")
        values = np.frombuffer(file.read(), "<f4" if float(scale[0]) < 0 else ">f4")
    return values.reshape(height, width, 3)[::-1, :, 1].astype(np.float64)


def save_sheet(path, reference, pictures):
    """Saves the pictures in a row, the reference first, above their differences from it."""
    from PIL import Image
    exposure = np.quantile(reference[reference > 0], 0.98)
    part = tuple(slice(lit.min(), lit.max() + 1) for lit in np.nonzero(reference > 0.01 * exposure))
    mean = reference.mean()
    reference, *pictures = [picture[part] for picture in (reference, *pictures)]
    top, bottom = [], []
    for picture in [reference, *pictures]:
        shown = np.clip(picture / exposure, 0, 1) ** (1 / 2.2)
        off = np.clip((picture - reference) / mean, -1, 1)
        top.append(np.repeat(shown[..., None], 3, axis=2))
        bottom.append(np.stack([1 - np.maximum(-off, 0), 1 - np.abs(off), 1 - np.maximum(off, 0)], axis=2))
    sheet = np.concatenate([np.concatenate(top, axis=1), np.concatenate(bottom, axis=1)])
    Image.fromarray(np.round(255 * sheet).astype(np.uint8)).save(path)


def main():
    a = arguments()
    os.makedirs(a.work, exist_ok=True)
    with np.load(a.reference) as file:
        reference, own = file["img"].astype(np.float64), float(file["rel_err"])
    scene = make_scene(a, [reference.shape[1], reference.shape[0]])
    script = os.path.join(a.work, "cloud.py")
    if a.mitsuba:
        subprocess.run([a.binary, "convert", scene, "-o", script], check=True, stderr=subprocess.DEVNULL)

    def tyndall(options):
        return lambda seed, to: [a.binary, "render", scene, *shlex.split(options), "--seed", str(seed), "-o", to]

    def mitsuba(spp):
        return lambda seed, to: [a.python, script, "--variant", a.variant, "--spp", str(spp),
                                 "--seed", str(seed), "-o", to]

    settings = [("Tyndall", options, tyndall(options), "pfm", a.seeds) for options in a.tyndall]
    settings += [("Mitsuba " + a.variant, f"{spp} spp", mitsuba(spp), "npy", a.mitsuba_seeds or a.seeds)
                 for spp in a.mitsuba]
    runs = []
    for seed in range(1, max((s[-1] for s in settings), default=0) + 1):
        for i, (renderer, setting, command, extension, seeds) in enumerate(settings):
            if seed > seeds:
                continue
            to = os.path.join(a.work, f"picture-{i}-{seed}.{extension}")
            cpu = user_seconds(command(seed, to))
            picture = green(to)
            np.save(os.path.join(a.work, f"green-{i}-{seed}.npy"), picture.astype(np.float32))
            error = np.sqrt(np.mean((picture - reference) ** 2)) / reference.mean()
            runs.append({"renderer": renderer, "setting": setting, "seed": seed, "cpu_s": cpu,
                         "error": np.sqrt(max(0.0, error ** 2 - own ** 2)),
                         "ratio": picture.mean() / reference.mean()})
            print(f"{renderer} {setting}, seed {seed}: {cpu:.2f} s, error {runs[-1]['error']:.4f}", file=sys.stderr)

    print("| renderer | settings | runs | CPU [s] | error | mean ratio | error² x CPU [s] |\n|---|---|---|---|---|---|---|")
    for renderer, setting, _, _, _ in settings:
        mine = [r for r in runs if (r["renderer"], r["setting"]) == (renderer, setting)]
        cpu, ratio = (np.mean([r[key] for r in mine]) for key in ("cpu_s", "ratio"))
        square = np.mean([r["error"] ** 2 for r in mine])
        print(f"| {renderer} | `{setting}` | {len(mine)} | {cpu:.2f} | {np.sqrt(square):.4f} | {ratio:.4f} "
              f"| {square * cpu:.3f} |")
    if a.sheet:
        save_sheet(a.sheet, reference, [np.load(os.path.join(a.work, f"green-{i}-1.npy")) for i in range(len(settings))])
    if a.json:
        with open(a.json, "w") as file:
            json.dump({"grid": a.grid, "scale": a.scale, "albedo": a.albedo, "reference": a.reference,
                       "runs": runs}, file, indent=1)


if __name__ == "__main__":
    main()
