#!/usr/bin/env python3
"""Includes point down: no file includes one of a floor above it, and outside libraries stay where they belong.

    base < random < medium < transport < scene < render (include/tyndall) < src/scene < src/render
        < {src/host, src/io, cuda} < src/session < {src/app, src/python}

The four lowest floors are compiled for devices too: no allocation, no exceptions, no streams, no file formats.
"""

import os
import re
import sys
from pathlib import Path

ROOT = Path(os.environ.get("TYNDALL_SOURCE_DIR", Path(__file__).resolve().parents[2]))

# Folder -> rank; folders of one rank do not include each other. The longest prefix of a path counts.
RANK = {
    "include/tyndall/base": 0,
    "include/tyndall/random": 1,
    "include/tyndall/medium": 2,
    "include/tyndall/transport": 3,
    "include/tyndall/scene": 3.5,
    "include/tyndall/render": 4,
    "src/scene": 4.5,
    "src/render": 5,
    "include/tyndall/host": 6,
    "include/tyndall/io": 6,
    "include/tyndall/cuda": 6,
    "src/host": 7,
    "src/io": 7,
    "src/mpi": 7,
    "cuda": 7,
    "src/session": 8,
    "src/app": 9,
    "src/python": 9,
    "bench": 8,
}
# Backends and readers: the public headers and the sources of each are one unit; units do not include each other.
UNITS = {"host": ("include/tyndall/host", "src/host"), "io": ("include/tyndall/io", "src/io"),
         "cuda": ("include/tyndall/cuda", "cuda"), "mpi": ("src/mpi",)}
DEVICE_FLOORS = ("base", "random", "medium", "transport")

# Headers that the device floors must not include.
HOST_ONLY = re.compile(
    r"(exception|fstream|functional|iomanip|iosfwd|iostream|istream|map|memory|mutex|ostream|sstream"
    r"|stdexcept|string|string_view|thread|unordered_map|vector)$"
    r"|(openvdb|OpenEXR|Imath|Imf|OpenImageIO|OpenImageDenoise|nlohmann|fmt|CLI|tbb|oneapi)[/A-Z.]")
# At most one source file under src/io and one of the helper include each of these. One header may include JSON, because the
# table of keys consists of JSON values; only src/io may include that header.
IO_LIBRARIES = {
    "OpenVDB": re.compile(r"openvdb/|nanovdb/tools|nanovdb/util/OpenToNanoVDB"),
    "OpenEXR": re.compile(r"(OpenEXR|Imath)/|Imf\w*\.h$"),
    "OpenImageIO": re.compile(r"OpenImageIO/"),
    "OpenImageDenoise": re.compile(r"OpenImageDenoise/"),
    "nlohmann-json": re.compile(r"nlohmann/"),
}
JSON_HEADERS = ("src/io/json_text.h", "src/io/json_table.h")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def folder_of(path):
    """Returns the ranked folder that contains a path (relative to the root), or None."""
    found = [folder for folder in RANK if path.startswith(folder + "/")]
    return max(found, key=len, default=None)


def unit_of(folder):
    return next((name for name, folders in UNITS.items() if folder in folders), None)


def resolve(source, name):
    """Returns the file of this repository that an #include names, relative to the root; None for outside headers."""
    for base in (source.parent, ROOT / "include", ROOT / "src", ROOT / "tests", ROOT):
        candidate = (base / name).resolve()
        if candidate.is_file() and candidate.is_relative_to(ROOT):
            return candidate.relative_to(ROOT).as_posix()
    return None


def main():
    faults = []
    users = {library: set() for library in IO_LIBRARIES}
    files = [path for top in ("include", "src", "cuda", "bench") for path in sorted((ROOT / top).rglob("*"))
             if path.suffix in (".h", ".cpp", ".cu", ".cuh")]
    for path in files:
        name = path.relative_to(ROOT).as_posix()
        folder = folder_of(name)
        if folder is None:
            faults.append(f"{name}: is on no known floor (see RANK)")
            continue
        for match in INCLUDE.finditer(path.read_text(encoding="utf-8")):
            header = match[2]
            for library, pattern in IO_LIBRARIES.items():
                if pattern.match(header):
                    users[library].add(name)
            target = resolve(path, header)
            if target is None:
                if folder.split("/")[-1] in DEVICE_FLOORS and folder.startswith("include/") and HOST_ONLY.match(header):
                    faults.append(f"{name}: <{header}> does not belong on a floor that devices compile")
                if match[1] == '"':
                    faults.append(f'{name}: "{header}" is not in this repository: write <{header}>')
                continue
            if target in JSON_HEADERS and folder != "src/io":
                faults.append(f"{name}: includes {target}, which src/io keeps to itself")
            target_folder = folder_of(target)
            if target_folder is None or target_folder == folder:
                continue
            if RANK[target_folder] > RANK[folder]:
                faults.append(f"{name}: includes {target}, which is above it")
            units = {unit_of(folder), unit_of(target_folder)} - {None}
            same_rank = RANK[target_folder] == RANK[folder]
            if len(units) == 2 or (same_rank and len(units) != 1):
                faults.append(f"{name}: includes {target}, which it must not know")

    for library, names in users.items():
        in_helper = {n for n in names if n.startswith("src/io/helper/")}  # a separate program
        if len(in_helper) > 1 or len(names - in_helper) > 1 or any(
                not (n in JSON_HEADERS or re.match(r"src/io/.*\.cpp$", n)) for n in names):
            faults.append(f"{library} must be known to one source of src/io and one of its helper, not to: "
                          f"{', '.join(sorted(names))}")
    if not files:
        faults.append("no sources found")
    print("\n".join(faults) if faults else f"{len(files)} files: includes point down")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
