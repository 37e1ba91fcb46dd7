/// \file
/// What is measured once of a scene, without random photons or samples: one row of a table each. A
/// new row has its pass in measurement_pass.h and in cuda/measure.cu.
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
  bool has_each_pixel;  ///< an element: true: a pixel of the crop; false: a cell of the grid

  std::uint64_t count(std::uint64_t cells, std::uint64_t pixels) const {
    return has_each_pixel ? pixels : cells;
  }
};

/// The scattering coefficient, see MatterPass::matter; see DepthPass::depth.
inline constexpr std::array rows{Row{"matter", sizeof(std::int64_t), false},
                                 Row{"depth", sizeof(float), true}};

inline constexpr std::array ids{scattering, depth};

/// A value for each row.
template <class T>
using Each = std::array<T, rows.size()>;

/// \return `count` elements of a measurement, which Backend::take() gives as words.
template <class T>
std::vector<T> elements(const std::vector<std::int64_t>& words, std::uint64_t count) {
  std::vector<T> out(count);
  std::memcpy(out.data(), words.data(), count * sizeof(T));
  return out;
}

}  // namespace tyndall::measurement
