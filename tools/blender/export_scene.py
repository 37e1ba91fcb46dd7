"""Writes the scene of a .blend as a scene of Tyndall: volumes, camera, lights, sky.

  blender file.blend --background --python-exit-code 1 --python tools/blender/export_scene.py -- scene.json

Warnings on stderr name each object with settings that cannot be exported. docs/blender.md lists the conversions.
"""
import json
import math
import os
import re
import sys

import bpy
from mathutils import Matrix, Vector

# Up is z in Blender and y in Tyndall: -90 degrees about x take z to y, and y to -z. All positions are rotated by it.
TO_TYNDALL = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))

# For a volume without a supported material: Blender's own default, a Principled Volume.
DEFAULT_MEDIUM = {"density": {"extinction": (1, 1, 1), "scattering": (0.5, 0.5, 0.5), "lobe": (0, 0, 0)}}

UNSEEN = {"ARMATURE", "CAMERA", "EMPTY", "LATTICE", "LIGHT", "LIGHT_PROBE", "SPEAKER", "VOLUME"}  # not exported as missing geometry


def warn(name, what):
    print(f"export_scene: warning: {name}: {what}", file=sys.stderr)


def fail(what):
    sys.exit(f"export_scene: {what}")


def number(value):
    return float(f"{value:.7g}") + 0.0  # as many digits as Blender's floats have; + 0.0 makes 0 of -0


def numbers(values):
    return [number(value) for value in values]


def file_name(path, folder):
    """Returns a path relative to the scene's folder if the file is in it, so that both can be moved together."""
    path, folder = os.path.abspath(bpy.path.abspath(path)), os.path.abspath(folder)
    return os.path.relpath(path, folder) if os.path.commonpath([path, folder]) == folder else path


# ---- Materials


def source(socket):
    """Returns the node linked to a socket, or None."""
    while socket.is_linked:
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def constant(socket, name):
    if socket.is_linked:
        warn(name, f"the link to {socket.node.name}'s {socket.name} is not exported; its own value is used")
    value = socket.default_value
    return Vector(value[:3]) if socket.type == "RGBA" else value


def factor_and_grids(socket, name):
    """Returns a density as a factor and the names of grids, from Value, Attribute, Volume Info and their products."""
    node = source(socket)
    if node is None:
        return socket.default_value, []
    if node.type == "VALUE":
        return node.outputs[0].default_value, []
    if node.type == "ATTRIBUTE":
        return 1, [node.attribute_name]
    if node.type == "VOLUME_INFO":
        return 1, [socket.links[0].from_socket.name.lower()]
    if node.type == "MATH" and node.operation == "MULTIPLY":
        a, b = (factor_and_grids(factor, name) for factor in node.inputs[:2])
        return a[0] * b[0], a[1] + b[1]
    warn(name, f"the node {node.name} is not supported: its output is taken as 1")
    return 1, []


def closures(node):
    if node is None:
        return []
    if node.type == "ADD_SHADER":
        return closures(source(node.inputs[0])) + closures(source(node.inputs[1]))
    return [node]


def coefficients(material, name):
    """Returns, per grid, extinction, scattering, and scattering times mean cosine, each a colour."""
    output = material.node_tree.get_output_node("CYCLES") if material and material.use_nodes else None
    found = {}
    for node in closures(source(output.inputs["Volume"]) if output else None):
        if node.type not in ("PRINCIPLED_VOLUME", "VOLUME_SCATTER", "VOLUME_ABSORPTION"):
            warn(name, f"the node {node.name} of its material is not exported")
            continue
        color, one = constant(node.inputs["Color"], name), Vector((1, 1, 1))
        factor, grids = factor_and_grids(node.inputs["Density"], name)
        scattering, absorption, g = color, Vector(), 0
        if node.type == "VOLUME_ABSORPTION":
            scattering, absorption = Vector(), one - color
        else:
            g = constant(node.inputs["Anisotropy"], name)
        if node.type == "PRINCIPLED_VOLUME":
            grids += [attribute for attribute in [constant(node.inputs["Density Attribute"], name)] if attribute]
            # As in Cycles (svm/closure.h): the light that is not scattered is absorbed, less the fraction that
            # Absorption Color lets pass.
            by = constant(node.inputs["Absorption Color"], name)
            absorption = Vector(max(1 - c, 0) * max(1 - math.sqrt(max(b, 0)), 0) for c, b in zip(color, by))
            if constant(node.inputs["Color Attribute"], name):
                warn(name, "its Color Attribute is not exported")
            if constant(node.inputs["Emission Strength"], name) or constant(node.inputs["Blackbody Intensity"], name):
                warn(name, "its emission is not exported")
        if len(grids) != 1:
            warn(name, f"{node.name}'s density comes from {len(grids)} grids, not from one: not exported")
            continue
        sums = found.setdefault(grids[0], {"extinction": Vector(), "scattering": Vector(), "lobe": Vector()})
        sums["extinction"] += (scattering + absorption) * max(factor, 0)
        sums["scattering"] += scattering * max(factor, 0)
        sums["lobe"] += scattering * g * max(factor, 0)
    if not found:
        warn(name, "has no volume shader: density times 1, albedo 0.5 and isotropic scattering are used")
    return found or DEFAULT_MEDIUM


def components(volume, matrix, folder):
    data, name = volume.data, volume.name
    if not data.filepath:
        warn(name, "a volume without a file: not exported")
        return []
    if not data.grids.load():
        warn(name, f"not exported: {data.grids.error_message}")
        return []
    if volume.modifiers:
        warn(name, "its modifiers are not exported")
    present = {grid.name for grid in data.grids}
    # Densities "in object space" are per length of the unscaled object (Cycles' scene/object.cpp).
    stretch = (matrix.to_3x3() @ Vector((1, 1, 1)).normalized()).length if data.render.space == "OBJECT" else 1
    made = []
    material = volume.material_slots[0].material if volume.material_slots else None
    for grid, sums in coefficients(material, name).items():
        if grid not in present:
            warn(name, f"{data.grids.frame_filepath} has no grid '{grid}': not exported")
            continue
        extinction = sum(sums["extinction"]) / 3
        if extinction <= 0:
            continue
        if max(sums["extinction"]) - min(sums["extinction"]) > 1e-4 * extinction:
            warn(name, "its extinction is coloured; Tyndall's is grey: the mean is used")
        scattered = sum(sums["scattering"])
        component = {
            "field": {"type": "vdb", "file": file_name(data.grids.frame_filepath, folder), "grid": grid},
            "extinction": number(extinction / stretch),
            "albedo": numbers(min(s / e, 1) if e > 0 else 0 for s, e in zip(sums["scattering"], sums["extinction"])),
            "transform": {"matrix": numbers(x for row in TO_TYNDALL @ matrix for x in row)}}
        g = sum(sums["lobe"]) / scattered if scattered > 0 else 0
        if g:
            component["phase"] = {"type": "henyey_greenstein", "g": number(min(max(g, -0.999), 0.999))}
        made.append(component)
    return made


# ---- Lights


def shader_factor(light, name):
    """Returns the factor of the light's power from its nodes."""
    output = light.node_tree.get_output_node("CYCLES") if light.use_nodes else None
    if output is None:
        return Vector((1, 1, 1))
    node = source(output.inputs["Surface"])
    if node is None or node.type != "EMISSION":
        warn(name, "its nodes are not exported")
        return Vector((1, 1, 1))
    return constant(node.inputs["Color"], name) * constant(node.inputs["Strength"], name)


def light_of(light, matrix):
    """Converts a light. Blender's watts are not radiant watts. From a power P Cycles (kernel/light/point.h, area.h,
    scene/light.cpp) computes the intensity P / 4 pi of points and spots, independent of the cone, and the radiance
    P / (4 area) of areas, which emit pi P / 4 in all. A sun's strength is its irradiance [W/area]."""
    data, name = light.data, light.name
    turned = TO_TYNDALL @ matrix
    power = Vector(c * f * data.energy for c, f in zip(data.color, shader_factor(data, name)))
    if min(power) < 0:
        warn(name, "has negative power: not exported")
        return None
    direction = numbers(-turned.col[2].xyz.normalized())
    place = numbers(turned.translation)
    if data.type == "SUN":
        return {"type": "directional", "direction": direction, "irradiance": numbers(power),
                "angle": number(math.degrees(data.angle) if data.angle > math.radians(0.01) else 0)}
    intensity = numbers(power / (4 * math.pi))
    if data.type == "POINT" and data.shadow_soft_size > 0 and light.visible_camera:
        return {"type": "sphere", "center": place, "radius": number(data.shadow_soft_size), "power": numbers(power)}
    if data.type == "POINT":
        if data.shadow_soft_size > 0:  # a sphere would be visible
            warn(name, "its radius is not exported, as it is not visible to the camera")
        return {"type": "point", "position": place, "intensity": intensity}
    if data.type == "SPOT":
        if data.shadow_soft_size > 0:
            warn(name, "its radius is not exported")
        # Both programs fade by smoothstep of the cosine. Blender's fade begins at the rim and spans the fraction
        # spot_blend of the cosines up to 1. Cycles 3.4 multiplies by the cosine of the angle to the axis, later
        # versions do not; this factor is not exported.
        half = data.spot_size / 2
        full = math.acos(min(math.cos(half) + (1 - math.cos(half)) * data.spot_blend, 1))
        return {"type": "spot", "position": place, "direction": direction, "intensity": intensity,
                "angle": number(math.degrees(data.spot_size)), "edge": number(1 - full / half)}
    u = turned.col[0].xyz * data.size
    v = turned.col[1].xyz * (data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size)
    if data.shape in ("DISK", "ELLIPSE"):
        warn(name, "a round area becomes a rectangle of the same size")
        u, v = u * math.sqrt(math.pi / 4), v * math.sqrt(math.pi / 4)
    if data.spread < math.pi - 1e-3:
        warn(name, "its spread is not exported: it emits into its whole hemisphere")
    if not light.visible_camera:
        warn(name, "is not visible to the camera; Tyndall's rectangles are")
    if u.cross(v).dot(turned.col[2].xyz) > 0:  # it emits along -z, Tyndall's along cross(u, v)
        v = -v
    return {"type": "rectangle", "center": place, "edge_u": numbers(u), "edge_v": numbers(v),
            "radiance": numbers(power / (4 * u.cross(v).length))}


def sky(world, folder):
    if world is None:
        return None
    if not world.use_nodes:
        return {"type": "environment", "radiance": numbers(world.color)} if any(world.color) else None
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return None
    if output.inputs["Volume"].is_linked:
        warn(world.name, "the world's volume is not exported")
    node = source(output.inputs["Surface"])
    if node is None:
        return None
    if node.type != "BACKGROUND":
        warn(world.name, f"the world's node {node.name} is not exported")
        return None
    strength = constant(node.inputs["Strength"], world.name)
    picture = source(node.inputs["Color"])
    if picture is None:
        radiance = constant(node.inputs["Color"], world.name) * strength
        return {"type": "environment", "radiance": numbers(radiance)} if any(radiance) else None
    path = picture.image.filepath if picture.type == "TEX_ENVIRONMENT" and picture.image else ""
    if not path or not os.path.isfile(bpy.path.abspath(path, library=picture.image.library)):
        warn(world.name, f"the world's {picture.name} is no picture in a file: not exported")
        return None
    if picture.projection != "EQUIRECTANGULAR" or source(picture.inputs["Vector"]) is not None:
        warn(world.name, f"the projection or mapping of {picture.name} is not exported")
    # The image's centre is the direction +x in Blender and +z in Tyndall.
    return {"type": "environment", "image": file_name(path, folder), "scale": number(strength), "rotation": 90}


# ---- Camera


def camera_of(scene):
    camera, render = scene.camera, scene.render
    data, name = camera.data, camera.name
    if data.type == "PANO":
        fail(f"{name}: panoramic cameras cannot be exported")
    frame = data.view_frame(scene=scene)  # includes the sensor's fit
    left, right = min(corner.x for corner in frame), max(corner.x for corner in frame)
    if data.shift_x or data.shift_y:
        warn(name, "its shift is not exported")
    if data.dof.use_dof:
        warn(name, "its depth of field is not exported")
    if render.pixel_aspect_x != render.pixel_aspect_y:
        warn(name, "pixels that are not square are not exported")
    if render.use_border:
        warn(name, "the border is not exported: all of the picture is")
    place, rotation, _ = camera.matrix_world.decompose()  # a camera's scale has no effect
    pose = TO_TYNDALL @ Matrix.Translation(place) @ rotation.to_matrix().to_4x4()
    made = {"type": "perspective", "matrix": numbers(x for row in pose for x in row),
            "resolution": [max(1, size * render.resolution_percentage // 100)
                           for size in (render.resolution_x, render.resolution_y)]}
    if data.type == "ORTHO":
        made.update(type="orthographic", width=number(right - left))
    else:
        made["fov"] = number(math.degrees(2 * math.atan((right - left) / 2 / abs(frame[0].z))))
    return made


# ---- The whole scene


def export(path):
    folder = os.path.dirname(os.path.abspath(path))
    scene = bpy.context.scene
    if scene.camera is None:
        fail("nothing to export: the scene has no camera")
    media, lights, visited = [], [], set()
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        thing, matrix = instance.object.original, instance.matrix_world.copy()
        visited.add(thing.name)
        if thing.hide_render or not instance.show_self:
            continue
        if thing.type == "VOLUME":
            media += components(thing, matrix, folder)
        elif thing.type == "LIGHT":
            lights.append(light_of(thing, matrix))
        elif thing.type not in UNSEEN:
            warn(thing.name, f"a {thing.type.lower()}: not exported")
    for thing in scene.objects:
        if thing.name not in visited and not thing.hide_render and thing.type in ("VOLUME", "LIGHT"):
            warn(thing.name, "hidden in the viewport: not exported")
    if not media:
        fail("nothing to export: the scene has no volume from a file")
    if len(media) > 16:
        fail(f"{len(media)} volumes; Tyndall supports at most 16 components")
    lights = [light for light in [*lights, sky(scene.world, folder)] if light]
    # No box: Tyndall uses the bounds of the grids themselves. Blender's bounds contain all grids of a file, in whole
    # leaves: cells of the illumination grid would be wasted on empty space.
    out = {"tyndall": 1, "medium": {"components": media}, "lights": lights, "camera": camera_of(scene)}
    text = re.sub(r"\[\s+([^][{}]*?)\s+\]", lambda m: f"[{' '.join(m.group(1).split())}]", json.dumps(out, indent=2))
    unfinished = f"{path}.unfinished"
    try:
        with open(unfinished, "w", encoding="utf-8") as file:
            file.write(text + "\n")
        os.replace(unfinished, path)
    except OSError as error:
        if os.path.exists(unfinished):
            os.remove(unfinished)
        fail(f"{path}: {error.strerror}")
    print(f"export_scene: {path}: components: {len(media)}, lights: {len(lights)}")


arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
if len(arguments) != 1:
    print(__doc__, file=sys.stderr)
    sys.exit(2)
export(arguments[0])
