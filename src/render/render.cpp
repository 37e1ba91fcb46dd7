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
#include "tyndall/render/huge_pages.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"

namespace tyndall {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// One pass, in parts and batches short enough for a bar that moves.
class PassRunner {
 public:
  PassRunner(const RenderOptions& options, const char* name, std::uint64_t total)
      : options_(options), name_(name), total_(total) {
    if (options.batch > 0) size_ = options.batch;
  }

  template <class Pass>
  void run(IndexRange part, const Pass& pass) {
    const auto start = Clock::now();
    for (std::uint64_t begin = part.begin; begin < part.end;) {
      report(done_);
      const std::uint64_t end = std::min(part.end, begin + size_);
      const auto batch_start = Clock::now();
      pass(IndexRange{begin, end});
      done_ += end - begin;
      begin = end;
      if (options_.batch == 0 && seconds_since(batch_start) < 0.1) size_ *= 2;
    }
    report(done_);
    seconds_ += seconds_since(start);
  }

  void report(std::uint64_t done) const {
    stop_if(options_.stop);
    if (options_.progress) options_.progress({name_, done, total_});
  }

  double seconds() const { return seconds_; }

 private:
  const RenderOptions& options_;
  const char* name_;
  std::uint64_t total_, done_ = 0, size_ = 1024;
  double seconds_ = 0;
};

/// Part `i` of `n` nearly equal parts of [0, total).
IndexRange share(std::uint64_t total, int i, int n) {
  const auto at = [&](int k) {  // not total * k / n, which may overflow
    const auto parts = static_cast<std::uint64_t>(n), part = static_cast<std::uint64_t>(k);
    return total / parts * part + total % parts * part / parts;
  };
  return {at(i), at(i + 1)};
}

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

double stalled_share(const Ledger& ledger) {
  const auto total = static_cast<double>(sum(ledger.shot_power, 3));
  return total > 0 ? static_cast<double>(sum(ledger.stalled_power, 3)) / total : 0.0;
}

/// Stalled photons are bias, and too many make the picture wrong.
void refuse_stalled(const Ledger& ledger) {
  const double share = stalled_share(ledger);
  if (!(share > 1e-3)) return;
  throw Error(
      ExitCode::internal,
      fmt::format("{:.3g} of the power stalled in flights of more than {} super-voxels (along "
                  "periodic sides through next to no matter: add extinction or open a side) or "
                  "{} virtual particles (beside matter far denser than all else: lower its "
                  "extinction, which is opaque long before, or raise medium.majorants.resolution)",
                  share, most_crossings, most_virtual));
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

/// D of each cell in absolute units: [length^2].
std::vector<float> read_out_matter(const PreparedScene& scene,
                                   const std::vector<std::int64_t>& matter) {
  const Vec3f size = scene.cell_size;
  const double points = 8.0 * scene.strata * scene.strata * scene.strata;
  const double volume =
      double{size.x} * double{size.y} * double{size.z} / (points * double{scene.matter_scale});
  std::vector<float> out;
  out.reserve(matter.size());
  advise_huge_pages(out.data(), matter.size() * sizeof(float));
  for (const std::int64_t d : matter)
    out.push_back(static_cast<float>(static_cast<double>(d) * volume));
  return out;
}

/// N in absolute units, of photons of `photon_power` [W]: made once, before the gather.
std::vector<float> read_out_light(const std::vector<std::int64_t>& sums, double photon_power) {
  const double weight = photon_power / double{weight_units};
  std::vector<float> out;
  out.reserve(sums.size());
  advise_huge_pages(out.data(), sums.size() * sizeof(float));
  for (const std::int64_t n : sums)
    out.push_back(static_cast<float>(static_cast<double>(n) * weight));
  return out;
}

/// The film of all replicates.
class Development {
 public:
  Development(const PreparedScene& scene, std::uint64_t samples, int replicates)
      : scene_(scene), samples_(samples), replicates_(replicates), spread_(3 * scene.pixels()) {
    sum_.pixels.resize(scene.pixels());
    sum_.groups.resize(scene.pixels() * scene.groups.size() * 3);
  }

  /// \param samples of each pixel of this replicate
  void add(const FilmTallies& film, std::uint64_t samples) {
    const auto n = static_cast<double>(samples);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const auto* from = reinterpret_cast<const std::int64_t*>(&film.pixels[i]);
      auto* to = reinterpret_cast<std::int64_t*>(&sum_.pixels[i]);
      for (std::size_t w = 0; w < pixel_words; ++w) to[w] += from[w];
      for (std::size_t c = 0; c < 3; ++c) {
        const auto s = static_cast<double>(film.pixels[i].sum[c]);
        spread_[3 * i + c].squares += s * s;
        spread_[3 * i + c].products += n * s;
      }
    }
    for (std::size_t i = 0; i < film.groups.size(); ++i) sum_.groups[i] += film.groups[i];
    sum_.clamped += film.clamped;
    sample_squares_ += n * n;
  }

  std::int64_t clamped() const { return sum_.clamped; }

  void hash(Hasher& hasher) const {
    hasher.add_all(reinterpret_cast<const std::int64_t*>(sum_.pixels.data()),
                   sum_.pixels.size() * pixel_words);
    hasher.add_all(sum_.groups.data(), sum_.groups.size());
  }

  /// \param depth see DepthPass::depth
  Picture picture(std::vector<float> depth) const {
    Picture picture;
    picture.width = scene_.film_width;
    picture.height = scene_.film_height;
    picture.rgba.reserve(sum_.pixels.size() * 4);
    for (const PixelTally& pixel : sum_.pixels) {
      for (const std::int64_t s : pixel.sum) picture.rgba.push_back(radiance(s));
      picture.rgba.push_back(
          static_cast<float>(static_cast<double>(pixel.hits) / static_cast<double>(samples_)));
    }
    const auto color = [&](const char* name, const auto& value) {
      PictureLayer layer{name, "RGB", {}};
      layer.values.reserve(3 * sum_.pixels.size());
      for (std::size_t i = 0; i < sum_.pixels.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) layer.values.push_back(value(i, c));
      picture.layers.push_back(std::move(layer));
    };
    if (replicates_ > 1)
      color("variance", [&](std::size_t i, std::size_t c) { return variance(i, c); });
    color("emission",
          [&](std::size_t i, std::size_t c) { return radiance(sum_.pixels[i].emission[c]); });
    color("single",
          [&](std::size_t i, std::size_t c) { return radiance(sum_.pixels[i].single[c]); });
    color("multiple",
          [&](std::size_t i, std::size_t c) { return radiance(sum_.pixels[i].multiple[c]); });
    color("albedo", [&](std::size_t i, std::size_t c) {
      return static_cast<float>(static_cast<double>(sum_.pixels[i].albedo[c])
                                / (double{weight_units} * static_cast<double>(samples_)));
    });
    const std::size_t groups = scene_.groups.size();
    for (std::size_t g = 0; g < groups; ++g) {
      color(("group_" + scene_.groups[g]).c_str(), [&](std::size_t i, std::size_t c) {
        return radiance(sum_.groups[(i * groups + g) * 3 + c]);
      });
    }
    picture.layers.push_back({"depth", "Z", std::move(depth)});
    picture.layers.push_back(
        {"samples", "Y", std::vector<float>(sum_.pixels.size(), static_cast<float>(samples_))});
    return picture;
  }

 private:
  static constexpr std::size_t pixel_words = sizeof(PixelTally) / sizeof(std::int64_t);

  double scale() const {
    return double{scene_.film_unit} / double{weight_units} / static_cast<double>(samples_);
  }
  float radiance(std::int64_t sum) const {
    return static_cast<float>(static_cast<double>(sum) * scale());
  }

  /// Of the mean of R replicates with n_r samples, whose sums are S_r:
  /// R / (R - 1) sum (S_r - n_r S / n)^2 / n^2.
  float variance(std::size_t i, std::size_t c) const {
    const auto [squares, products] = spread_[3 * i + c];
    const double mean = static_cast<double>(sum_.pixels[i].sum[c]) / static_cast<double>(samples_);
    const double off = squares - 2 * mean * products + mean * mean * sample_squares_;
    return static_cast<float>(std::max(off, 0.0) * replicates_ / (replicates_ - 1) * scale()
                              * scale());
  }

  struct Spread {
    double squares = 0, products = 0;  // sums of S_r^2 and n_r S_r
  };

  const PreparedScene& scene_;
  std::uint64_t samples_;
  int replicates_;
  FilmTallies sum_;
  std::vector<Spread> spread_;  // of each pixel's channels
  double sample_squares_ = 0;   // sum of n_r^2
};

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
  Hasher tallies;

  PassRunner bounds(options, "bounds", 1000);
  auto start = Clock::now();
  const PreparedScene prepared = prepare(
      scene, backend.threads(),
      [&](double done) { bounds.report(static_cast<std::uint64_t>(done * 1000)); }, options.stop);
  backend.load(prepared, options.stop);
  result.seconds.bounds = seconds_since(start);

  PassRunner matter(options, "matter", prepared.cells.count());
  std::vector<float> denominator;
  if (prepared.has_grid) {
    matter.run({0, prepared.cells.count()},
               [&](IndexRange range) { backend.measure_matter(range); });
    const std::vector<std::int64_t> sums = backend.take_matter();
    tallies.add_all(sums.data(), sums.size());
    denominator = read_out_matter(prepared, sums);
  }
  result.seconds.matter = matter.seconds();

  const std::uint64_t photons = prepared.emitters.empty() || !prepared.has_grid ? 0 : scene.photons;
  const std::uint64_t pixels = prepared.pixels();
  int replicates = static_cast<int>(std::min<std::uint64_t>(scene.samples, most_replicates));
  if (photons > 0) replicates = static_cast<int>(std::min<std::uint64_t>(photons, replicates));
  PassRunner shoot(options, "photons", photons),
      gather(options, "pixels", pixels * static_cast<std::uint64_t>(replicates));
  Development film(prepared, scene.samples, replicates);
  Account shot{}, gathered{};
  for (int r = 0; r < replicates; ++r) {
    // Its photons.
    const IndexRange part = share(photons, r, replicates);
    shoot.run(part, [&](IndexRange range) { backend.shoot(range); });
    add(shot, backend.take_account());
    close(shot.ledger);
    refuse_stalled(shot.ledger);
    // Its light.
    std::vector<float> numerator;
    if (prepared.has_grid) {
      const std::vector<std::int64_t> sums = backend.take_illumination();
      tallies.add_all(sums.data(), sums.size());
      const std::uint64_t count = part.end - part.begin;
      numerator =
          read_out_light(sums, count > 0 ? prepared.shot_power / static_cast<double>(count) : 0.0);
    }
    backend.illuminate(numerator, denominator);
    // Its samples.
    const IndexRange samples = share(scene.samples, r, replicates);
    gather.run({0, pixels}, [&](IndexRange range) {
      backend.gather(range, {samples.begin, samples.end - samples.begin});
    });
    add(gathered, backend.take_account());
    film.add(backend.take_film(), samples.end - samples.begin);
  }
  PassRunner depth(options, "depth", pixels);
  depth.run({0, pixels}, [&](IndexRange range) { backend.measure_depth(range); });
  result.seconds.depth = depth.seconds();
  result.seconds.photons = shoot.seconds();
  result.seconds.pixels = gather.seconds();
  result.replicates = replicates;

  result.detectors = prepared.detectors;
  result.detected = backend.take_detectors();
  if (!result.detected.empty()) tallies.add_all(result.detected.data(), result.detected.size());
  hash_ledger(tallies, shot.ledger);
  if (const double stalled = stalled_share(shot.ledger); stalled > 1e-6) {
    result.warnings.push_back(
        fmt::format("{:.3g} of the power stalled in endless flights: a bias", stalled));
  }
  result.ledger = in_scene_order(shot.ledger, prepared.scene_component);
  result.shoot = shot.audit;
  result.gather = gathered.audit;
  result.photon_power = photons > 0 ? prepared.shot_power / static_cast<double>(photons) : 0.0;
  for (int c = 0; c < 3; ++c) result.unshot_power[c] = prepared.unshot_power[c];
  film.hash(tallies);
  result.clamped = static_cast<std::uint64_t>(film.clamped());
  result.picture = film.picture(backend.take_depth());
  const CropWindow& window = prepared.camera.window;
  result.picture.left = window.left, result.picture.top = window.top;
  result.picture.whole_width = window.whole_width;
  result.picture.whole_height = window.whole_height;

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
