#!/usr/bin/env bash
# Tests tools/blender with Blender: a baked cloud looks as in Tyndall; an exported .blend gives the picture and the
# brightness of Cycles; settings that cannot be exported cause warnings. Exits with 77 (skipped) without Blender.
set -euo pipefail
if ! command -v blender >/dev/null; then
  echo "SKIPPED: no blender here"
  exit 77
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
program=$(realpath "${TYNDALL_BINARY:-$root/build/release/tyndall}")
if [[ ! -e $(dirname "$program")/tyndall-vdb ]]; then
  echo "SKIPPED: built without OpenVDB"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
failed=0
complain() {
  echo "$*"
  failed=1
}

# in_blender SCRIPT ARGUMENT...: runs the script in an empty .blend, or in $blend
blend=--factory-startup
in_blender() {
  local script=$1
  shift
  timeout 300 blender "$blend" --background --python-exit-code 1 --python "$script" -- "$@" >out 2>err
}
must() {
  "$@" || { echo "failed: $*"; tail -n 20 out err; exit 1; }
}
has='import bpy; print("has", bpy.app.build_options.cycles and bpy.app.build_options.openvdb)'
must timeout 300 blender --factory-startup --background --python-expr "$has" >out 2>err
if ! grep -q '^has True' out; then
  echo "SKIPPED: this blender has no Cycles or no OpenVDB"
  exit 77
fi

# compare.py PICTURE EXPECTED.pfm EV CORRELATION: compares linear luminances; the second picture is brightened by EV and,
# like a PNG, clipped at 1. Uses only Python's standard library: Debian's Blender has no numpy.
cat >compare.py <<'END'
import array
import sys

import bpy

picture, expected, ev, limit = sys.argv[sys.argv.index("--") + 1:]
image = bpy.data.images.load(picture)
width, height = image.size
pixels = list(image.pixels)
is_png = picture.endswith(".png")
if is_png:
    pixels = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in pixels]
with open(expected, "rb") as file:
    head, size, _, body = file.read().split(b"\n", 3)
assert head == b"PF" and size.split() == [b"%d" % width, b"%d" % height], f"{size}, not {width} {height}"
colors = array.array("f", body)
if is_png:
    colors = [min(v * 2 ** float(ev), 1) for v in colors]


def luminance(values, channels):
    return [0.2126 * values[i] + 0.7152 * values[i + 1] + 0.0722 * values[i + 2]
            for i in range(0, len(values), channels)]


def correlation(a, b):
    mean_a, mean_b = sum(a) / len(a), sum(b) / len(b)
    return sum((x - mean_a) * (y - mean_b) for x, y in zip(a, b)) / (
        sum((x - mean_a) ** 2 for x in a) * sum((y - mean_b) ** 2 for y in b)) ** 0.5


ours, theirs = luminance(pixels, 4), luminance(colors, 3)
rows = [ours[i:i + width] for i in range(0, len(ours), width)]
likeness = correlation(ours, theirs)
mirrored = correlation([v for row in rows for v in reversed(row)], theirs)
upside_down = correlation([v for row in reversed(rows) for v in row], theirs)
ratio = sum(ours) / sum(theirs)
print(f"correlation {likeness:.4f} (mirrored {mirrored:.2f}, upside down {upside_down:.2f}), brightness {ratio:.3f}")
good = likeness >= float(limit) and likeness > max(mirrored, upside_down) + 0.02 and abs(ratio - 1) < 0.05
sys.exit(0 if good else 1)
END
compare() { # WHAT, and the arguments of compare.py
  local what=$1
  shift
  if in_blender compare.py "$@"; then
    echo "$what: $(grep correlation out)"
  else
    complain "$what differs: $(grep -h -e correlation -e Error out err || true)"
  fi
}

# ---- A bake, shown in Blender
scene=$root/scenes/lonely_cloud.json
options=(-D 'photons.illumination.resolution=[56,37,40]' -D 'camera.resolution=[128,96]')
must "$program" bake "$scene" "${options[@]}" --photons 1e6 --voxels 96 -o light.vdb >out 2>err
must in_blender "$root/tools/blender/show_bake.py" light.vdb shown.png --scene "$scene" \
  --exposure -1 --width 96
must "$program" render "$scene" -D 'camera.resolution=[96,96]' -D 'photons.illumination.resolution=[56,37,40]' \
  --photons 1e6 --samples 64 -o expected.pfm >out 2>err
compare "bake" shown.png expected.pfm -1 0.9

# ---- A .blend with a moved, rotated and scaled volume, a light of each kind, a sky, and a mesh that is not exported
cat >make.py <<'END'
import math
import os

import bpy
from mathutils import Euler, Vector

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
bpy.ops.object.volume_import(filepath=os.path.abspath("light.vdb"), align="WORLD", location=(0, 0, 0))
volume = bpy.context.object
volume.rotation_euler, volume.location, volume.scale = Euler((1.7, 0.2, 0.3)), (-1, 1, -1), (2, 2, 2)
material = bpy.data.materials.new("Cloud")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
shader, output = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
links.new(shader.outputs[0], output.inputs["Volume"])
for name, value in (("Color", (0.9, 0.8, 0.6, 1)), ("Density", 0.08), ("Anisotropy", 0.3)):
    shader.inputs[name].default_value = value
volume.data.materials.append(material)
bpy.context.view_layer.update()
middle = volume.matrix_world @ (sum((Vector(corner) for corner in volume.bound_box), Vector()) / 8)


def add(name, data, place):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.location = middle + Vector(place)
    thing.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()
    return thing


def light(kind, place, energy, **more):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    for key, value in more.items():
        setattr(data, key, value)
    return add(kind, data, place)


light("POINT", (2, -3, 1), 600, color=(1, 0.8, 0.6), shadow_soft_size=0)
light("SUN", (1, -1, 1), 1, angle=math.radians(5))
light("SPOT", (-1, -1, 4), 1000, spot_size=math.radians(40), spot_blend=0.5, shadow_soft_size=0)
light("AREA", (-2, 0, -1), 150, shape="RECTANGLE", size=0.5, size_y=1).scale = (2, 1, 1)
add("Stone", bpy.data.meshes.new("Stone"), (0, -50, 0))
scene.world = bpy.data.worlds.new("Sky")
scene.world.use_nodes = True
background = scene.world.node_tree.nodes["Background"]
background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.2, 0.5, 1, 1), 0.1
scene.camera = add("Camera", bpy.data.cameras.new("Camera"), (-1.5, -5, 1))
scene.camera.rotation_euler.rotate_axis("Z", 0.3)

scene.render.engine = "CYCLES"
scene.cycles.samples = 64
scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
scene.cycles.max_bounces = scene.cycles.volume_bounces = 64
scene.cycles.sample_clamp_indirect = 0
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 192, 144, 50
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = os.path.abspath("cycles.exr")
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("cloud.blend"))
bpy.ops.render.render(write_still=True)
END
export_scene=$root/tools/blender/export_scene.py
must in_blender make.py
blend=cloud.blend
must in_blender "$export_scene" exported.json
grep -q "warning: Stone: a mesh: not exported" err || complain "no warning for the mesh: $(cat err)"
grep -q '"light.vdb"' exported.json || complain "the volume's name is not relative: $(grep vdb exported.json)"
grep -q '"direction": \[-0.577[0-9]*, -0.577[0-9]*, -0.577' exported.json || complain "the sun does not shine down"
must "$program" validate exported.json >out 2>err
must "$program" render exported.json -D integrator=path --samples 128 -o exported.pfm >out 2>err
blend=--factory-startup
compare "export" cycles.exr exported.pfm 0 0.8

# ---- Nothing to export: an error message and no file
refuses() { # TEXT LINE-OF-PYTHON
  local status=0
  printf 'import bpy, runpy\n%s\nrunpy.run_path("%s")\n' "$2" "$export_scene" >refused.py
  in_blender refused.py refused.json || status=$?
  if ((status != 1)) || ! grep -q -- "$1" err || compgen -G 'refused.json*' >/dev/null; then
    complain "exit code $status, a file, or without '$1': $(cat err)"
  fi
}
refuses "nothing to export: the scene has no volume" ""
refuses "nothing to export: the scene has no camera" "bpy.context.scene.camera = None"
exit "$failed"
