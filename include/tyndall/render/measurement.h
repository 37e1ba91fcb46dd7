/// \file
/// Measurements: quantities that are computed once per scene, without photons or samples. Each is a
/// row of a table. A new row has its pass in measurement_pass.h and in cuda/measure.cu.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

namespace tyndall::measurement {

enum Id : std::uint32_t { scattering, depth };

struct Row {
  const char* name;     ///< of its progress, and of its chunk in part files
  std::size_t element;  ///< [byte] size of an element
  bool has_each_pixel;  ///< whether an element is a pixel of the crop, else a cell of the grid

  std::uint64_t count(std::uint64_t cells, std::uint64_t pixels) const {
    return has_each_pixel ? pixels : cells;
  }
};

/// The scattering coefficient (see MatterPass::matter) and the depth (see DepthPass::depth).
inline constexpr std::array rows{Row{"matter", sizeof(std::int64_t), false},
                                 Row{"depth", sizeof(float), true}};

inline constexpr std::array ids{scattering, depth};

/// One value for each row.
template <class T>
using Each = std::array<T, rows.size()>;

/// \return the `count` elements of a measurement in the words of Backend::take().
template <class T>
std::vector<T> elements(const std::vector<std::int64_t>& words, std::uint64_t count) {
  std::vector<T> out(count);
  std::memcpy(out.data(), words.data(), count * sizeof(T));
  return out;
}

}  // namespace tyndall::measurement
