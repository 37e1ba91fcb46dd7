#include "tyndall/render/part.h"
#include "scene/values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "tyndall/base/hash.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall {
namespace {

/// Part `i` of `n` nearly equal parts of [0, total).
IndexRange share(std::uint64_t total, int i, int n) {
  const auto at = [&](int k) {  // not total * k / n, which may overflow
    const auto parts = static_cast<std::uint64_t>(n), part = static_cast<std::uint64_t>(k);
    return total / parts * part + total % parts * part / parts;
  };
  return {at(i), at(i + 1)};
}

[[noreturn]] void refuse(const std::string& a, const std::string& b, const std::string& why) {
  throw Error(ExitCode::input_missing, fmt::format("{}: cannot be merged with {}: {}", b, a, why));
}

void require_same(const Frame& a, const std::string& name, const Frame& b,
                  const std::string& other_name) {
  if (a.arithmetic != b.arithmetic) {
    refuse(name, other_name,
           fmt::format("its arithmetic version is {}, not {}: render both with one version of "
                       "Tyndall",
                       b.arithmetic, a.arithmetic));
  }
  if (a.seed != b.seed)
    refuse(name, other_name, fmt::format("its seed is {}, not {}", b.seed, a.seed));
  if (a.scene_hash != b.scene_hash) {
    refuse(name, other_name,
           fmt::format("it is of another scene ({:016x}, not {:016x}); photons.count and "
                       "gather.samples must be the same, too",
                       b.scene_hash, a.scene_hash));
  }
  // A damaged file may have the right hash but wrong sizes.
  const auto sizes = [](const Frame& f) {
    return std::tuple(f.photons, f.samples, f.replicates, f.components, f.width, f.height, f.cells,
                      f.light_words, f.groups.size(), f.detectors.count());
  };
  if (sizes(a) != sizes(b))
    refuse(name, other_name, "its sizes are not those of its scene: make it anew");
}

std::uint64_t hash_of(const std::vector<std::int64_t>& values) {
  Hasher hasher;
  hasher.add_all(values.data(), values.size());
  return hasher.value();
}

void merge(Replicate& a, const std::string& name, Replicate&& b, const std::string& other_name) {
  const bool same_light = a.photons == b.photons && light_hash(a) == light_hash(b);
  if (!same_light) {
    if (const Ranges twice = a.photons.common(b.photons); !twice.empty())
      refuse(name, other_name, fmt::format("both have photons {}", twice.text()));
    const auto is_blank = [](const Replicate& r) { return r.photons.empty() && r.samples.empty(); };
    if (!is_blank(a) && !is_blank(b) && !(a.samples.empty() && b.samples.empty())) {
      refuse(name, other_name,
             "their samples read the light of other photons; shoot all photons first, merge them, "
             "and give the result to all parts as --illumination");
    }
    a.photons.add(b.photons);
    add(a.shot, b.shot);
    add_to(a.detected, std::move(b.detected));
    add_to(a.light, std::move(b.light));
    if (a.light.empty() && a.light_hash == 0) a.light_hash = b.light_hash;
  } else if (a.light.empty()) {
    a.light = std::move(b.light);
  }
  a.samples.add(b.samples);
  add(a.gathered, b.gathered);
  add_to(a.film, std::move(b.film));
}

}  // namespace

void add_words(std::int64_t* sums, const std::int64_t* more, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    sums[i] = static_cast<std::int64_t>(static_cast<std::uint64_t>(sums[i])
                                        + static_cast<std::uint64_t>(more[i]));
  }
}

void add_to(std::vector<std::int64_t>& sums, std::vector<std::int64_t>&& more) {
  if (sums.empty())
    sums = std::move(more);
  else
    add_words(sums.data(), more.data(), more.size());
}

void add_to(FilmTallies& sums, FilmTallies&& more) {
  if (sums.pixels.empty()) {
    sums = std::move(more);
  } else {
    sums.add(more);
  }
}

std::uint64_t light_hash(const Replicate& replicate) {
  return replicate.light.empty() ? replicate.light_hash : hash_of(replicate.light);
}

void FilmTallies::add(const FilmTallies& other) {
  constexpr std::size_t words = sizeof(PixelTally) / sizeof(std::int64_t);
  add_words(reinterpret_cast<std::int64_t*>(pixels.data()),
            reinterpret_cast<const std::int64_t*>(other.pixels.data()),
            other.pixels.size() * words);
  add_words(groups.data(), other.groups.data(), other.groups.size());
  add_words(&clamped, &other.clamped, 1);
}

// ---- Ranges

Ranges::Ranges(std::vector<IndexRange> ranges) {
  for (const IndexRange& range : ranges) add(range);
}

void Ranges::add(IndexRange range) {
  if (range.begin >= range.end) return;
  auto after = std::find_if(ranges_.begin(), ranges_.end(),
                            [&](const IndexRange& r) { return r.begin >= range.end; });
  if (after != ranges_.end() && after->begin == range.end) {
    range.end = after->end;
    after = ranges_.erase(after);
  }
  if (after != ranges_.begin() && std::prev(after)->end == range.begin)
    std::prev(after)->end = range.end;
  else
    ranges_.insert(after, range);
}

void Ranges::add(const Ranges& other) {
  for (const IndexRange& range : other.ranges_) add(range);
}

Ranges Ranges::common(const Ranges& other) const {
  Ranges both;
  for (const IndexRange& a : ranges_)
    for (const IndexRange& b : other.ranges_)
      both.add({std::max(a.begin, b.begin), std::min(a.end, b.end)});
  return both;
}

Ranges Ranges::missing(IndexRange whole) const {
  Ranges gaps;
  std::uint64_t from = whole.begin;
  for (const IndexRange& range : ranges_) {
    gaps.add({from, std::min(range.begin, whole.end)});
    from = std::max(from, range.end);
  }
  gaps.add({from, whole.end});
  return gaps;
}

std::uint64_t Ranges::count() const {
  std::uint64_t sum = 0;
  for (const IndexRange& range : ranges_) sum += range.end - range.begin;
  return sum;
}

std::string Ranges::text() const {
  std::string text;
  for (const IndexRange& range : ranges_)
    text += fmt::format("{}{}:{}", text.empty() ? "" : ", ", range.begin, range.end);
  return text.empty() ? "none" : text;
}

bool Ranges::operator==(const Ranges& other) const {
  return std::equal(ranges_.begin(), ranges_.end(), other.ranges_.begin(), other.ranges_.end(),
                    [](const IndexRange& a, const IndexRange& b) {
                      return a.begin == b.begin && a.end == b.end;
                    });
}

// ---- Frames and parts

int replicate_count(std::uint64_t photons, std::uint64_t samples) {
  const std::uint64_t most = std::min<std::uint64_t>(samples, most_replicates);
  return static_cast<int>(photons > 0 ? std::min(photons, most) : most);
}

IndexRange Frame::photons_of(int r) const { return share(photons, r, replicates); }
IndexRange Frame::samples_of(int r) const { return share(samples, r, replicates); }

std::vector<const Replicate*> Partial::counted() const {
  std::vector<const Replicate*> all, read;
  for (const Replicate& r : replicates) {
    all.push_back(&r);
    if (!r.samples.empty()) read.push_back(&r);
  }
  return read.empty() ? all : read;
}

Ranges Partial::photons() const {
  Ranges all;
  for (const Replicate* r : counted()) all.add(r->photons);
  return all;
}

Ranges Partial::samples() const {
  Ranges all;
  for (const Replicate* r : counted()) all.add(r->samples);
  return all;
}

bool Partial::is_complete() const {
  return photons().count() == frame.photons && samples().count() == frame.samples;
}

Partial without_light(Partial part) {
  part.slice = {};
  part.measured[measurement::scattering] = {};
  if (part.film.pixels.empty()) return part;
  for (Replicate& r : part.replicates) {
    if (r.samples.empty()) r = {};
    r.light_hash = light_hash(r);
    r.light = {};
  }
  return part;
}

Ranges shot_twice(const Partial& a, const Partial& b) {
  Ranges twice;
  for (std::size_t r = 0; r < std::min(a.replicates.size(), b.replicates.size()); ++r) {
    if (a.replicates[r].samples.empty() && b.replicates[r].samples.empty())
      twice.add(a.replicates[r].photons.common(b.replicates[r].photons));
  }
  return twice;
}

void merge(Partial& part, const std::string& name, Partial other, const std::string& other_name) {
  require_same(part.frame, name, other.frame, other_name);
  if (part.matter_hash != 0 && other.matter_hash != 0 && part.matter_hash != other.matter_hash)
    refuse(name, other_name, "it is of other matter");
  Ranges twice;
  for (std::size_t r = 0; r < part.replicates.size(); ++r)
    twice.add(part.replicates[r].samples.common(other.replicates[r].samples));
  if (!twice.empty()) refuse(name, other_name, fmt::format("both have samples {}", twice.text()));
  for (std::size_t r = 0; r < part.replicates.size(); ++r)
    merge(part.replicates[r], name, std::move(other.replicates[r]), other_name);
  add_to(part.film, std::move(other.film));
  // The exposure is not in the scene's hash; the maximum does not depend on the order of parts.
  part.frame.exposure = std::max(part.frame.exposure, other.frame.exposure);
  if (part.matter_hash == 0) part.matter_hash = other.matter_hash;
  for (std::size_t m = 0; m < part.measured.size(); ++m)
    if (other.measured[m].done > part.measured[m].done)
      part.measured[m] = std::move(other.measured[m]);
}

std::uint64_t hash_tallies(const Partial& part) {
  Hasher hasher;
  hasher.add(part.matter_hash);
  Account shot{};
  std::vector<std::int64_t> detected(3 * part.frame.detectors.count());
  for (const Replicate* r : part.counted()) {
    if (!r->photons.empty() && part.frame.light_words > 0) hasher.add(light_hash(*r));
    add(shot, r->shot);
    add_words(detected.data(), r->detected.data(), r->detected.size());
  }
  hasher.add_all(detected.data(), detected.size());
  // The audit is left out: numbers of look-ups and cells are not results.
  hasher.add_all(reinterpret_cast<const std::int64_t*>(&shot.ledger),
                 sizeof shot.ledger / sizeof(std::int64_t));
  hasher.add_all(reinterpret_cast<const std::int64_t*>(part.film.pixels.data()),
                 part.film.pixels.size() * (sizeof(PixelTally) / sizeof(std::int64_t)));
  hasher.add_all(part.film.groups.data(), part.film.groups.size());
  return hasher.value();
}

int unlit_replicates(const Partial& part) {
  // Fewer than `enough` photons do not show the noise of the light. If the hits of camera paths
  // predict that many, and only a fraction `few` of them exist, thin density is not the reason.
  constexpr double enough = 30, few = 0.1;
  double hits = 0, samples = 0;
  for (const PixelTally& pixel : part.film.pixels) hits += static_cast<double>(pixel.hits);
  for (const Replicate& r : part.replicates) samples += static_cast<double>(r.samples.count());
  samples *= static_cast<double>(part.frame.pixels());
  if (hits < enough) return 0;
  return static_cast<int>(
      std::count_if(part.replicates.begin(), part.replicates.end(), [&](const Replicate& r) {
        if (r.samples.empty() || r.photons.empty()) return false;
        const double expected = hits / samples * static_cast<double>(r.photons.count());
        const auto lit = static_cast<double>(r.shot.audit.lit);
        return expected >= enough && lit < enough && lit < few * expected;
      }));
}

namespace {

/// Sums over the pixels that hit the medium, in luminance.
struct Spread {
  double mean = 0;      ///< of squared means
  double variance = 0;  ///< of the variances of the means
  double error = 0;     ///< of the squared standard errors of those variances
};

/// \return zeros if fewer than two replicates have samples, or the light of one is not converged.
Spread spread_of(const Partial& part) {
  double n = 0;
  int replicates = 0;
  for (const Replicate& r : part.replicates) {
    n += static_cast<double>(r.samples.count());
    replicates += !r.samples.empty();
  }
  Spread sum;
  if (replicates < 2 || unlit_replicates(part) > 0) return sum;
  const double freedom = replicates - 1;
  for (std::size_t i = 0; i < part.film.pixels.size(); ++i) {
    const PixelTally& pixel = part.film.pixels[i];
    if (pixel.hits == 0) continue;
    const double mean = luminance(pixel.sum[0], pixel.sum[1], pixel.sum[2]) / n;
    double off = 0;
    for (const Replicate& r : part.replicates) {
      if (r.film.empty()) continue;
      const double d = luminance(r.film[3 * i], r.film[3 * i + 1], r.film[3 * i + 2])
                       - static_cast<double>(r.samples.count()) * mean;
      off += d * d;
    }
    const double variance = off / (n * n) * replicates / freedom;
    sum.mean += mean * mean;
    sum.variance += variance;
    sum.error += 2 / freedom * variance * variance;
  }
  return sum;
}

}  // namespace

double relative_noise(const Partial& part) {
  const Spread sum = spread_of(part);
  return sum.mean > 0 ? std::sqrt(sum.variance / sum.mean)
                      : std::numeric_limits<double>::infinity();
}

bool is_noise_below(const Partial& part, double limit) {
  const Spread sum = spread_of(part);
  return sum.mean > 0 && sum.variance + std::sqrt(sum.error) <= limit * limit * sum.mean;
}

}  // namespace tyndall
