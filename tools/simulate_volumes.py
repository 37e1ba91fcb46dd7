#!/usr/bin/env python3
"""Simulates the volumes of scenes/: smoke.vdb and fire.vdb.

  simulate_volumes.py [smoke] [fire] [--cells N] [--output FOLDER]

N is the number of solver cells across (76 for the smoke, 60 for the fire). Needs NumPy and OpenVDB's Python module
(scripts/setup --dev), and some minutes of one core.

The solver is an incompressible flow with buoyancy on a coarse periodic grid: MacCormack advection [Selle2008],
pressure projection by FFT, vorticity confinement [Fedkiw2001]. It keeps the flow of each step. The voxels are finer.
Points of each voxel are traced back through all steps to the sources, so that advection smears nothing. Divergence-free
noise, in proportion to the vorticity, adds the vortices below the grid's cells.

The fire does not solve for chemistry. The fuel that a point took up and the time that it has burned give its soot and
its temperature: hottest where fuel and air mix, then colder, then smoke.

The two files are in the public domain (CC0 1.0).
"""
import argparse
import pathlib
import uuid

import numpy as np

DEFAULT_CELLS = {"smoke": 76, "fire": 60}
CHUNK = 16384  # points at a time: their data stay in the cache


# ---- Fields on a periodic grid: arrays [x, y, z, channel]

def corners(p, shape):
    """Yields flat index and weight of each of the eight cells about p [cells]."""
    low = np.floor(p)
    f = p - low
    low = low.astype(np.int32)
    sides = []
    for axis, n in enumerate(shape):
        i = low[:, axis] % n
        j = i + 1
        j[j == n] = 0
        stride = int(np.prod(shape[axis + 1:]))
        sides.append(((i * stride, 1 - f[:, axis]), (j * stride, f[:, axis])))
    for ix, wx in sides[0]:
        for iy, wy in sides[1]:
            ixy, wxy = ix + iy, wx * wy
            for iz, wz in sides[2]:
                yield ixy + iz, (wxy * wz)[:, None]


def sample(field, p, bounds=False):
    """Trilinear values of the field at the points p [cells]; with bounds, also the least and largest corner."""
    shape, flat = field.shape[:3], field.reshape(-1, field.shape[3])
    out = np.empty((len(p), flat.shape[1]), np.float32)
    low, high = (np.empty_like(out), np.empty_like(out)) if bounds else (None, None)
    for a in range(0, len(p), CHUNK):
        part = slice(a, a + CHUNK)
        total = None
        for index, weight in corners(p[part], shape):
            value = flat[index]
            if total is None:
                total = value * weight
                if bounds:
                    least, most = value.copy(), value.copy()
            else:
                if bounds:
                    np.minimum(least, value, out=least)
                    np.maximum(most, value, out=most)
                value *= weight
                total += value
        out[part] = total
        if bounds:
            low[part], high[part] = least, most
    return (out, low, high) if bounds else out


def derivative(f, axis, h):
    return (np.roll(f, -1, axis) - np.roll(f, 1, axis)) * np.float32(0.5 / h)


def curl(u, h):
    d = lambda component, axis: derivative(u[..., component], axis, h)
    return np.stack([d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1)], -1)


class Solver:
    """Incompressible flow with buoyancy: MacCormack advection, FFT projection, vorticity confinement."""

    def __init__(self, shape, h, dt, confinement, wind=(0, 0, 0), scalars=2):
        self.shape, self.h, self.dt, self.confinement = shape, h, dt, confinement
        self.wind = np.array(wind, np.float32)
        self.state = np.zeros((*shape, 3 + scalars), np.float32)  # velocity [m/s], then scalars
        self.state[..., :3] = self.wind
        self.cells = np.stack(np.meshgrid(*(np.arange(n, dtype=np.float32) for n in shape), indexing="ij"), -1)
        self.places = self.cells * np.float32(h)  # [m]
        k = np.meshgrid(*(np.fft.fftfreq(n) for n in shape[:2]), np.fft.rfftfreq(shape[2]), indexing="ij")
        self.k = np.stack(k).astype(np.float32)
        self.k2 = (self.k ** 2).sum(0)
        self.k2[0, 0, 0] = 1

    def advect(self):
        u = self.state[..., :3]
        cells = self.cells.reshape(-1, 3)
        step = (u * np.float32(self.dt / self.h)).reshape(-1, 3)
        there, low, high = sample(self.state, cells - step, True)
        back = sample(there.reshape(self.state.shape), cells + step)
        there += 0.5 * (self.state.reshape(there.shape) - back)
        np.clip(there, low, high, out=there)
        self.state = there.reshape(self.state.shape)

    def push(self, acceleration):
        """Adds buoyancy [m/s^2] and vorticity confinement, which restores the small vortices that the grid damps."""
        u = self.state[..., :3]
        u[..., 1] += np.float32(self.dt) * acceleration
        w = curl(u, self.h)
        size = np.sqrt((w ** 2).sum(-1))
        n = np.stack([derivative(size, axis, self.h) for axis in range(3)], -1)
        n /= np.sqrt((n ** 2).sum(-1, keepdims=True)) + np.float32(1e-4)
        u += np.float32(self.dt * self.confinement * self.h) * np.cross(n, w)
        return size

    def project(self, divergence=None):
        """Makes the flow free of divergence, or of the given divergence [1/s]; the mean flow is the wind."""
        u = self.state[..., :3]
        hat = [np.fft.rfftn(u[..., axis]).astype(np.complex64) for axis in range(3)]
        along = sum(k * f for k, f in zip(self.k, hat)) / self.k2
        if divergence is not None:
            hot = np.fft.rfftn(divergence - divergence.mean()).astype(np.complex64)
            along -= hot * np.complex64(self.h / 2j / np.pi) / self.k2
        for axis in range(3):
            hat[axis] -= self.k[axis] * along
            hat[axis][0, 0, 0] = self.wind[axis] * np.prod(self.shape)
            u[..., axis] = np.fft.irfftn(hat[axis], s=self.shape)


def noise_tile(n, low, high, slope, rng):
    """Returns a periodic random flow without divergence, n^3 samples, waves per tile in [low, high], r.m.s. 1."""
    k = np.stack(np.meshgrid(np.fft.fftfreq(n, 1 / n), np.fft.fftfreq(n, 1 / n), np.fft.rfftfreq(n, 1 / n),
                             indexing="ij"))
    size = np.sqrt((k ** 2).sum(0))
    size[0, 0, 0] = 1
    envelope = np.where((size >= low) & (size <= high), size ** slope, 0)
    hat = np.stack([np.fft.rfftn(rng.standard_normal((n, n, n))) for _ in range(3)]) * envelope
    hat -= k * (k * hat).sum(0) / size ** 2
    u = np.stack([np.fft.irfftn(f, s=(n, n, n)) for f in hat], -1)
    return (u / np.sqrt((u ** 2).sum(-1).mean())).astype(np.float32)


class History:
    """The flow of every step, for tracing points back in time without diffusion."""

    def __init__(self, solver):
        self.h, self.dt, self.shape = solver.h, solver.dt, solver.shape
        self.flows, self.masks = [], []

    def record(self, solver, vorticity, present):
        flow = np.concatenate([solver.state[..., :3], vorticity[..., None]], -1)
        self.flows.append(flow.astype(np.float16))
        for axis in range(3):
            present = present | np.roll(present, 1, axis) | np.roll(present, -1, axis)
        self.masks.append(present)

    def present(self, step, p):
        i = np.rint(p).astype(np.int32)
        for axis, n in enumerate(self.shape):
            i[:, axis] %= n
        return self.masks[step][i[:, 0], i[:, 1], i[:, 2]]

    def trace(self, p, tile, cells_per_tile, turbulence, drift, visit):
        """Calls visit(step, age [s], index, places [m], vorticity) for the points p [m] at each earlier step.

        Points are dropped once they leave the carried scalars. turbulence: speed of the noise below the grid's cells as
        a fraction of vorticity times cell; drift [m/s]: its mean velocity.
        """
        p = (p / self.h).astype(np.float32)
        index = np.arange(len(p))
        n = tile.shape[0]
        flat = tile.reshape(-1, 3)
        move = np.float32(self.dt / self.h)
        for back, step in enumerate(reversed(range(len(self.flows)))):
            inside = self.present(step, p)
            p, index = p[inside], index[inside]
            if not len(p):
                break
            flow = self.flows[step].astype(np.float32)
            u = sample(flow, p)
            u = sample(flow, p - u[:, :3] * (0.5 * move))  # midpoint
            q = (p - np.asarray(drift, np.float32) * (move * step)) * np.float32(n / cells_per_tile)
            i = np.floor(q).astype(np.int32) % n
            swirl = flat[(i[:, 0] * n + i[:, 1]) * n + i[:, 2]]
            p = p - move * (u[:, :3] + swirl * (u[:, 3:] * np.float32(turbulence * self.h)))
            visit(step, back * self.dt, index, p * np.float32(self.h), u[:, 3])


# ---- Final grids

def fine_grid(history, voxel, samples, rng, carry):
    """Returns the mean of carry(points) over jittered points of each voxel that may be non-empty [x, y, z, channel]."""
    present = history.masks[-1]
    places = np.argwhere(present)
    low, high = places.min(0) * history.h, (places.max(0) + 1) * history.h
    origin = np.floor(low / voxel).astype(int)
    shape = np.ceil(high / voxel).astype(int) - origin
    voxels = np.argwhere(np.ones(shape, bool)) + origin
    voxels = voxels[history.present(-1, voxels * (voxel / history.h))]
    total = 0
    for s in range(samples):
        jitter = (rng.random((len(voxels), 3)) + [s % 2, s // 2 % 2, s // 4 % 2]) / 2 - 0.5
        total = total + carry((voxels + jitter) * voxel)
    grid = np.zeros((*shape, total.shape[1]), np.float32)
    grid[tuple((voxels - origin).T)] = total / samples
    return grid, origin


def quantised(a, bits):
    """Rounds the mantissas to `bits` binary digits, which makes a smaller file."""
    mantissa, exponent = np.frexp(a)
    return np.ldexp(np.rint(np.ldexp(mantissa, bits)), exponent - bits).astype(np.float32)


def blurred(a):
    """Applies a binomial filter of three voxels per axis; values beyond the edges are 0."""
    a = np.pad(a, ((1, 1), (1, 1), (1, 1), (0, 0)))
    for axis in range(3):
        a = (np.roll(a, 1, axis) + 2 * a + np.roll(a, -1, axis)) / 4
    return a[1:-1, 1:-1, 1:-1]


def write(path, voxel, origin, grids, background):
    import pyopenvdb as vdb
    out = []
    for name, values in grids.items():
        grid = vdb.FloatGrid(background[name])
        grid.name = name
        grid.gridClass = vdb.GridClass.FOG_VOLUME
        grid.saveFloatAsHalf = True
        grid.transform = vdb.createLinearTransform(voxelSize=voxel)
        grid.copyFromArray(values, ijk=tuple(int(i) for i in origin), tolerance=0)
        grid.pruneInactive()
        out.append(grid)
    vdb.write(str(path), out, {"creator": "tools/simulate_volumes.py", "licence": "CC0-1.0"})
    # OpenVDB puts a random UUID behind 21 bytes of magic number and versions.
    file = bytearray(path.read_bytes())
    file[21:57] = str(uuid.uuid5(uuid.NAMESPACE_URL, path.name)).encode()
    path.write_bytes(file)
    for grid in out:
        print(path.name, grid.name, grid.evalActiveVoxelDim(), grid.activeVoxelCount(), grid.evalMinMax())
    print(path.name, path.stat().st_size, "bytes")


def sponge_of(solver, edge):
    """Returns factors of the flow per step and height that damp it towards the wind near the ground and the top."""
    factors = np.ones(solver.shape[1], np.float32)
    factors[:edge] = factors[-edge:] = 0.8
    return factors[:, None, None]


def blob(places, centre, radii):
    """1 inside the ellipsoid, 0 outside, with a soft edge."""
    r = np.sqrt((((places - np.asarray(centre, np.float32)) / np.asarray(radii, np.float32)) ** 2).sum(-1))
    return np.clip((1.15 - r) / 0.3, 0, 1)


def flicker(t, rates, phases):
    """A sum of sines of these rates [1/s], within -1 and 1."""
    return sum(np.sin(2 * np.pi * rate * t + p) for rate, p in zip(rates, phases)) / len(rates)


# ---- Smoke

def smoke(cells, folder):
    rng = np.random.default_rng(11)
    width, wind = 13.0, (0.6, 0, 0.15)  # [m], [m/s]
    h = width / cells
    dt = 0.36 * h
    steps = int(5.3 / dt)
    solver = Solver((cells, cells * 9 // 5, cells), h, dt, confinement=0.9, wind=wind)
    history = History(solver)
    hearths = [(rng.uniform(-1.1, 1.1), rng.uniform(-0.9, 0.9), rng.uniform(0.4, 0.8), rng.uniform(0, 6.28, (3, 4)))
               for _ in range(6)]

    def source(places, t):
        """Returns the smoke that the hearths emit at these places [m], 0 to 1."""
        total = 0
        for x, z, radius, phase in hearths:
            gust = [flicker(t, (0.5, 1.1, 2.3, 3.9), p) for p in phase]
            r = radius * (1 + 0.35 * gust[2])
            centre = 3.6 + x + 0.4 * gust[0], 2.0 + 0.5 * r, 6.0 + z + 0.4 * gust[1]
            total = np.maximum(total, blob(places, centre, (r, r, r)))
        return total

    sponge = sponge_of(solver, cells // 12)
    for step in range(steps):
        solver.advect()
        s = solver.state
        fresh = source(solver.places, step * dt).astype(np.float32)
        s[..., 3] = np.maximum(s[..., 3], fresh)  # heat, as a fraction of the source's
        s[..., 4] = np.maximum(s[..., 4], fresh)  # smoke
        s[..., 3] *= np.float32(np.exp(-dt / 5))
        s[..., :3] += fresh[..., None] * rng.normal(0, 1.5, s[..., :3].shape).astype(np.float32)
        vorticity = solver.push(np.float32(6) * s[..., 3] - np.float32(0.4) * s[..., 4])
        s[..., :3] = solver.wind + (s[..., :3] - solver.wind) * sponge
        solver.project()
        history.record(solver, vorticity, s[..., 4] > 0.004)

    tile = noise_tile(64, 3, 20, -11 / 6, rng)
    samples, voxel = 4, h / 2.5

    def carry(p):
        dose = np.zeros(len(p), np.float32)

        def visit(step, age, index, places, vorticity):
            dose[index] += source(places, step * dt) * np.float32(dt * np.exp(-age / 3))

        history.trace(p, tile, 16, 0.55, (wind[0], 2.5, wind[2]), visit)
        return (1 - np.exp(-dose / 0.12))[:, None]

    grid, origin = fine_grid(history, voxel, samples, rng, carry)
    density = grid[..., 0]
    density[density < 0.01] = 0
    density = quantised(density, 5)
    write(folder / "smoke.vdb", voxel, origin, {"density": density}, {"density": 0.0})


# ---- Fire

def fire(cells, folder):
    rng = np.random.default_rng(5)
    width, wind = 2.2, (0.1, 0, 0)  # [m], [m/s]
    h = width / cells
    dt = 0.22 * h
    steps = int(1.3 / dt)
    solver = Solver((cells, cells * 9 // 5, cells), h, dt, confinement=0.2, wind=wind)
    history = History(solver)
    hearths = [(r * np.cos(a), r * np.sin(a), size, rng.uniform(0, 6.28, (3, 4)))
               for r, a, size in [(0, 0, 0.15)] + [(0.24, 1.05 * i, rng.uniform(0.06, 0.11)) for i in range(6)]]

    def source(places, t):
        """Returns the fuel that the hearths emit at these places [m], 0 to 1."""
        total = 0
        for x, z, size, phase in hearths:
            gust = [flicker(t, (1.7, 3.1, 5.3, 8.9), p) for p in phase]
            r = size * (1 + 0.5 * gust[2])
            centre = 1.05 + x + 0.06 * gust[0], 0.3, 1.1 + z + 0.06 * gust[1]
            total = np.maximum(total, blob(places, centre, (r, 0.6 * r, r)))
        return total

    sponge = sponge_of(solver, cells // 12)
    for step in range(steps):
        solver.advect()
        s = solver.state
        fresh = source(solver.places, step * dt).astype(np.float32)
        s[..., 3] = np.maximum(s[..., 3], fresh)  # heat, as a fraction of the flame's
        s[..., 4] = np.maximum(s[..., 4], fresh)  # gas that was fuel
        s[..., 3] *= np.float32(np.exp(-dt / 0.4))
        s[..., 4] *= np.float32(np.exp(-dt / 0.5))
        s[..., :3] += fresh[..., None] * rng.normal(0, 0.15, s[..., :3].shape).astype(np.float32)
        vorticity = solver.push(np.float32(30) * s[..., 3])
        s[..., :3] = solver.wind + (s[..., :3] - solver.wind) * sponge
        solver.project(fresh * np.float32(4))
        history.record(solver, vorticity, s[..., 4] > 0.004)

    tile = noise_tile(64, 3, 20, -11 / 6, rng)
    samples, voxel = 4, h / 2

    def carry(p):
        dose, since, mixed = (np.zeros(len(p), np.float32) for _ in range(3))

        def visit(step, age, index, places, vorticity):
            gain = source(places, step * dt) * np.float32(dt)
            dose[index] += gain
            since[index] += gain * (age + 0.5 * mixed[index])
            mixed[index] += np.float32(dt) * np.minimum(vorticity / 40, 2)

        history.trace(p, tile, 16, 0.12, (wind[0], 2.5, wind[2]), visit)
        fuel = 1 - np.exp(-dose / 0.05)
        burnt = since / np.maximum(dose, 1e-9)  # [s] of burning, faster where the flow mixes
        hot = 1 / (1 + np.exp((burnt - 0.7) / 0.05))
        sheet = 4 * fuel * (1 - fuel)  # the flame burns where fuel and air mix
        heat = 0.66 + 0.32 * sheet * np.exp(-((burnt - 0.25) / 0.2) ** 2)
        heat *= (1 - 0.3 * np.exp(-burnt / 0.05)) * hot
        soot = hot * (0.25 * sheet + 0.05 * fuel) + 0.9 * (1 - hot) * fuel
        soot *= (1 - np.exp(-burnt / 0.12)) * np.exp(-np.maximum(burnt - 0.7, 0) / 0.5)
        return np.stack([soot, soot * heat], 1)

    grid, origin = fine_grid(history, voxel, samples, rng, carry)
    density = grid[..., 0]
    smooth = blurred(grid)
    temperature = 300 + 1900 * smooth[..., 1] / np.maximum(smooth[..., 0], 1e-9)
    density[density < 0.01] = 0
    temperature[(density == 0) | (temperature < 700)] = 300
    write(folder / "fire.vdb", voxel, origin,
          {"density": quantised(density, 5), "temperature": np.rint(temperature / 10) * 10},
          {"density": 0.0, "temperature": 300.0})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=["smoke", "fire"], metavar="smoke|fire")
    parser.add_argument("--cells", type=int)
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path(__file__).parents[1] / "scenes")
    arguments = parser.parse_args()
    for name in arguments.names:
        {"smoke": smoke, "fire": fire}[name](arguments.cells or DEFAULT_CELLS[name], arguments.output)


if __name__ == "__main__":
    main()
