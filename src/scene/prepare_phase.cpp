#include "scene/prepare_phase.h"

#include <algorithm>
#include <cmath>

#include "scene/values.h"

namespace tyndall {
namespace {

/// Integrates f(cosine) times a density over the sphere. The density is linear between the cosines
/// of `a` and `b` and 0 elsewhere. Two Gauss-Legendre points are exact if the degree of f is <= 2.
template <class F>
double integral(const PhaseKnot& a, const PhaseKnot& b, F&& f) {
  constexpr double gauss = 0.577350269189625764509, exact_pi = 3.14159265358979323846;
  const double half = 0.5 * (double{b.cosine} - a.cosine);
  double sum = 0;
  for (const double x : {-gauss, gauss}) {
    const double t = 0.5 * (1 + x);
    sum += ((1 - t) * a.density + t * b.density) * f((1 - t) * a.cosine + t * b.cosine);
  }
  return 2 * exact_pi * half * sum;
}

template <class F>
double integral(const std::vector<PhaseKnot>& knots, F&& f) {
  double sum = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) sum += integral(knots[i - 1], knots[i], f);
  return sum;
}

Phase tabulated(const scene::PhaseTable& table, std::vector<PhaseKnot>& knots) {
  const auto one = [](double) { return 1.0; };
  const double largest = *std::max_element(table.values.begin(), table.values.end());
  for (std::size_t i = 0; i < table.cosines.size(); ++i) {
    const PhaseKnot knot{static_cast<float>(table.cosines[i]),
                         static_cast<float>(table.values[i] / largest), 0};
    // If rows have the same cosine in single precision, the last one counts.
    if (!knots.empty() && knots.back().cosine == knot.cosine) knots.pop_back();
    knots.push_back(knot);
  }
  const double scale = 1 / integral(knots, one);
  for (PhaseKnot& knot : knots) knot.density = static_cast<float>(scale * knot.density);
  const double total = integral(knots, one);
  double sum = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    sum += integral(knots[i - 1], knots[i], one);
    knots[i].below = static_cast<float>(sum / total);
  }
  Phase phase;
  phase.kind = Phase::Kind::tabulated;
  phase.g = static_cast<float>(integral(knots, [](double c) { return c; }) / total);
  phase.g2 =
      static_cast<float>(integral(knots, [](double c) { return 1.5 * c * c - 0.5; }) / total);
  phase.knots = knots.data();
  phase.knot_count = static_cast<int>(knots.size());
  return phase;
}

/// Solves the symmetric positive definite system a x = b of n unknowns in place of b [Cholesky].
void solve(double (&a)[3][3], double (&b)[3], int n) {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] = i == j ? std::sqrt(a[i][i]) : a[i][j] / a[j][j];
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
}

double legendre(int l, double x) {
  double before = 0, p = 1;
  for (int k = 0; k < l; ++k) {
    const double next = ((2 * k + 1) * x * p - k * before) / (k + 1);
    before = p;
    p = next;
  }
  return p;
}

double power(double g, int l) {
  double product = 1;
  for (; l > 0; --l) product *= g;
  return product;
}

/// The coefficient chi_l of sum (2l + 1) chi_l P_l(cosine) / 4 pi.
double moment(const Phase& phase, int l) {
  switch (phase.kind) {
    case Phase::Kind::isotropic:
      break;
    case Phase::Kind::henyey_greenstein:
      return power(phase.g, l);
    case Phase::Kind::rayleigh:
      return l == 0 ? 1 : l == 2 ? 0.1 : 0;
    case Phase::Kind::two_lobes:
      return phase.weight * power(phase.g, l) + (1.0 - phase.weight) * power(phase.g2, l);
    case Phase::Kind::tabulated: {
      double sum = 0;
      for (int i = 1; i < phase.knot_count; ++i) {
        // Steps are so short that the polynomials are almost linear.
        const PhaseKnot low = phase.knots[i - 1], high = phase.knots[i];
        const int steps = 1 + static_cast<int>(64 * (high.cosine - low.cosine));
        const auto knot = [&](int step) {
          const float t = static_cast<float>(step) / static_cast<float>(steps);
          return PhaseKnot{lerp(low.cosine, high.cosine, t), lerp(low.density, high.density, t), 0};
        };
        for (int step = 0; step < steps; ++step)
          sum += integral(knot(step), knot(step + 1), [l](double c) { return legendre(l, c); });
      }
      return sum;
    }
  }
  return l == 0 ? 1 : 0;
}

/// The truncation error of a series up to `order`, for light scattered at least `scatterings`
/// times, including the collisions of camera paths. Each scattering multiplies the harmonics of
/// order l by chi_l. The error is relative to the first term of the series.
double truncation(const Phase& phase, int order, int scatterings) {
  constexpr int orders = 64;  // a longer sum is far above the limit already
  double sum = 0;
  for (int l = order + 1; l < orders; ++l)
    sum += (2 * l + 1) * power(std::abs(moment(phase, l)), scatterings);
  return sum;
}

}  // namespace

/// Chooses the smooth part S = sum (2l + 1) s_l P_l / 4 pi with the least integral of (P - S)^2 /
/// P. That is the mean square weight of a path that continues for P - S with directions sampled
/// from P. The normal equations are A s = (1, 0, 0), where A_lm is (2l + 1) (2m + 1) / (4 pi)^2
/// times the integral of P_l P_m / P; the mean square is then 1 - s_0. Any s is unbiased; this one
/// costs least.
void split_phase(Phase& phase, int order, int scatterings) {
  constexpr int nodes = 4096;
  constexpr double four_pi = 12.566370614359172954;
  // Measured on slabs, an image lacks a tenth of this: see docs/light.md.
  constexpr double most_truncation = 0.02;
  phase.smooth_0 = phase.smooth_1 = phase.smooth_2 = 0;
  phase.is_split = truncation(phase, order, scatterings) > most_truncation;
  if (!phase.is_split) return;
  const auto each_node = [&](const auto& call) {
    for (int node = 0; node < nodes; ++node) {
      const double c = (2 * node + 1.0) / nodes - 1;
      const double density = four_pi * double{phase.evaluate(static_cast<float>(c))};
      const double p[3] = {1, 3 * c, 5 * (1.5 * c * c - 0.5)};
      call(std::max(density, 1e-9), p);
    }
  };
  double a[3][3] = {}, s[3] = {1, 0, 0}, largest_weight = 0;
  each_node([&](double density, const double(&p)[3]) {
    for (int l = 0; l <= order; ++l)
      for (int m = 0; m <= order; ++m) a[l][m] += p[l] * p[m] / (density * nodes);
  });
  solve(a, s, order + 1);
  each_node([&](double density, const double(&p)[3]) {
    double smooth = 0;
    for (int l = 0; l <= order; ++l) smooth += s[l] * p[l];
    largest_weight = std::max(largest_weight, std::abs(1 - smooth / density));
  });
  // If the phase function is near 0 where the smooth part is not, its directions are too rare to
  // compensate. Lobes and droplets stay below 3.
  if (largest_weight > 4) return;
  phase.smooth_0 = static_cast<float>(s[0]);
  if (order > 0) phase.smooth_1 = static_cast<float>(s[1]);
  if (order > 1) phase.smooth_2 = static_cast<float>(s[2]);
}

Phase prepare_phase(const scene::Phase& phase, int order, int scatterings,
                    std::vector<std::vector<PhaseKnot>>& tables) {
  Phase prepared =
      std::visit(Overloaded{[](const scene::IsotropicPhase&) { return Phase{}; },
                            [](const scene::HenyeyGreensteinPhase& p) {
                              return Phase{Phase::Kind::henyey_greenstein, static_cast<float>(p.g)};
                            },
                            [](const scene::RayleighPhase&) {
                              return Phase{Phase::Kind::rayleigh, 0.0f};
                            },
                            [](const scene::TwoLobesPhase& p) {
                              return Phase{Phase::Kind::two_lobes, static_cast<float>(p.g1),
                                           static_cast<float>(p.g2), static_cast<float>(p.weight)};
                            },
                            [&](const scene::TabulatedPhase& p) {
                              return tabulated(*p.table, tables.emplace_back());
                            }},
                 phase);
  split_phase(prepared, order, scatterings);
  return prepared;
}

}  // namespace tyndall
