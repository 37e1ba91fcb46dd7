"""Tyndall: clouds, smoke and fog with multiple scattering.

    import numpy, tyndall
    scene = {"tyndall": 1,
             "medium": {"components": [{"field": {"type": "grid", "values": numpy.random.rand(64, 64, 64)},
                                        "extinction": 20, "albedo": 0.99}]},
             "lights": [{"type": "directional", "direction": [1, -1, 0.5], "irradiance": 3}]}
    result = tyndall.render(scene, progress=print)
    result.picture       # float32 [height][width][4], linear RGB and alpha

A scene is the path of a scene file, or a dict with the keys of one (`schema()` lists them with units and ranges).
A dict may hold a grid's values as an array [nz][ny][nx] instead of the name of a raw file.
"""
import dataclasses
import json
import operator
import os
import tempfile

import numpy

from . import _core

__version__ = _core.version
__all__ = ["render", "bake", "validate", "schema", "devices", "Result", "Light", "Error"]


class Error(RuntimeError):
    """An error, with the message of the command line and its exit code in `code`."""

    def __init__(self, message, code=1):
        super().__init__(message)
        self.code = code


@dataclasses.dataclass
class Result:
    picture: numpy.ndarray  #: float32 [height][width][4]: linear radiance, alpha; premultiplied, from the top left
    layers: dict            #: of float32 arrays [height][width][channels]: "variance", "depth", "single", ...
    tallies: str            #: hash of the tallies, the same on every machine
    pixels: str             #: hash of the picture
    facts: dict             #: the entries of a picture's header: ledger, ranges, noise
    warnings: list


@dataclasses.dataclass
class Light:
    """Baked light (docs/bake.md). Cells are [nz][ny][nx]. The dicts have the names of the lights as keys, or "all"."""
    low: tuple              #: corner of the box, in world space
    high: tuple
    fluence: dict           #: of float32 [nz][ny][nx][3]: radiance, integrated over all directions [W/area]
    slope: dict             #: of three such arrays, along x, y, z; empty without directions
    albedo: numpy.ndarray   #: float32 [nz][ny][nx][3]
    relative_error: numpy.ndarray  #: float32 [nz][ny][nx], of the fluence
    facts: dict
    warnings: list


def _array(values, where, folder):
    """Writes a grid's values to a file. Returns its path and its size, x first."""
    if values.ndim != 3:
        raise Error(f"{where}: expected an array [nz][ny][nx], got one of {values.ndim} dimensions", 3)
    if values.dtype.kind not in "biuf":
        raise Error(f"{where}: expected an array of numbers, got one of {values.dtype}", 3)
    path = os.path.join(folder, f"{len(os.listdir(folder))}.raw")
    numpy.ascontiguousarray(values, dtype="<f4").tofile(path)
    return path, list(values.shape[::-1])


def _with_arrays(value, folder, where):
    """Returns a copy of `value` for JSON, with the arrays of grids written to files."""
    if isinstance(value, numpy.ma.MaskedArray):
        value = value.filled(0)
    if isinstance(value, (list, tuple)):
        return [_with_arrays(v, folder, f"{where}[{i}]") for i, v in enumerate(value)]
    if isinstance(value, numpy.generic):
        return value.item()
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fsdecode(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if not isinstance(value, dict):
        raise Error(f"{where}: a {type(value).__name__}: expected dicts, lists, arrays, numbers and texts", 3)
    out = {}
    for key, v in value.items():
        place = f"{where}.{key}"
        if key != "values" or not isinstance(v, numpy.ndarray):
            out[key] = _with_arrays(v, folder, place)
            continue
        values = v.filled(0) if isinstance(v, numpy.ma.MaskedArray) else v
        out["file"], size = _array(values, place, folder)
        given = _with_arrays(value.get("size", size), folder, f"{where}.size")
        if given != size:
            raise Error(f"{where}.size: {given} is not that of the array, {size} ([nx, ny, nz]): leave it out", 3)
        out["size"] = size
    return out


def _bytes(name, value):
    """Encodes a str as on the command line: the inverse of os.fsdecode()."""
    try:
        return os.fsencode(value)
    except UnicodeError as error:
        raise Error(f"{name}: no text that a file could have: {error}", 2) from None


def _prepared(scene, overrides, folder):
    """Returns name, text and folder of a scene, and its overrides, all as bytes."""
    if not isinstance(overrides or {}, dict):
        raise Error(f"overrides: expected a dict such as {{\"camera.fov\": 30}}, got a {type(overrides).__name__}", 2)
    texts = [_bytes(f"overrides[{key!r}]",
                    f"{key}={value if isinstance(value, str) else json.dumps(_with_arrays(value, folder, key))}")
             for key, value in (overrides or {}).items()]
    if isinstance(scene, dict):
        text = json.dumps(_with_arrays(scene, folder, "scene"), indent=1).encode()
        try:
            return b"scene", text, os.getcwdb(), texts
        except OSError as error:
            raise Error(f"scene: no current folder, where its files are: {error.strerror}", 4) from None
    if not isinstance(scene, (str, bytes, os.PathLike)):
        raise Error(f"scene: expected a dict or the path of a file, got a {type(scene).__name__}", 2)
    path = _bytes("scene", scene)
    try:
        with open(path, "rb") as file:
            return path, file.read(), os.path.dirname(path), texts
    except OSError as error:
        raise Error(f"{os.fsdecode(path)}: {error.strerror}", 4) from None


def _call(function, scene, overrides, *arguments):
    try:
        folder = tempfile.TemporaryDirectory(prefix="tyndall-")
    except OSError as error:
        raise Error(f"no folder for arrays: {error}", 5) from error
    with folder as name:
        try:
            prepared = _prepared(scene, overrides, name)
        except Error:
            raise
        except MemoryError as error:
            raise Error(f"out of memory: {error}", 6) from error
        except OSError as error:
            raise Error(f"arrays could not be written for the reader: {error}", 5) from error
        except Exception as error:  # the scene has keys, strings or numbers that JSON cannot hold
            raise Error(f"scene: {error}", 3) from error
        return function(*prepared, *arguments)


def _integer(name, value, most):
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if not 0 <= number <= most:
        raise Error(f"{name}: expected an integer in [0, {most}], got {value!r}", 2)
    return number


def _work(device, threads, progress):
    """Checks the arguments that render() and bake() share and returns them for _core."""
    if not isinstance(device, str):
        raise Error(f"device: expected a text such as \"cpu\", got {device!r}", 2)
    if progress is not None and not callable(progress):
        raise Error(f"progress: expected a function, got {progress!r}", 2)

    def goes_on(name, fraction):
        answer = progress(name, fraction)
        return answer is None or bool(answer)  # a function without a return statement returns None
    return _bytes("device", device), _integer("threads", threads, 4096), None if progress is None else goes_on


def render(scene, overrides=None, *, device="auto", threads=0, progress=None):
    """Renders `scene`. `overrides`: {"camera.fov": 30}. `progress(pass, fraction)` is called periodically; if it returns
    a false value other than None, KeyboardInterrupt is raised. Raises Error."""
    return Result(**_call(_core.render, scene, overrides, *_work(device, threads, progress)))


def bake(scene, overrides=None, *, order=1, per_light=False, multiple_only=False, device="auto", threads=0,
         progress=None):
    """Shoots the photons of `scene` and returns their Light. `order` 0: without directions. `multiple_only`: without
    single scattering. Raises Error."""
    return Light(**_call(_core.bake, scene, overrides, *_work(device, threads, progress),
                         _integer("order", order, 1) > 0, bool(per_light), bool(multiple_only)))


def validate(scene, overrides=None):
    """Returns the warnings about a scene. Raises Error with all its errors, one per line."""
    return _call(_core.validate, scene, overrides)


def schema():
    """Returns the JSON Schema of scenes as a dict."""
    return json.loads(_core.schema())


def devices():
    """Returns the list of devices, one per line."""
    return _core.devices()
