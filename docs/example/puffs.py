"""Puffs of smoke from numpy, under a sun that sets: pictures, and how much of its light each side of the smoke gets.

Cells between "# %%" run one by one in a notebook; `python puffs.py` runs all of them, and writes puffs.ppm.
"""
# %% Density: [nz][ny][nx], between 0 and 1
import numpy
import tyndall

n = 48
z, y, x = (numpy.indices((n, n, n)) + 0.5) / n
random = numpy.random.default_rng(7)
density = numpy.zeros((n, n, n), numpy.float32)
for _ in range(40):
    center, radius = random.uniform(0.25, 0.75, 3), random.uniform(0.05, 0.18)
    distance = numpy.sqrt((x - center[0]) ** 2 + (y - center[1]) ** 2 + (z - center[2]) ** 2)
    density = numpy.maximum(density, numpy.clip(2 * (1 - distance / radius), 0, 1).astype(numpy.float32))

# %% A scene is a dict; tyndall.schema() has its keys
scene = {
    "tyndall": 1,
    "medium": {"components": [{"field": {"type": "grid", "values": density}, "extinction": 60, "albedo": 0.98}]},
    "lights": [{"type": "directional", "direction": [1, -1, 0.3], "irradiance": [3, 2.6, 2], "group": "sun"},
               {"type": "environment", "radiance": [0.05, 0.1, 0.2], "group": "sky"}],
    "camera": {"position": [0.5, 0.5, -1.6], "look_at": [0.5, 0.5, 0.5], "fov": 40, "resolution": [160, 120]},
    "photons": {"count": 400000}, "gather": {"samples": 16}}
tyndall.validate(scene)

# %% Pictures, one for each height of the sun
pictures = []
for height in (60, 25, 0):
    down = numpy.radians(height)
    result = tyndall.render(scene, {"lights[0].direction": [float(numpy.cos(down)), -float(numpy.sin(down)), 0.3]})
    pictures.append(result.picture[..., :3])
    print(f"sun at {height:2d} degrees: mean radiance {result.picture[..., :3].mean():.3f}, "
          f"of which the sky {result.layers['group_sky'].mean():.3f}; hash {result.tallies}")

strip = numpy.clip(numpy.concatenate(pictures, axis=1), 0, 1) ** (1 / 2.2)
with open("puffs.ppm", "wb") as file:
    file.write(b"P6 %d %d 255\n" % (strip.shape[1], strip.shape[0]))
    file.write((255 * strip + 0.5).astype(numpy.uint8).tobytes())

# %% The light itself, in cells of the box: what reaches the side of the sun, and what the other
light = tyndall.bake(scene, {"photons.illumination.resolution": 24}, per_light=True)
sun = light.fluence["sun"].mean(axis=-1)
lit = sun > 0
side = numpy.indices(sun.shape)[2] < sun.shape[2] / 2
print(f"fluence of the sun: {sun[lit & side].mean():.2f} W/area towards it, {sun[lit & ~side].mean():.2f} away from it")
