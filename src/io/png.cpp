// Reference: ISO/IEC 15948, Portable Network Graphics.
#include "io/png.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "io/pack.h"

namespace tyndall::io {
namespace {

std::string big_endian(std::uint32_t n) {
  std::string bytes;
  for (const unsigned shift : {24u, 16u, 8u, 0u}) bytes += static_cast<char>(n >> shift & 255u);
  return bytes;
}

void add_chunk(std::string& file, std::string_view type, std::string_view data) {
  const std::string body = std::string(type) + std::string(data);
  file += big_endian(static_cast<std::uint32_t>(data.size())) + body + big_endian(crc(body));
}

/// \return a byte as PNG's filters 0, 1, 2 and 4 predict it: zero, the byte to the left, the one
/// above, or the nearest of all three to left + above - corner (Paeth).
int predicted(int filter, int left, int above, int corner) {
  if (filter != 4) return filter == 0 ? 0 : filter == 1 ? left : above;
  const int p = left + above - corner;
  const int a = std::abs(p - left), b = std::abs(p - above), c = std::abs(p - corner);
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

/// \return the filter with the smallest sum of absolute residuals, followed by the residuals.
std::string filtered(const std::string& row, const std::string& above) {
  std::string best;
  long least = 0;
  for (const int filter : {0, 1, 2, 4}) {
    std::string line(1, static_cast<char>(filter));
    long sum = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const auto at = [i](const std::string& bytes, std::size_t back) {
        return i < back ? 0 : int{static_cast<unsigned char>(bytes[i - back])};
      };
      const int rest = at(row, 0) - predicted(filter, at(row, 3), at(above, 0), at(above, 3));
      line += static_cast<char>(rest & 255);
      sum += std::abs(static_cast<signed char>(rest & 255));
    }
    if (best.empty() || sum < least) least = sum, best = std::move(line);
  }
  return best;
}

}  // namespace

std::string encode_png(const Picture& picture, double exposure) {
  const double gain = std::exp2(exposure);
  const std::size_t width = static_cast<std::size_t>(picture.width);
  std::string data, row(3 * width, '\0'), above = row;
  for (std::size_t pixel = 0; pixel < picture.rgba.size() / 4; pixel += width) {
    for (std::size_t i = 0; i < 3 * width; ++i)
      row[i] = static_cast<char>(
          srgb_byte(gain * static_cast<double>(picture.rgba[4 * (pixel + i / 3) + i % 3])));
    data += filtered(row, above);
    above = row;
  }

  std::string file("\x89PNG\r\n\x1a\n", 8);
  const std::string size = big_endian(static_cast<std::uint32_t>(picture.width))
                           + big_endian(static_cast<std::uint32_t>(picture.height));
  add_chunk(file, "IHDR", size + std::string("\x08\x02\0\0\0", 5));  // 8-bit RGB
  add_chunk(file, "sRGB", std::string_view("\0", 1));                // perceptual intent
  const std::string packed = pack(data, Packing::zlib);
  constexpr std::size_t most = std::size_t{1} << 30;  // chunks are limited to 2^31 - 1 bytes
  for (std::size_t at = 0; at < packed.size(); at += most)
    add_chunk(file, "IDAT", std::string_view(packed).substr(at, most));
  add_chunk(file, "IEND", "");
  return file;
}

unsigned char srgb_byte(double value) {
  if (!(value > 0.0)) return 0;  // NaN too
  if (value >= 1.0) return 255;
  const double curved =
      value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
  return static_cast<unsigned char>(255.0 * curved + 0.5);
}

}  // namespace tyndall::io
