#include "measure.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tyndall/base/hash.h"

namespace tyndall::bench {
namespace {

struct Mean {
  double value = 0, variance = 0;  // of the mean
};

template <class Get>
Mean mean(const std::vector<FirstFlight>& flights, const Get& get) {
  const auto n = static_cast<double>(flights.size());
  double sum = 0, squares = 0;
  for (const FirstFlight& f : flights) {
    const double x = get(f);
    sum += x, squares += x * x;
  }
  return {sum / n, (squares / n - sum / n * (sum / n)) / n};
}

double z(const Mean& a, const Mean& b) {
  const double variance = a.variance + b.variance;
  return variance > 0 ? (a.value - b.value) / std::sqrt(variance) : (a.value == b.value ? 0 : 99);
}

double escaped(const FirstFlight& f) { return f.collided ? 0.0 : 1.0; }
double way(const FirstFlight& f) { return f.length; }

constexpr double most_z = 4.5;  // some hundred comparisons: 1 in 1000 runs

std::uint64_t tally_hash(Row& row, std::uint64_t photons) {
  const Sample sample = row.run(0, photons);
  Hasher hasher;
  hasher.add_all(row.illumination().data(), row.illumination().size());
  hasher.add_all(reinterpret_cast<const std::int64_t*>(&sample.account.ledger),
                 sizeof(Ledger) / sizeof(std::int64_t));
  return hasher.value();
}

Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {values[values.size() / 2], values.front(), values.back()};
}

}  // namespace

double Result::per_real(Audit::Count count) const {
  return static_cast<double>(count)
         / static_cast<double>(std::max<Audit::Count>(account.audit.real, 1));
}

double Result::collisions_per_second() const {
  return photons_per_second.median * static_cast<double>(account.audit.real)
         / static_cast<double>(photons);
}

Verdict check(Stage& stage) {
  Verdict verdict;
  const auto say = [&](bool good, const std::string& line) {
    verdict.lines.push_back((good ? "  ok     " : "  FAILED ") + line);
    verdict.agree = verdict.agree && good;
  };
  constexpr std::uint64_t flights = 20000;
  const std::vector<FirstFlight> reference = first_flights(stage, "super_voxel_2011", flights, 11);
  std::uint64_t seed = 11;
  for (const char* row :
       {"woodcock", "woodcock_squeezed", "super_voxel_2011/32", "super_voxel_2011/64", "tyndall"}) {
    const std::vector<FirstFlight> own = first_flights(stage, row, flights, ++seed);
    const double z_way = z(mean(own, way), mean(reference, way));
    const double z_escape = z(mean(own, escaped), mean(reference, escaped));
    say(std::abs(z_way) < most_z && std::abs(z_escape) < most_z,
        fmt::format("{}: first flights of {:.5f}, {:.4f} escape; z = {:.2f}, {:.2f}", row,
                    mean(own, way).value, mean(own, escaped).value, z_way, z_escape));
  }

  auto rows = rows_of(stage, "cpu");
  const std::unique_ptr<Row> plain = reference_of_render(stage);
  const bool same = tally_hash(*rows.back(), 20000) == tally_hash(*plain, 20000);
  say(same, "tyndall: tally and ledger of 20000 photons, bit for bit those of the plain walk");

  // Steps: their number grows with the resolution, so fewer photons.
  const auto steps = static_cast<std::uint64_t>(std::max(40, (1 << 19) >> stage.which.octaves));
  const std::vector<FirstFlight> marched = first_flights(stage, "ray_marching", steps, 31);
  double expected = 0, variance = 0, truth = 0, observed = 0;
  for (std::uint64_t i = 0; i < steps; ++i) {
    const double p = std::exp(-marched_depth(stage, i, 31, 1));
    expected += p, variance += p * (1 - p);
    truth += std::exp(-marched_depth(stage, i, 31, 4));
    observed += escaped(marched[i]);
  }
  const double n = static_cast<double>(steps);
  const double z_steps = variance > 0 ? (observed - expected) / std::sqrt(variance)
                                      : (observed == expected ? 0.0 : 99.0);
  say(std::abs(z_steps) < most_z,
      fmt::format(
          "ray_marching: {:.4f} of {} escape, {:.4f} by its steps (z = {:.2f}); bias of the "
          "steps {:+.2g}",
          observed / n, steps, expected / n, z_steps, (expected - truth) / n));
  return verdict;
}

std::vector<Result> measure(Stage& stage, const Options& options,
                            const std::function<bool(const std::string&)>& wanted) {
  struct Running {
    std::unique_ptr<Row> grey, color;
    std::uint64_t photons;
    std::vector<double> rates, color_rates;
    Result result;
  };
  std::vector<Running> all;
  auto colors = rows_of(stage, options.device);
  auto greys = rows_of(stage, options.device);
  for (std::size_t i = 0; i < greys.size(); ++i) {
    if (!wanted(greys[i]->name())) continue;
    Running r{std::move(greys[i]), std::move(colors[i]), options.photons, {}, {}, {}};
    r.color->store_color();
    r.result.which = stage.which;
    r.result.sampler = r.grey->name();
    r.result.device = options.device;
    r.result.threads = options.threads;
    r.result.paper = paper_rate(stage.which, r.grey->name());
    // A warm-up that doubles until it takes long enough to say how many photons fit the time.
    if (r.photons == 0) {
      std::uint64_t trial = 8;
      Sample s = r.grey->run(0, trial);
      while (s.seconds < 0.1) s = r.grey->run(0, trial *= 2);
      const double each = options.seconds / (2.0 * options.repeats);
      r.photons = std::max<std::uint64_t>(
          8, static_cast<std::uint64_t>(static_cast<double>(trial) * each / s.seconds));
    }
    all.push_back(std::move(r));
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (Running& r : all) {
      const std::uint64_t begin = static_cast<std::uint64_t>(repeat) * r.photons;
      const Sample grey = r.grey->run(begin, r.photons);
      const Sample color = r.color->run(begin, r.photons);
      const auto photons = static_cast<double>(r.photons);
      r.rates.push_back(photons / grey.seconds);
      r.color_rates.push_back(photons / color.seconds);
      r.result.photons += r.photons;
      add(r.result.account, grey.account);
    }
  }
  std::vector<Result> results;
  for (Running& r : all) {
    r.result.photons_per_second = spread(r.rates);
    r.result.photons_per_second_color = spread(r.color_rates);
    results.push_back(r.result);
  }
  return results;
}

}  // namespace tyndall::bench
