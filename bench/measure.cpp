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

/// \return scatterings per photon of a row, for photons from `begin` on.
Mean scatterings(Row& row, std::uint64_t begin) {
  constexpr int batches = 32;
  constexpr std::uint64_t photons = 256;  // of a batch
  double sum = 0, squares = 0;
  for (int i = 0; i < batches; ++i) {
    const Sample sample = row.run(begin + static_cast<std::uint64_t>(i) * photons, photons);
    const double x = static_cast<double>(sample.account.audit.real) / double{photons};
    sum += x, squares += x * x;
  }
  const double value = sum / batches;
  return {value, (squares / batches - value * value) / (batches - 1)};
}

double escaped(const FirstFlight& f) { return f.collided ? 0.0 : 1.0; }
double distance(const FirstFlight& f) { return f.length; }

constexpr double most_z = 4.5;  // some hundred comparisons: a false alarm in 1 of 1000 runs

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

Verdict check(Stage& stage, const std::string& device) {
  Verdict verdict;
  const auto say = [&](bool good, const std::string& line) {
    verdict.lines.push_back((good ? "  ok     " : "  FAILED ") + line);
    verdict.agree = verdict.agree && good;
  };
  constexpr std::uint64_t flights = 1 << 17;
  const std::vector<FirstFlight> reference = first_flights(stage, "super_voxel_2011", flights, 11);
  std::uint64_t seed = 11;
  for (const char* row :
       {"woodcock", "woodcock_squeezed", "super_voxel_2011/32", "super_voxel_2011/64", "tyndall"}) {
    const std::vector<FirstFlight> own = first_flights(stage, row, flights, ++seed);
    const double z_distance = z(mean(own, distance), mean(reference, distance));
    const double z_escape = z(mean(own, escaped), mean(reference, escaped));
    say(std::abs(z_distance) < most_z && std::abs(z_escape) < most_z,
        fmt::format("{}: first flights of {:.5f}, {:.4f} escape; z = {:.2f}, {:.2f}", row,
                    mean(own, distance).value, mean(own, escaped).value, z_distance, z_escape));
  }

  // Whole photons of the rows that are timed.
  const std::unique_ptr<Row> plain = reference_of_render(stage);
  const Mean usual = scatterings(*plain, 0);
  const std::uint64_t plain_hash = tally_hash(*plain, 20000);
  std::uint64_t begin = 0;
  for (const std::unique_ptr<Row>& row : rows_of(stage, device)) {
    begin += 1 << 20;
    if (row->name() == "ray_marching") continue;
    const Mean own = scatterings(*row, begin);
    say(std::abs(z(own, usual)) < most_z,
        fmt::format("{}: {:.3f} scatterings per photon; z = {:.2f}", row->name(), own.value,
                    z(own, usual)));
    if (row->name().starts_with("tyndall") && row->name() != "tyndall/fast_math")
      say(tally_hash(*row, 20000) == plain_hash,
          fmt::format("{}: tally and ledger of 20000 photons, bit for bit those of the plain walk",
                      row->name()));
  }

  // Ray marching: the number of steps grows with the resolution, so there are fewer photons. A
  // photon travels the depth min(tau, T), where T is the depth of the whole ray; the mean is
  // 1 - exp(-T).
  const auto steps = static_cast<std::uint64_t>(std::max(400, (1 << 21) >> stage.which.octaves));
  const std::vector<FirstFlight> marched = first_flights(stage, "ray_marching", steps, 31);
  double gone = 0, expected = 0, variance = 0;
  for (std::uint64_t i = 0; i < steps; ++i) {
    const double whole = marched_depth(stage, i, 31, 1), left = std::exp(-whole);
    gone += marched[i].collided ? marched_depth(stage, i, 31, 1, marched[i].length) : whole;
    expected += 1 - left;
    variance += 2 * (1 - left * (1 + whole)) - (1 - left) * (1 - left);
  }
  constexpr std::uint64_t rays = 40;
  double bias = 0;
  for (std::uint64_t i = 0; i < rays; ++i)
    bias += std::exp(-marched_depth(stage, i, 31, 1)) - std::exp(-marched_depth(stage, i, 31, 4));
  const double n = static_cast<double>(steps);
  const double z_steps =
      variance > 0 ? (gone - expected) / std::sqrt(variance) : (gone == expected ? 0.0 : 99.0);
  say(std::abs(z_steps) < most_z,
      fmt::format("ray_marching: {} first flights through a depth of {:.4f}, {:.4f} by its steps "
                  "(z = {:.2f}); its bias, of the escapes along {} rays: {:+.2g}",
                  steps, gone / n, expected / n, z_steps, rays, bias / double{rays}));
  return verdict;
}

std::vector<Result> measure(Stage& stage, const Options& options,
                            const std::function<bool(const std::string&)>& wanted) {
  struct Running {
    std::unique_ptr<Row> grey, color;
    std::uint64_t photons;
    std::vector<double> rates, color_rates, collision_rates;
    Result result;
  };
  std::vector<Running> all;
  auto colors = rows_of(stage, options.device);
  auto greys = rows_of(stage, options.device);
  for (std::size_t i = 0; i < greys.size(); ++i) {
    if (!wanted(greys[i]->name())) continue;
    Running r{std::move(greys[i]), std::move(colors[i]), options.photons, {}, {}, {}, {}};
    r.color->store_color();
    r.result.which = stage.which;
    r.result.sampler = r.grey->name();
    r.result.device = options.device;
    r.result.threads = options.threads;
    r.result.paper = paper_rate(stage.which, r.grey->name());
    // Warms up, doubling the photons until the time is long enough to estimate how many fit.
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
      r.collision_rates.push_back(static_cast<double>(grey.account.audit.real) / grey.seconds);
      r.result.photons += r.photons;
      add(r.result.account, grey.account);
    }
  }
  std::vector<Result> results;
  for (Running& r : all) {
    r.result.photons_per_second = spread(r.rates);
    r.result.photons_per_second_color = spread(r.color_rates);
    r.result.collisions_per_second = spread(r.collision_rates);
    results.push_back(r.result);
  }
  return results;
}

}  // namespace tyndall::bench
