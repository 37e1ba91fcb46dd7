/// \file
/// Grids of voxels from files: NanoVDB buffers, checked before a pointer in them is followed.
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

/// What is wrong with a buffer, in words that complete "damaged: ".
class DamagedVolume : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Numbers of values, in bins of a fifth of their size.
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
  static constexpr std::uint32_t shift = 21;  // sign, exponent and two bits are left
  static constexpr std::size_t bins = std::size_t{1} << (32 - shift);
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(bins);
};

/// Values that a volume cannot have, and what they were made. Voxels are active ones; they count
/// once, however many of their channels are strange.
struct MendedValues {
  struct Voxels {
    std::uint64_t count = 0;
    glm::ivec3 first{0};  ///< in index space, the first by x, then y, then z
  };
  Voxels not_numbers;  ///< made 0
  /// Infinite, or beyond limits::density: made the largest, or the smallest, value of the others.
  Voxels above, below;
  float largest = 0, smallest = 0;
  bool background = false;  ///< was one of them: made 0, as are inactive values
};

/// One grid of floats (as they are, or in NanoVDB's Fp4, Fp8, Fp16, FpN) or of colours (Vec3f).
/// Every offset leads to a whole, aligned node within the buffer, every value is finite, and the
/// minimum and maximum of every node are those of all its values, active or not.
class Volume {
 public:
  /// \param buffer of `size` bytes, 32-byte aligned, which is kept and whose nodes' minima and
  /// maxima are written; strange values are mended in it. \throws DamagedVolume
  Volume(std::shared_ptr<std::byte> buffer, std::size_t size, int threads = 0);

  const std::byte* bytes() const { return buffer_.get(); }
  std::size_t size() const { return size_; }
  std::uint64_t hash() const { return hash_; }  ///< of the buffer

  std::string name() const;
  nanovdb::GridType type() const { return type_; }
  bool is_color() const { return type_ == nanovdb::GridType::Vec3f; }
  bool is_level_set() const;
  std::uint64_t active_voxels() const { return active_voxels_; }

  /// Active voxels and tiles, from the first to the last; low > high where there are none.
  glm::ivec3 low() const { return low_; }
  glm::ivec3 high() const { return high_; }
  /// Index space, voxels at integers, to the grid's own world space.
  const glm::dmat4& to_world() const { return to_world_; }
  float background() const { return background_; }  ///< of a colour: its largest channel
  float minimum() const { return minimum_; }        ///< of all values, of all channels
  float maximum() const { return maximum_; }
  /// How many active voxels there are of each kind of value; of a grid of colours: none.
  const ValueCounts& counts() const { return counts_; }
  const MendedValues& mended() const { return mended_; }

  /// \return the grid as walks read it; field space is index space from low() on.
  SparseGrid view() const;
  ColorGrid color_view() const;  ///< of a grid of colours

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

/// \return the grid's own world space to the field space of `field`, see scene::SparseGrid::Fit.
glm::dmat4 fitted(const scene::SparseGrid& field);

/// A box that a grid ends in.
struct ActiveBounds {
  glm::dvec3 low, high;
};

/// \return the box that holds all that interpolates an active voxel, in the space that `transform`
/// takes index space to.
ActiveBounds active_box(const Volume& volume, const glm::dmat4& transform);

}  // namespace tyndall
