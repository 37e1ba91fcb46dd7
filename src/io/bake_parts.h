/// \file
/// What the formats of baked light share.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "io/bake_file.h"
#include "io/convert_parts.h"

namespace tyndall::io {

/// Numbers or colours at the middles of the voxels of a box.
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

/// \param voxels along the longest side of what is sampled \param reads_volumes whether a grid of a
/// file is taken as it is
OneMedium matter_of_bake(const Bake& bake, int voxels, int threads, bool reads_volumes);

/// The extinction of all matter, as samples. \pre it is not stored
Texture density_of(const BakedLight& light, const OneMedium& medium);

/// Voxels along the longest side of a page's matter, at most.
inline constexpr int most_page_voxels = 256;

/// A page for browsers, in which the lit cloud can be turned. \pre there is room for its lights
std::string bake_page(const Bake& bake, const BakeOptions& options);
/// \throws Error(usage) where there are too many; `path` is the page's
void require_room_in_page(const std::string& path, int lights);

}  // namespace tyndall::io
