#include "tyndall/render/render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "tyndall/base/hash.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/check.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"

namespace tyndall {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Runs a pass over [0, total) in batches, short enough for a bar that moves.
class Batches {
 public:
  explicit Batches(const RenderOptions& options) : options_(options) {}

  template <class Pass>
  void run(const char* name, std::uint64_t total, const Pass& pass) const {
    std::uint64_t size = options_.batch > 0 ? options_.batch : 1024;
    for (std::uint64_t begin = 0; begin < total;) {
      report(name, begin, total);
      const std::uint64_t end = std::min(total, begin + size);
      const auto start = Clock::now();
      pass(IndexRange{begin, end});
      begin = end;
      if (options_.batch == 0 && seconds_since(start) < 0.1) size *= 2;
    }
    report(name, total, total);
  }

  void report(const char* name, std::uint64_t done, std::uint64_t total) const {
    stop_if(options_.stop);
    if (options_.progress) options_.progress({name, done, total});
  }

 private:
  const RenderOptions& options_;
};

std::int64_t sum(const std::int64_t* counts, int n) {
  std::int64_t s = 0;
  for (int i = 0; i < n; ++i) s += counts[i];
  return s;
}

/// Every fate was counted where it happened; here they must add up to what was shot, and power must
/// too.
void close(const Ledger& ledger) {
  const std::int64_t ended = ledger.missed + sum(ledger.escaped, 6)
                             + sum(ledger.absorbed, max_components) + ledger.rouletted
                             + ledger.stalled;
  if (ended != ledger.shot) {
    throw Error(
        ExitCode::internal,
        fmt::format("the ledger does not close: {} photons were shot, {} ended (a defect of "
                    "Tyndall or of this machine's memory; please report it)",
                    ledger.shot, ended));
  }
  for (int c = 0; c < 3; ++c) {
    std::int64_t power =
        ledger.missed_power[c] + ledger.roulette_power[c] + ledger.stalled_power[c];
    for (const auto& face : ledger.escaped_power) power += face[c];
    for (const auto& component : ledger.absorbed_power) power += component[c];
    if (power != ledger.shot_power[c]) {
      throw Error(ExitCode::internal,
                  fmt::format("the ledger does not close: of the {} units of {} power shot, {} are "
                              "accounted for (a defect of Tyndall or of this machine's memory; "
                              "please report it)",
                              ledger.shot_power[c],
                              c == 0   ? "red"
                              : c == 1 ? "green"
                                       : "blue",
                              power));
    }
  }
}

/// Stalled photons are bias, and too many make the picture wrong.
void check_stalled(const Ledger& ledger, std::vector<std::string>& warnings) {
  const auto total = static_cast<double>(sum(ledger.shot_power, 3));
  const double share = total > 0 ? static_cast<double>(sum(ledger.stalled_power, 3)) / total : 0.0;
  if (share > 1e-3) {
    throw Error(
        ExitCode::internal,
        fmt::format(
            "{:.3g} of the power stalled in flights of more than {} super-voxels (along "
            "periodic sides through next to no matter: add extinction or open a side) or "
            "{} virtual particles (beside matter far denser than all else: lower its "
            "extinction, which is opaque long before, or raise medium.majorants.resolution)",
            share, most_crossings, most_virtual));
  }
  if (share > 1e-6)
    warnings.push_back(
        fmt::format("{:.3g} of the power stalled in endless flights: a bias", share));
}

/// From the components of the prepared medium, which are sorted, to the scene's.
Ledger in_scene_order(const Ledger& ledger, const std::vector<int>& scene_component) {
  Ledger out = ledger;
  for (std::size_t i = 0; i < scene_component.size(); ++i) {
    const auto to = static_cast<std::size_t>(scene_component[i]);
    out.absorbed[to] = ledger.absorbed[i];
    std::memcpy(out.absorbed_power[to], ledger.absorbed_power[i], sizeof out.absorbed_power[to]);
  }
  return out;
}

/// Not the audit: how many look-ups and cells a walk took is no part of its result.
void hash_ledger(Hasher& hasher, const Ledger& ledger) {
  hasher.add_all(reinterpret_cast<const std::int64_t*>(&ledger),
                 sizeof ledger / sizeof(std::int64_t));
}

struct Illumination {
  std::vector<float> numerator, denominator;
};

/// The tallies in absolute units, in float: made once, before the gather.
Illumination read_out(const PreparedScene& scene, const std::vector<std::int64_t>& sums,
                      const std::vector<std::int64_t>& matter, double photon_power) {
  Illumination out;
  const double weight = photon_power / double{weight_units};
  const Vec3f size = scene.cell_size;
  const double points = 8.0 * scene.strata * scene.strata * scene.strata;
  const double volume =
      double{size.x} * double{size.y} * double{size.z} / (points * double{scene.matter_scale});
  out.numerator.reserve(sums.size());
  for (const std::int64_t n : sums)
    out.numerator.push_back(static_cast<float>(static_cast<double>(n) * weight));
  out.denominator.reserve(matter.size());
  for (const std::int64_t d : matter)
    out.denominator.push_back(static_cast<float>(static_cast<double>(d) * volume));
  return out;
}

Picture develop(const PreparedScene& scene, const FilmTallies& film, std::uint64_t samples) {
  Picture picture{scene.film_width, scene.film_height, {}, {}};
  picture.rgba.reserve(film.pixels.size() * 4);
  const double scale =
      double{scene.film_unit} / double{weight_units} / static_cast<double>(samples);
  for (const PixelTally& pixel : film.pixels) {
    for (const std::int64_t s : pixel.sum)
      picture.rgba.push_back(static_cast<float>(static_cast<double>(s) * scale));
    picture.rgba.push_back(
        static_cast<float>(static_cast<double>(pixel.hits) / static_cast<double>(samples)));
  }
  return picture;
}

void require_valid(const Scene& scene, std::vector<std::string>& warnings) {
  const Problems problems = check(scene);
  std::string text;
  for (const Problem& p : problems.errors)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", p.path, p.message);
  if (!text.empty()) throw Error(ExitCode::scene_invalid, text);
  for (const Problem& p : problems.warnings)
    warnings.push_back(fmt::format("{}: {}", p.path, p.message));
}

}  // namespace

RenderResult render(const Scene& scene, Backend& backend, const RenderOptions& options) {
  const DefaultFloatingPoint guard;
  RenderResult result;
  require_valid(scene, result.warnings);
  const Batches batches(options);
  Hasher tallies;

  auto start = Clock::now();
  const auto bounds_done = [&](double share) {
    batches.report("bounds", static_cast<std::uint64_t>(share * 1000), 1000);
  };
  const PreparedScene prepared = prepare(scene, backend.threads(), bounds_done, options.stop);
  backend.load(prepared, options.stop);
  result.seconds.bounds = seconds_since(start);

  start = Clock::now();
  const std::uint64_t photons = prepared.emitters.empty() || !prepared.has_grid ? 0 : scene.photons;
  batches.run("photons", photons, [&](IndexRange range) { backend.shoot(range); });
  result.seconds.photons = seconds_since(start);
  Account account = backend.take_account();
  hash_ledger(tallies, account.ledger);
  close(account.ledger);
  check_stalled(account.ledger, result.warnings);
  result.ledger = in_scene_order(account.ledger, prepared.scene_component);
  result.shoot = account.audit;
  result.photon_power = photons > 0 ? prepared.shot_power / static_cast<double>(photons) : 0.0;
  for (int c = 0; c < 3; ++c) result.unshot_power[c] = prepared.unshot_power[c];

  start = Clock::now();
  Illumination illumination;
  if (prepared.has_grid) {
    batches.run("matter", prepared.cells.count(),
                [&](IndexRange range) { backend.measure_matter(range); });
    const std::vector<std::int64_t> sums = backend.take_illumination(),
                                    matter = backend.take_matter();
    tallies.add_all(sums.data(), sums.size());
    tallies.add_all(matter.data(), matter.size());
    illumination = read_out(prepared, sums, matter, result.photon_power);
  }
  result.seconds.matter = seconds_since(start);

  start = Clock::now();
  backend.illuminate(illumination.numerator, illumination.denominator);
  const std::uint64_t pixels = static_cast<std::uint64_t>(prepared.film_width)
                               * static_cast<std::uint64_t>(prepared.film_height);
  batches.run("pixels", pixels * scene.samples, [&](IndexRange range) { backend.gather(range); });
  const FilmTallies film = backend.take_film();
  account = backend.take_account();
  result.gather = account.audit;
  result.clamped = static_cast<std::uint64_t>(film.clamped);
  tallies.add_all(reinterpret_cast<const std::int64_t*>(film.pixels.data()),
                  film.pixels.size() * sizeof(PixelTally) / sizeof(std::int64_t));
  result.picture = develop(prepared, film, scene.samples);
  const CropWindow& window = prepared.camera.window;
  result.picture.left = window.left, result.picture.top = window.top;
  result.picture.whole_width = window.whole_width;
  result.picture.whole_height = window.whole_height;
  result.seconds.pixels = seconds_since(start);

  if (const auto violations = result.shoot.violations + result.gather.violations; violations > 0) {
    result.warnings.push_back(
        fmt::format("{} audited look-ups lay outside the bounds of their super-voxel: the picture "
                    "is biased (a defect of Tyndall; please report it)",
                    violations));
  }
  Hasher pixel_bits;
  for (const float value : result.picture.rgba) pixel_bits.add(float_bits(value));
  result.hashes = {tallies.value(), pixel_bits.value()};
  if (result.clamped > 0) {
    result.warnings.push_back(
        fmt::format("{} of {} samples were brighter than {:.4g} and were cut: the picture is a "
                    "little too dark there",
                    result.clamped, pixels * scene.samples, Film::range * prepared.film_unit));
  }
  return result;
}

}  // namespace tyndall
