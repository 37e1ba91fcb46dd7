/// \file
/// Common parts of the formats of baked light.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "io/bake_file.h"
#include "io/convert_parts.h"

namespace tyndall::io {

/// Numbers or colours at the voxel centres of a box.
struct Texture {
  std::string name;
  std::array<int, 3> size{1, 1, 1};
  glm::dvec3 low{0.0}, high{1.0};
  int channels = 1;
  std::vector<float> values;  ///< [nz][ny][nx][channels]
};

inline std::size_t count(const std::array<int, 3>& size) {
  return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])
         * static_cast<std::size_t>(size[2]);
}

/// \return the medium of a bake. \param voxels along the longest side, if the medium is sampled
/// \param reads_volumes whether a grid of a file can be used unchanged
OneMedium matter_of_bake(const Bake& bake, int voxels, int threads, bool reads_volumes);

/// \return the extinction coefficient of the medium as a texture. \pre `medium` is not Stored
Texture density_of(const BakedLight& light, const OneMedium& medium);

/// Maximum of the voxels along the longest side of a page's density.
inline constexpr int most_page_voxels = 256;

/// \return a page for browsers that displays the lit cloud. \pre require_room_in_page() succeeds
std::string bake_page(const Bake& bake, const BakeOptions& options);
/// \throws Error(usage) if there are too many lights. \param path of the page, for the message
void require_room_in_page(const std::string& path, int lights);

}  // namespace tyndall::io
