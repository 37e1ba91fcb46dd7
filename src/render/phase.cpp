#include "render/phase.h"

#include <algorithm>

#include "render/scene_values.h"

namespace tyndall {
namespace {

/// Integral over the sphere of what is linear in the cosine between `a` and `b` and outside of them
/// 0, times f(cosine), of degree 2 at most: two points of Gauss and Legendre are exact.
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
    // Of rows that single precision cannot tell apart the last one counts.
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

}  // namespace

Phase prepare_phase(const scene::Phase& phase, std::vector<std::vector<PhaseKnot>>& tables) {
  return std::visit(
      Overloaded{[](const scene::IsotropicPhase&) { return Phase{}; },
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
}

}  // namespace tyndall
