#include "scene/phases.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/checker.h"

namespace tyndall::scene {
namespace {

struct Peak {
  double fraction = 0;  ///< of the light, scattered into the interval
  double factor = 1;    ///< largest density divided by the least one in the interval
};
/// The interval of cosines, as wide as their rounding errors, that receives the most light.
Peak narrowest_peak(const Phase& phase) {
  constexpr double cosine_error = 1.8e-7;  // 2^-22.4
  const auto of_lobe = [](double g, double weight) {
    const double a = std::abs(g), square = (1 - a) * (1 - a);
    const double ratio = 1 + 2 * a * cosine_error / square;
    return Peak{weight * 0.5 * (1 - a * a) / (square * (1 - a)) * cosine_error,
                ratio * std::sqrt(ratio)};
  };
  if (const auto* hg = std::get_if<HenyeyGreensteinPhase>(&phase)) return of_lobe(hg->g, 1);
  if (const auto* lobes = std::get_if<TwoLobesPhase>(&phase)) {
    const Peak first = of_lobe(lobes->g1, lobes->weight),
               second = of_lobe(lobes->g2, 1 - lobes->weight);
    return first.fraction > second.fraction ? first : second;
  }
  const auto* tabulated = std::get_if<TabulatedPhase>(&phase);
  if (!tabulated) return {};
  const std::vector<double>&x = tabulated->table->cosines, &y = tabulated->table->values;
  double total = 0;
  for (std::size_t i = 1; i < x.size(); ++i) total += 0.5 * (y[i - 1] + y[i]) * (x[i] - x[i - 1]);
  // The interval starts or ends at the end of a segment.
  Peak narrowest;
  const auto consider = [&](double low, double high) {
    double sum = 0, least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t i = static_cast<std::size_t>(
             std::max<std::ptrdiff_t>(std::upper_bound(x.begin(), x.end(), low) - x.begin(), 1));
         i < x.size() && x[i - 1] < high; ++i) {
      const double a = std::max(low, x[i - 1]), b = std::min(high, x[i]);
      const auto at = [&](double c) {
        return std::lerp(y[i - 1], y[i], (c - x[i - 1]) / (x[i] - x[i - 1]));
      };
      sum += 0.5 * (at(a) + at(b)) * (b - a);
      least = std::min({least, at(a), at(b)}), most = std::max({most, at(a), at(b)});
    }
    if (sum > narrowest.fraction * total) narrowest = {sum / total, most / std::max(least, 1e-30)};
  };
  for (const double end : x) consider(end - cosine_error, end), consider(end, end + cosine_error);
  return narrowest;
}

}  // namespace

void check_phase(Checker& check, const std::string& path, const Phase& phase) {
  std::visit([&](const auto& p) { check.ranges(path, p); }, phase);
  if (const auto* tabulated = std::get_if<TabulatedPhase>(&phase)) {
    if (!tabulated->table) return check.error(path + ".file", "no table");
    const PhaseTableProblem problem = phase_table_problem(*tabulated->table);
    if (!problem.message.empty())
      return check.error(path + ".file", fmt::format("row {}: {}", problem.row, problem.message));
  }
  if (const Peak peak = narrowest_peak(phase); peak.fraction > 0.01)
    check.warning(
        path, fmt::format("a peak is as narrow as single precision resolves: {:.2g} % of the light "
                          "scatters into it, and pixels that see a light through it are wrong by a "
                          "factor of up to {:.3g}; take a g of at most 0.995, or a table with a "
                          "wider peak",
                          100 * peak.fraction, peak.factor));
}

PhaseTableProblem phase_table_problem(const PhaseTable& table) {
  const std::vector<double>&cosines = table.cosines, &values = table.values;
  const std::size_t rows = cosines.size();
  if (rows != values.size() || !limits::phase_rows.contains(static_cast<double>(rows))) {
    return {rows > 0 ? rows - 1 : 0,
            fmt::format("expected {:g} to {:g} rows, got {}", limits::phase_rows.low,
                        limits::phase_rows.high, std::min(rows, values.size()))};
  }
  for (std::size_t i = 0; i < rows; ++i) {
    if (!limits::phase_value.contains(values[i]))
      return {i, fmt::format("expected a value in [0, 1e30], got {}", values[i])};
    if (i == 0 && cosines[i] != -1)
      return {i, fmt::format("expected to begin with cosine -1, got {}", cosines[i])};
    if (i > 0 && !(cosines[i] > cosines[i - 1]))
      return {i, fmt::format("expected ascending cosines, got {} after {}", cosines[i],
                             cosines[i - 1])};
  }
  if (cosines.back() != 1)
    return {rows - 1, fmt::format("expected to end with cosine 1, got {}", cosines.back())};
  if (*std::max_element(values.begin(), values.end()) <= 0)
    return {rows - 1, "expected a value above 0, all are 0"};
  return {};
}

}  // namespace tyndall::scene
