/// \file
/// A radiance image, for environment lights.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tyndall/base/vec3.h"

namespace tyndall {

class Image {
 public:
  /// \param texels width times height, linear RGB from the top left. Channels that are NaN,
  /// negative or above largest_texel are mended, and their texels counted.
  Image(int width, int height, std::vector<Vec3f> texels);

  static constexpr float largest_texel = 1e12f;

  int width() const { return width_; }
  int height() const { return height_; }
  const std::vector<Vec3f>& texels() const { return texels_; }
  std::size_t mended() const { return mended_; }  ///< texels
  float largest() const { return largest_; }      ///< of all channels
  std::uint64_t hash() const { return hash_; }    ///< of size and texels

 private:
  int width_, height_;
  std::vector<Vec3f> texels_;
  std::size_t mended_ = 0;
  float largest_ = 0;
  std::uint64_t hash_ = 0;
};

}  // namespace tyndall
