#include "support/images.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

namespace tyndall::test {
namespace {

template <class T>
std::string raw(const T& value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

std::string text(const std::string& characters) { return characters + '\0'; }

std::string window(const std::array<int, 4>& box) { return raw(box); }

std::string header_of(const ExrPart& part, bool has_parts) {
  std::string channels;
  for (const ExrChannel& c : part.channels)
    channels += text(c.name) + raw(std::int32_t{2}) + raw(std::int32_t{0})
                + raw(std::int32_t{c.sampling}) + raw(std::int32_t{c.sampling});
  std::string header = exr_attribute("channels", "chlist", channels + '\0')
                       + exr_attribute("compression", "compression", std::string(1, '\0'))
                       + exr_attribute("dataWindow", "box2i", window(part.data))
                       + exr_attribute("displayWindow", "box2i", window(part.display))
                       + exr_attribute("lineOrder", "lineOrder", std::string(1, '\0'))
                       + exr_attribute("pixelAspectRatio", "float", raw(part.pixel_aspect))
                       + exr_attribute("screenWindowCenter", "v2f", raw(0.0f) + raw(0.0f))
                       + exr_attribute("screenWindowWidth", "float", raw(1.0f));
  if (has_parts)
    header +=
        exr_attribute("name", "string", part.name)
        + exr_attribute("type", "string", "scanlineimage")
        + exr_attribute("chunkCount", "int", raw(std::int32_t{part.data[3] - part.data[1] + 1}));
  return header + part.attributes + '\0';
}

std::string row_of(const ExrPart& part, int y) {
  std::string row;
  for (const ExrChannel& c : part.channels) {
    if (y % c.sampling != 0) continue;
    for (int x = part.data[0]; x <= part.data[2]; ++x)
      if (x % c.sampling == 0) row += raw(c.value(x, y));
  }
  return row;
}

std::string entry(int tag, int type, std::uint32_t count, std::uint32_t value) {
  return raw(static_cast<std::uint16_t>(tag)) + raw(static_cast<std::uint16_t>(type)) + raw(count)
         + raw(value);
}

}  // namespace

std::vector<ExrChannel> exr_rgb(const std::string& layer, float red, float green, float blue) {
  std::vector<ExrChannel> channels;
  for (const auto& [name, value] : {std::pair("B", blue), {"G", green}, {"R", red}})
    channels.push_back(
        {(layer.empty() ? "" : layer + ".") + name, [v = value](int, int) { return v; }});
  return channels;
}

std::string exr_attribute(const std::string& name, const std::string& type,
                          const std::string& value) {
  return text(name) + text(type) + raw(static_cast<std::int32_t>(value.size())) + value;
}

std::string bytes_of(const std::vector<float>& values) {
  std::string bytes;
  for (const float v : values) bytes += raw(v);
  return bytes;
}

std::string exr_file(const std::vector<ExrPart>& given) {
  std::vector<ExrPart> parts = given;
  for (ExrPart& part : parts)
    std::sort(part.channels.begin(), part.channels.end(),
              [](const ExrChannel& a, const ExrChannel& b) { return a.name < b.name; });
  const bool has_parts = parts.size() > 1;
  std::string file("\x76\x2f\x31\x01", 4);
  file += raw(std::uint32_t{has_parts ? 0x1002u : 2u});
  for (const ExrPart& part : parts) file += header_of(part, has_parts);
  if (has_parts) file += '\0';
  std::size_t rows = 0;
  for (const ExrPart& part : parts)
    rows += static_cast<std::size_t>(part.data[3] - part.data[1]) + 1;
  std::uint64_t at = file.size() + 8 * rows;
  std::string offsets, chunks;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (int y = parts[p].data[1]; y <= parts[p].data[3]; ++y) {
      const std::string row = row_of(parts[p], y);
      std::string chunk = has_parts ? raw(static_cast<std::int32_t>(p)) : "";
      chunk += raw(std::int32_t{y}) + raw(static_cast<std::int32_t>(row.size())) + row;
      offsets += raw(at);
      at += chunk.size();
      chunks += chunk;
    }
  }
  return file + offsets + chunks;
}

std::string radiance_file(const std::string& lines, const std::string& resolution,
                          const std::string& pixels) {
  return "#?RADIANCE\n" + lines + "\n" + resolution + "\n" + pixels;
}

std::string tiff_file(int width, int height, const std::vector<float>& rgb, int orientation) {
  const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
  constexpr std::uint32_t directory = 8, entries = 11;
  constexpr std::uint32_t bits = directory + 2 + 12 * entries + 4, formats = bits + 6;
  constexpr std::uint32_t pixels = formats + 6;
  std::string file = "II*" + std::string(1, '\0') + raw(directory);
  file += raw(static_cast<std::uint16_t>(entries));
  file += entry(256, 4, 1, w) + entry(257, 4, 1, h) + entry(258, 3, 3, bits) + entry(259, 3, 1, 1)
          + entry(262, 3, 1, 2) + entry(273, 4, 1, pixels)
          + entry(274, 3, 1, static_cast<std::uint32_t>(orientation)) + entry(277, 3, 1, 3)
          + entry(278, 4, 1, h) + entry(279, 4, 1, 12 * w * h) + entry(339, 3, 3, formats);
  file += raw(std::uint32_t{0});
  for (int i = 0; i < 3; ++i) file += raw(std::uint16_t{32});
  for (int i = 0; i < 3; ++i) file += raw(std::uint16_t{3});
  return file + bytes_of(rgb);
}

std::string jpeg_file(int orientation) {
  constexpr std::string_view digits =
      "ffd8ffdb0043001b12141714111b1716171e1c1b2028422b28252528513a3d3042605565645f555d5b6a7899"
      "816a7190735b5d85b586909ea3abadab6780bcc9baa6c799a8aba4ffc0000b080008001001011100ffc4001f"
      "0000010501010101010100000000000000000102030405060708090a0bffc400b51000020103030204030505"
      "04040000017d01020300041105122131410613516107227114328191a1082342b1c11552d1f0243362728209"
      "0a161718191a25262728292a3435363738393a434445464748494a535455565758595a636465666768696a73"
      "7475767778797a838485868788898a92939495969798999aa2a3a4a5a6a7a8a9aab2b3b4b5b6b7b8b9bac2c3"
      "c4c5c6c7c8c9cad2d3d4d5d6d7d8d9dae1e2e3e4e5e6e7e8e9eaf1f2f3f4f5f6f7f8f9faffda000801010000"
      "3f003fe12eff00a71ffc8bff00d8d7335fffd9";
  std::string file;
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
    file += static_cast<char>(16 * value(digits[i]) + value(digits[i + 1]));
  }
  const std::string tiff = std::string("II*\0\x08\0\0\0\1\0", 10)
                           + entry(274, 3, 1, static_cast<std::uint32_t>(orientation))
                           + std::string(4, '\0');
  const std::string exif = std::string("Exif\0\0", 6) + tiff;
  const auto size = exif.size() + 2;
  const std::string marker{'\xff', '\xe1', static_cast<char>(size >> 8),
                           static_cast<char>(size & 255)};
  return file.substr(0, 2) + marker + exif + file.substr(2);
}

std::string pfm_file(int width, int height, const std::vector<float>& rgb) {
  std::string file = fmt::format("PF\n{} {}\n-1\n", width, height);
  const auto row = static_cast<std::size_t>(3 * width);
  for (auto y = static_cast<std::size_t>(height); y-- > 0;)
    file += bytes_of({rgb.begin() + static_cast<std::ptrdiff_t>(y * row),
                      rgb.begin() + static_cast<std::ptrdiff_t>((y + 1) * row)});
  return file;
}

}  // namespace tyndall::test
