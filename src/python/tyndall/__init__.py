"""Tyndall: clouds, smoke and fog with multiple scattering.

    import numpy, tyndall
    scene = {"tyndall": 1,
             "medium": {"components": [{"field": {"type": "grid", "values": numpy.random.rand(64, 64, 64)},
                                        "extinction": 20, "albedo": 0.99}]},
             "lights": [{"type": "directional", "direction": [1, -1, 0.5], "irradiance": 3}]}
    result = tyndall.render(scene, progress=print)
    result.picture       # float32 [height][width][4], linear RGB and alpha

A scene is a dict with the keys of scene files (`schema()` has all of them, with units and ranges), or the path of such a
file. Where a scene file names a raw file of a grid's values, a dict may hold the array itself: [nz][ny][nx].
"""
import dataclasses
import json
import os
import tempfile

import numpy

from . import _core

__version__ = _core.version
__all__ = ["render", "bake", "validate", "schema", "devices", "Result", "Light", "Error"]


class Error(RuntimeError):
    """What the command line would say, and its exit code in `code`."""

    def __init__(self, message, code=1):
        super().__init__(message)
        self.code = code


@dataclasses.dataclass
class Result:
    picture: numpy.ndarray  #: float32 [height][width][4]: linear radiance, alpha; premultiplied, from the top left
    layers: dict            #: of float32 arrays [height][width][channels]: "variance", "depth", "single", ...
    tallies: str            #: hash of all that was counted, the same on every machine
    pixels: str             #: hash of the picture
    facts: dict             #: what a picture's header says: the ledger, ranges, noise
    warnings: list


@dataclasses.dataclass
class Light:
    """Baked light (docs/bake.md). Cells are [nz][ny][nx]; each light by itself by its name, or "all"."""
    low: tuple              #: corner of the box, in world space
    high: tuple
    fluence: dict           #: of float32 [nz][ny][nx][3]: radiance, integrated over all directions [W/area]
    slope: dict             #: of three such arrays, along x, y, z; empty without directions
    albedo: numpy.ndarray   #: float32 [nz][ny][nx][3]
    relative_error: numpy.ndarray  #: float32 [nz][ny][nx], of the fluence
    facts: dict
    warnings: list


def _with_arrays(value, folder):
    """The same with files in the place of arrays, and other files' names from the root."""
    if isinstance(value, (list, tuple)):
        return [_with_arrays(v, folder) for v in value]
    if isinstance(value, numpy.generic):
        return value.item()
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if not isinstance(value, dict):
        raise Error(f"scene: a {type(value).__name__}: expected dicts, lists, arrays, numbers and texts", 3)
    out = {key: _with_arrays(v, folder) for key, v in value.items()
           if not (key == "values" and isinstance(v, numpy.ndarray))}
    values = value.get("values")
    if isinstance(values, numpy.ndarray):
        if values.ndim != 3:
            raise Error(f"scene: values: expected an array [nz][ny][nx], got one of {values.ndim} dimensions", 3)
        path = os.path.join(folder, f"{len(os.listdir(folder))}.raw")
        numpy.ascontiguousarray(values, dtype="<f4").tofile(path)
        out["file"] = path
        out.setdefault("size", list(values.shape[::-1]))
    return out


def _call(function, scene, overrides, *arguments):
    overrides = [f"{key}={value if isinstance(value, str) else json.dumps(_with_arrays(value, ''))}"
                 for key, value in (overrides or {}).items()]
    if not isinstance(scene, dict):
        path = os.fspath(scene)
        try:
            with open(path, encoding="utf-8") as file:
                text = file.read()
        except OSError as error:
            raise Error(f"{path}: {error.strerror}", 4) from None
        return function(path, text, os.path.dirname(path), overrides, *arguments)
    with tempfile.TemporaryDirectory(prefix="tyndall-") as folder:
        text = json.dumps(_with_arrays(scene, folder), indent=1)
        return function("scene", text, os.getcwd(), overrides, *arguments)


def _progress(callback):
    # True goes on, and so does None, which functions return that return nothing.
    return callback and (lambda name, share: callback(name, share) is not False)


def render(scene, overrides=None, *, device="auto", threads=0, progress=None):
    """Renders `scene`. `overrides`: {"camera.fov": 30}. `progress(pass, share)` is called now and then; where it returns
    False, KeyboardInterrupt is raised. Raises Error."""
    return Result(**_call(_core.render, scene, overrides, device, threads, _progress(progress)))


def bake(scene, overrides=None, *, order=1, per_light=False, device="auto", threads=0, progress=None):
    """Shoots the photons of `scene` and returns their Light. `order` 0: without directions. Raises Error."""
    return Light(**_call(_core.bake, scene, overrides, device, threads, _progress(progress), order > 0, per_light))


def validate(scene, overrides=None):
    """Returns the warnings about a scene. Raises Error with all that is wrong with it, one per line."""
    return _call(_core.validate, scene, overrides)


def schema():
    """The JSON Schema of scenes, as a dict."""
    return json.loads(_core.schema())


def devices():
    """What can render, one per line."""
    return _core.devices()
