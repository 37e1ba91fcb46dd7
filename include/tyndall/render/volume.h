/// \file
/// Voxel grids from files: NanoVDB buffers, checked before a pointer in them is followed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "tyndall/base/math.h"
#include "tyndall/medium/sparse_grid.h"
#include "tyndall/render/parallel.h"
#include "tyndall/scene/scene.h"

namespace tyndall {

/// Thrown for a damaged buffer. Its message completes "damaged: ".
class DamagedVolume : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A histogram of values, in bins with a width of about a fifth of the value.
class ValueCounts {
 public:
  void add(float value, std::uint64_t count = 1) { counts_[float_bits(value) >> shift] += count; }
  void add(const ValueCounts& other) {
    for (std::size_t bin = 0; bin < bins; ++bin) counts_[bin] += other.counts_[bin];
  }
  /// Calls visit(value, count) for the middle of every bin that is not empty; 0 for denormals.
  template <class Visit>
  void for_each(Visit&& visit) const {
    constexpr std::uint32_t exponent = 0x7f800000u, half = 1u << (shift - 1);
    for (std::uint32_t bin = 0; bin < bins; ++bin) {
      const std::uint32_t bits = bin << shift;
      if (counts_[bin] > 0)
        visit((bits & exponent) == 0 ? 0.0f : bits_float(bits | half), counts_[bin]);
    }
  }

 private:
  static constexpr std::uint32_t shift = 21;  // keeps sign, exponent and two bits
  static constexpr std::size_t bins = std::size_t{1} << (32 - shift);
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(bins);
};

/// Invalid values of a volume, and their replacements. Only active voxels are counted, each once,
/// however many of its channels are invalid.
struct MendedValues {
  struct Voxels {
    std::uint64_t count = 0;
    glm::ivec3 first{0};  ///< in index space, the first by x, then y, then z
  };
  Voxels not_numbers;  ///< NaN: replaced by 0
  /// Infinite, or beyond limits::density: replaced by the largest or smallest value of the others.
  Voxels above, below;
  float largest = 0, smallest = 0;
  bool background = false;  ///< it was invalid: replaced by 0, as are inactive values
};

/// One grid of floats (plain, or NanoVDB's Fp4, Fp8, Fp16, FpN) or of colours (Vec3f). Invariants:
/// every offset leads to a complete, aligned node within the buffer, every value is finite, and the
/// minimum and maximum of every node are those of all its values, active or not.
class Volume {
 public:
  /// Keeps `buffer`, replaces its invalid values, and writes its nodes' minima and maxima.
  /// \param buffer of `size` bytes, 32-byte aligned \throws DamagedVolume
  Volume(std::shared_ptr<std::byte> buffer, std::size_t size, int threads = 0);

  const std::byte* bytes() const { return buffer_.get(); }
  std::size_t size() const { return size_; }
  std::uint64_t hash() const { return hash_; }  ///< of the buffer

  std::string name() const;
  nanovdb::GridType type() const { return type_; }
  bool is_color() const { return type_ == nanovdb::GridType::Vec3f; }
  bool is_level_set() const;
  std::uint64_t active_voxels() const { return active_voxels_; }

  /// The box of active voxels and tiles, from the first to the last; low > high if there are none.
  glm::ivec3 low() const { return low_; }
  glm::ivec3 high() const { return high_; }
  /// Maps index space, with voxels at integers, to the grid's own world space.
  const glm::dmat4& to_world() const { return to_world_; }
  float background() const { return background_; }  ///< for colours: the largest channel
  float minimum() const { return minimum_; }        ///< of all values, of all channels
  float maximum() const { return maximum_; }
  /// The histogram of active voxels; empty for a grid of colours.
  const ValueCounts& counts() const { return counts_; }
  const MendedValues& mended() const { return mended_; }

  /// \return the grid for walks; the origin of field space is low() in index space.
  SparseGrid view() const;
  ColorGrid color_view() const;  ///< for a grid of colours

 private:
  template <class V>
  void check(int threads);

  std::shared_ptr<std::byte> buffer_;
  std::size_t size_ = 0;
  std::uint64_t hash_ = 0, root_ = 0, active_voxels_ = 0;
  nanovdb::GridType type_ = nanovdb::GridType::Unknown;
  glm::ivec3 low_{0}, high_{-1};
  glm::dmat4 to_world_{1.0};
  float background_ = 0, minimum_ = 0, maximum_ = 0;
  ValueCounts counts_;
  MendedValues mended_;
};

/// \return the map from the grid's own world space to the field space of `field`, see
/// scene::SparseGrid::Fit.
glm::dmat4 fitted(const scene::SparseGrid& field);

/// The bounding box of a grid.
struct ActiveBounds {
  glm::dvec3 low, high;
};

/// \return the box of all points whose interpolation reads an active voxel, in the space to which
/// `transform` maps index space.
ActiveBounds active_box(const Volume& volume, const glm::dmat4& transform);

}  // namespace tyndall
