"""Renders light.vdb, the output of `tyndall bake`, with Cycles, without scattering in Cycles.

  blender --background --factory-startup --python-exit-code 1 --python tools/blender/show_bake.py -- \\
      light.vdb picture.png [--scene scene.json] [--albedo A] [--exposure EV] [--samples N] [--width N]
"""
import argparse
import json
import math
import os
import re
import sys

import bpy
from mathutils import Matrix, Vector

# Up is y in Tyndall and z in Blender. A volume that Blender imports keeps the file's coordinates, so the object is
# rotated: +90 degrees about x take y to z, and z to -y. The camera is placed in Tyndall's coordinates and rotated with
# it, so that Tyndall's up is Blender's up in later work, too.
TO_BLENDER = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def arguments():
    parser = argparse.ArgumentParser(prog="show_bake.py")
    parser.add_argument("light", metavar="light.vdb", help="written by tyndall bake")
    parser.add_argument("picture", metavar="picture.png")
    parser.add_argument("--scene", metavar="scene.json", help="uses this scene's camera and background")
    parser.add_argument("--albedo", type=float, metavar="A", help="albedo of the medium (the file's grid, or 1)")
    parser.add_argument("--exposure", type=float, default=0, metavar="EV", help="brightness of the picture (0)")
    parser.add_argument("--samples", type=int, default=8, metavar="N", help="samples per pixel (8)")
    parser.add_argument("--width", type=int, metavar="N", help="width of the picture (the scene's, or 480)")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])


def read_scene(path):
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        # Removes comments from // to the end of the line; strings are kept.
        return json.loads(re.sub(r'("(?:[^"\\]|\\.)*")|//[^\n]*', lambda found: found.group(1) or "", text))
    except (OSError, ValueError) as error:
        sys.exit(f"show_bake: {path}: {error}")


def add_volume(path, albedo):
    """Adds the baked light as a medium that absorbs and emits."""
    bpy.ops.object.volume_import(filepath=os.path.abspath(path), align="WORLD", location=(0, 0, 0))
    volume = bpy.context.object
    if volume is None or not volume.data.grids.load():
        sys.exit(f"show_bake: {path}: cannot be read as OpenVDB")
    missing = {"density", "inscatter"} - {grid.name for grid in volume.data.grids}
    if missing:
        sys.exit(f"show_bake: {path}: no grid {' and '.join(sorted(missing))}: was it written by tyndall bake?")
    # In Cycles a voxel reaches from its index to the next one; in OpenVDB and Tyndall its centre is at the index. So the
    # volume is moved back by half a voxel of the density. The light's cells are wider: they stay shifted by half of the
    # difference.
    voxel = volume.data.grids["density"].matrix_object.to_3x3() @ Vector((1, 1, 1))
    volume.matrix_world = TO_BLENDER @ Matrix.Translation(-voxel / 2)

    material = bpy.data.materials.new("Baked light")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()

    def node(kind, **inputs):
        made = nodes.new(kind)
        for name, value in inputs.items():
            if isinstance(value, bpy.types.NodeSocket):
                links.new(value, made.inputs[name])
            else:
                made.inputs[name].default_value = value
        return made

    def grid(name):
        made = nodes.new("ShaderNodeAttribute")
        made.attribute_name = name
        return made

    density = grid("density")
    scattered = nodes.new("ShaderNodeVectorMath")
    scattered.operation = "MULTIPLY"
    links.new(grid("inscatter").outputs["Color"], scattered.inputs[0])
    if albedo is None and "albedo" in {grid.name for grid in volume.data.grids}:
        links.new(grid("albedo").outputs["Color"], scattered.inputs[1])
    else:
        scattered.inputs[1].default_value = (1 if albedo is None else albedo,) * 3
    # Black absorbs density x (1 - 0) per length, all of the extinction: the emission contains the scattered light.
    absorption = node("ShaderNodeVolumeAbsorption", Color=(0, 0, 0, 1), Density=density.outputs["Fac"])
    emission = node("ShaderNodeEmission", Color=scattered.outputs[0], Strength=density.outputs["Fac"])
    shaders = [absorption, emission]
    if "emission" in {grid.name for grid in volume.data.grids}:  # emission of the medium itself
        shaders.append(node("ShaderNodeEmission", Color=grid("emission").outputs["Color"], Strength=1))
    volumes = shaders[0].outputs[0]
    for shader in shaders[1:]:
        both = nodes.new("ShaderNodeAddShader")
        links.new(volumes, both.inputs[0])
        links.new(shader.outputs[0], both.inputs[1])
        volumes = both.outputs[0]
    node("ShaderNodeOutputMaterial", Volume=volumes)
    volume.data.materials.clear()
    volume.data.materials.append(material)
    # The file's extinction is per length of the world, independent of the object's scale.
    volume.data.render.space = "WORLD"
    return volume


def look_at(position, target, up):
    """Returns the matrix from camera to world in Tyndall's coordinates: the camera looks along -z, y is up."""
    back = (Vector(position) - Vector(target)).normalized()
    right = Vector(up).cross(back).normalized()
    return Matrix.Translation(position) @ Matrix((right, back.cross(right), back)).transposed().to_4x4()


def add_camera(scene, volume, width):
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit = "HORIZONTAL"  # Tyndall's fov and width are horizontal, independent of the height
    camera = bpy.data.objects.new("Camera", data)
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    seen = {"look_at": (0, 0, 0), "position": (-0.3, 0.2, -1), "fov": 40, "resolution": (480, 360)}
    if scene is not None:
        seen = scene.get("camera", {})
    kind = seen.get("type", "perspective")
    if kind == "spherical":
        sys.exit("show_bake: a spherical camera cannot be shown")
    if "matrix" in seen:
        m = seen["matrix"]
        pose = Matrix([m[0:4], m[4:8], m[8:12], m[12:16]])
    else:
        pose = look_at(seen.get("position", (0.5, 0.5, -2)), seen.get("look_at", (0.5, 0.5, 0.5)),
                       seen.get("up", (0, 1, 0)))
    camera.matrix_world = TO_BLENDER @ pose
    if kind == "orthographic":
        data.type, data.ortho_scale = "ORTHO", seen.get("width", 1)
    elif "focal_length" in seen:
        data.lens, data.sensor_width = seen["focal_length"], seen.get("film_width", 36)
    else:
        data.angle = math.radians(seen.get("fov", 45))
    data.clip_start, data.clip_end = 1e-4, 1e6
    size = seen.get("resolution", (512, 512))
    render = bpy.context.scene.render
    render.resolution_x = width or size[0]
    render.resolution_y = max(1, round(render.resolution_x * size[1] / size[0]))
    render.resolution_percentage = 100
    if scene is None:  # moves the camera back until the whole volume is visible
        graph = bpy.context.evaluated_depsgraph_get()
        box = [x for corner in volume.bound_box for x in volume.matrix_world @ Vector(corner)]
        camera.location = camera.camera_fit_coords(graph, box)[0]


def color(value):
    return Vector(value if isinstance(value, (list, tuple)) else (value,) * 3)


def add_background(scene):
    """Sets the background behind the medium: the scene's background plus its constant environments."""
    seen = Vector((0, 0, 0))
    if scene is not None:
        seen += color(scene.get("background", 0))
        for light in scene.get("lights", []):
            if light["type"] == "environment" and "image" not in light:
                seen += color(light.get("radiance", 1)) * light.get("scale", 1)
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*seen, 1)
    bpy.context.scene.world = world


def render(options):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = options.samples
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0  # all light is in the emission
    scene.cycles.volume_step_rate = 1  # steps as long as the finest voxels are wide
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform = "Standard"  # as Tyndall's PNGs; the default, Filmic, greys the whites
    scene.view_settings.look = "None"
    scene.view_settings.exposure = options.exposure
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.use_file_extension = False
    scene.render.filepath = os.path.abspath(options.picture)
    try:
        bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        sys.exit(f"show_bake: {error}")


def main():
    options = arguments()
    scene = read_scene(options.scene) if options.scene else None
    if not os.path.isfile(options.light):
        sys.exit(f"show_bake: {options.light}: no such file")
    bpy.ops.wm.read_factory_settings(use_empty=True)  # without the default cube, light and camera
    volume = add_volume(options.light, options.albedo)
    add_camera(scene, volume, options.width)
    add_background(scene)
    render(options)


main()
