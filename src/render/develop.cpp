#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/account.h"
#include "tyndall/base/hash.h"
#include "tyndall/base/math.h"
#include "tyndall/render/render.h"
#include "tyndall/transport/illumination.h"

namespace tyndall {
namespace {

/// Computes the picture of a part.
class Development {
 public:
  explicit Development(const Partial& part) : part_(part), pixels_(part.film.pixels) {
    for (const Replicate& r : part.replicates) {
      samples_ += static_cast<double>(r.samples.count());
      replicates_ += r.samples.empty() ? 0 : 1;
    }
  }

  int replicates() const { return replicates_; }

  Picture picture() const {
    const Frame& frame = part_.frame;
    Picture picture;
    picture.width = frame.width, picture.height = frame.height;
    picture.left = frame.left, picture.top = frame.top;
    picture.whole_width = frame.whole_width, picture.whole_height = frame.whole_height;
    picture.rgba.reserve(4 * pixels_.size());
    for (const PixelTally& pixel : pixels_) {
      for (const std::int64_t s : pixel.sum) picture.rgba.push_back(radiance(s));
      picture.rgba.push_back(static_cast<float>(static_cast<double>(pixel.hits) / samples_));
    }
    const auto color = [&](const std::string& name, const auto& value) {
      PictureLayer layer{name, "RGB", {}};
      layer.values.reserve(3 * pixels_.size());
      for (std::size_t i = 0; i < pixels_.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) layer.values.push_back(value(i, c));
      picture.layers.push_back(std::move(layer));
    };
    if (replicates_ > 1)
      color("variance", [&](std::size_t i, std::size_t c) { return variance(i, c); });
    color("emission",
          [&](std::size_t i, std::size_t c) { return radiance(pixels_[i].emission[c]); });
    color("single", [&](std::size_t i, std::size_t c) { return radiance(pixels_[i].single[c]); });
    color("multiple",
          [&](std::size_t i, std::size_t c) { return radiance(pixels_[i].multiple[c]); });
    color("albedo", [&](std::size_t i, std::size_t c) {
      return static_cast<float>(static_cast<double>(pixels_[i].albedo[c])
                                / (double{weight_units} * samples_));
    });
    const std::size_t groups = frame.groups.size();
    for (std::size_t g = 0; g < groups; ++g) {
      color("group_" + frame.groups[g], [&](std::size_t i, std::size_t c) {
        return radiance(part_.film.groups[(i * groups + g) * 3 + c]);
      });
    }
    if (part_.has(measurement::depth)) {
      picture.layers.push_back(
          {"depth", "Z",
           measurement::elements<float>(part_.measured[measurement::depth].words, frame.pixels())});
    }
    picture.layers.push_back(
        {"samples", "Y", std::vector<float>(pixels_.size(), static_cast<float>(samples_))});
    return picture;
  }

 private:
  double scale() const { return double{part_.frame.film_unit} / double{weight_units} / samples_; }
  float radiance(std::int64_t sum) const {
    return static_cast<float>(static_cast<double>(sum) * scale());
  }

  /// The variance of the mean of R replicates with n_r samples, whose sums are S_r:
  /// R / (R - 1) sum (S_r - n_r S / n)^2 / n^2.
  float variance(std::size_t i, std::size_t c) const {
    const double mean = static_cast<double>(pixels_[i].sum[c]) / samples_;
    double off = 0;
    for (const Replicate& r : part_.replicates) {
      if (r.film.empty()) continue;
      const double d =
          static_cast<double>(r.film[3 * i + c]) - static_cast<double>(r.samples.count()) * mean;
      off += d * d;
    }
    return static_cast<float>(off * replicates_ / (replicates_ - 1) * scale() * scale());
  }

  const Partial& part_;
  const std::vector<PixelTally>& pixels_;
  double samples_ = 0;  // per pixel
  int replicates_ = 0;
};

}  // namespace

RenderResult develop(const Partial& part) {
  RenderResult result;
  const Frame& frame = result.frame = part.frame;
  result.photons = part.photons();
  result.samples = part.samples();
  result.is_complete = part.is_complete();
  result.warnings = frame.warnings;
  result.detected.resize(3 * frame.detectors.count());
  Account shot{}, gathered{};
  for (const Replicate* r : part.counted()) {
    add(shot, r->shot);
    add(gathered, r->gathered);
    add_words(result.detected.data(), r->detected.data(), r->detected.size());
  }
  result.ledger = shot.ledger;
  result.shoot = shot.audit;
  result.gather = gathered.audit;
  result.clamped = static_cast<std::uint64_t>(part.film.clamped);
  const std::uint64_t photons = result.photons.count();
  result.photon_power = photons > 0 ? frame.shot_power / static_cast<double>(photons) : 0.0;
  std::copy(std::begin(frame.unshot_power), std::end(frame.unshot_power), result.unshot_power);

  result.noise = relative_noise(part);
  result.unlit_replicates = unlit_replicates(part);
  const Development film(part);
  result.replicates = film.replicates();
  result.picture = film.picture();
  Hasher pixel_bits;
  for (const float value : result.picture.rgba) pixel_bits.add(float_bits(value));
  result.hashes = {hash_tallies(part), pixel_bits.value()};

  if (result.unlit_replicates > 0) {
    const std::string why =
        frame.dim_lights.empty()
            ? ""
            : fmt::format(", since next to all of {} passes by", fmt::join(frame.dim_lights, ", "));
    result.warnings.push_back(fmt::format(
        "the light is not converged: of the {} photons that were shot, {} met matter, though the "
        "camera's paths found it{}: scattered light is missing or mere noise, which no figure of "
        "noise shows; aim the light at the medium, fit medium.box to it, shoot more photons, or "
        "take the integrator \"path\"",
        shot.ledger.shot, shot.audit.lit, why));
  }
  if (const double stalled = stalled_share(shot.ledger); stalled > 1e-6) {
    result.warnings.push_back(
        fmt::format("{:.3g} of the power stalled in endless flights: a bias", stalled));
  }
  if (const Ledger::Count outside = violations(result.shoot, result.gather); outside != 0) {
    result.warnings.push_back(
        fmt::format("{} audited look-ups lay outside the bounds of their super-voxel: the picture "
                    "is biased (a defect of Tyndall; please report it)",
                    outside));
  }
  if (result.clamped > 0) {
    result.warnings.push_back(fmt::format(
        "{} of {} samples were brighter than {:.4g} and were cut: the picture is "
        "too dark there",
        result.clamped, frame.pixels() * result.samples.count(), Film::range * frame.film_unit));
  }
  return result;
}

}  // namespace tyndall
