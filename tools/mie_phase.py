#!/usr/bin/env python3
"""Writes the phase function of a cloud's droplets, for "phase": {"type": "tabulated", "file": ...}.

Mie scattering by spheres of water [BohrenHuffman1983], averaged over the gamma distribution of sizes of
[HansenTravis1974] with each size weighted by its scattering cross section, and over the two polarisations. Writes rows
"cosine value", closely spaced at the forward peak; the values are per steradian.

  mie_phase.py [--radius UM] [--variance V] [--wavelength UM] [--index N] [--sizes N] > cloud.phase
"""
import argparse
import math


def coefficients(x, m):
    """Returns Mie's a_n and b_n of a sphere of size parameter x and real relative refractive index m."""
    count = int(x + 4.05 * x ** (1 / 3) + 2)
    mx = m * x
    start = int(max(count, mx)) + 16
    logarithmic = [0.0] * (start + 1)  # derivative of psi_n(mx): stable downwards
    for n in range(start, 0, -1):
        logarithmic[n - 1] = n / mx - 1 / (logarithmic[n] + n / mx)
    psi_before, psi = math.cos(x), math.sin(x)
    chi_before, chi = -math.sin(x), math.cos(x)
    a, b = [], []
    for n in range(1, count + 1):
        psi_before, psi = psi, (2 * n - 1) / x * psi - psi_before
        chi_before, chi = chi, (2 * n - 1) / x * chi - chi_before
        xi_before, xi = complex(psi_before, -chi_before), complex(psi, -chi)
        for list_, factor in ((a, logarithmic[n] / m + n / x), (b, logarithmic[n] * m + n / x)):
            list_.append((factor * psi - psi_before) / (factor * xi - xi_before))
    return a, b


def cosines(mean_size):
    """Returns cosines from -1 to 1 in steps that shrink towards both ends: the glory and the forward peak."""
    peak = 1 / mean_size  # [radian] width of the forward peak
    angles = [0.0]
    while angles[-1] < math.pi:
        from_back = math.pi - angles[-1]
        angles.append(angles[-1] + min(0.003, 0.03 * max(angles[-1], peak), 0.03 * max(from_back, 4 * peak)))
    return [-1.0] + [math.cos(t) for t in reversed(angles[1:-1])] + [1.0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--radius", type=float, default=8.0, help="effective radius [um]")
    parser.add_argument("--variance", type=float, default=0.1, help="effective variance")
    parser.add_argument("--wavelength", type=float, default=0.55, help="in air [um]")
    parser.add_argument("--index", type=float, default=1.333, help="refractive index")
    parser.add_argument("--sizes", type=int, default=150, help="radii of the distribution")
    options = parser.parse_args()

    spheres = []  # per size: number density, and coefficients of both amplitudes times (2n + 1) / (n (n + 1))
    all_scattered = 0.0
    for i in range(options.sizes):
        radius = options.radius * 3.2 * (i + 0.5) / options.sizes
        log_number = (1 / options.variance - 3) * math.log(radius / options.radius) \
            - radius / (options.radius * options.variance)
        number = math.exp(log_number + 1 / options.variance)
        a, b = coefficients(2 * math.pi * radius / options.wavelength, options.index)
        all_scattered += number * sum((2 * n + 3) * (abs(p) ** 2 + abs(q) ** 2) for n, (p, q) in enumerate(zip(a, b)))
        weights = [(2 * n + 1) / (n * (n + 1)) for n in range(1, len(a) + 1)]
        # S1 + S2 and S1 - S2 are sums over (a + b) (pi + tau) and (a - b) (pi - tau).
        spheres.append((number, [w * (p + q) for w, p, q in zip(weights, a, b)],
                        [w * (p - q) for w, p, q in zip(weights, a, b)]))

    most = max(len(plus) for _, plus, _ in spheres)
    print(f"# Droplets of water of effective radius {options.radius:g} um, effective variance {options.variance:g},")
    print(f"# refractive index {options.index:g}, at {options.wavelength:g} um (tools/mie_phase.py).")
    print("# cosine of the scattering angle, value [1/sr]")
    for cosine in cosines(2 * math.pi * options.radius / options.wavelength):
        sums, differences = [], []
        before, pi = 0.0, 1.0
        for n in range(1, most + 1):
            tau = n * cosine * pi - (n + 1) * before
            sums.append(pi + tau)
            differences.append(pi - tau)
            before, pi = pi, ((2 * n + 1) * cosine * pi - (n + 1) * before) / n
        value = 0.0
        for number, plus, minus in spheres:
            s = sum(map(complex.__mul__, plus, map(complex, sums)))
            d = sum(map(complex.__mul__, minus, map(complex, differences)))
            value += number * (abs(s) ** 2 + abs(d) ** 2)
        # |s|^2 + |d|^2 = 2 (|S1|^2 + |S2|^2), and the phase function is (|S1|^2 + |S2|^2) / (2 k^2 C_sca).
        print(f"{cosine:.10g} {value / 4 / (2 * math.pi * all_scattered):.6g}")


if __name__ == "__main__":
    main()
