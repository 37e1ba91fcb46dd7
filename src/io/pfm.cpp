#include "io/pfm.h"

#include <bit>
#include <cstddef>

#include <fmt/format.h>

namespace tyndall::io {

std::string encode_pfm(const Picture& picture) {
  static_assert(std::endian::native == std::endian::little, "the scale -1 means little endian");
  std::string bytes = fmt::format("PF\n{} {}\n-1\n", picture.width, picture.height);
  const auto width = static_cast<std::size_t>(picture.width);
  bytes.reserve(bytes.size() + picture.rgba.size() / 4 * 3 * sizeof(float));
  for (auto row = static_cast<std::size_t>(picture.height); row-- > 0;)  // bottom row first
    for (std::size_t x = 0; x < width; ++x)
      bytes.append(reinterpret_cast<const char*>(&picture.rgba[4 * (row * width + x)]),
                   3 * sizeof(float));
  return bytes;
}

}  // namespace tyndall::io
