#include "io/exr_header.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace tyndall::io {
namespace {

struct Damaged {
  std::string why;
};

/// Reads the bytes of a header in order. \throws Damaged at its end
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::string_view take(std::uint32_t size) {
    if (size > bytes_.size()) throw Damaged{"is longer than the rest of the header"};
    const std::string_view taken = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return taken;
  }
  std::uint32_t number() {
    std::uint32_t n = 0;
    std::memcpy(&n, take(4).data(), 4);
    return n;
  }
  std::string_view text() {  // ends with a zero
    const std::size_t end = bytes_.find('\0');
    if (end == bytes_.npos) throw Damaged{"is not terminated"};
    return take(static_cast<std::uint32_t>(end) + 1).substr(0, end);
  }
  bool empty() const { return bytes_.empty(); }
  bool at_zero() const { return !bytes_.empty() && bytes_[0] == '\0'; }

 private:
  std::string_view bytes_;
};

/// Types of fixed size: OpenEXR reads that size even if the attribute states another.
constexpr std::pair<std::string_view, std::uint32_t> sizes[] = {
    {"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
    {"compression", 1}, {"double", 8},   {"envmap", 1},
    {"float", 4},       {"int", 4},      {"keycode", 28},
    {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
    {"m44f", 64},       {"m44d", 128},   {"rational", 8},
    {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
    {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
    {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1}};

void check_attribute(std::string_view type, std::string_view value) {
  Bytes bytes(value);
  if (type == "chlist") {
    while (!bytes.text().empty()) bytes.take(16);
    if (!bytes.empty()) throw Damaged{"continues after its end"};
  } else if (type == "stringvector") {
    while (!bytes.empty()) bytes.take(bytes.number());
  } else if (type == "preview") {
    const std::uint64_t width = bytes.number(), height = bytes.number();
    if (value.size() < 8 || width * height != (value.size() - 8) / 4)
      throw Damaged{"has another size than its width and height"};
  }
  for (const auto& [name, size] : sizes)
    if (type == name && value.size() != size) throw Damaged{"has another size than its type"};
}

/// Calls `f(part, name, type, value)` for each attribute of the headers of an OpenEXR file; does
/// nothing for other files. \return the problem of the headers; empty if they are sound
template <class F>
std::string for_attributes(const std::string& path, const F& f) {
  constexpr std::size_t most = std::size_t{1} << 24;  // [byte] of all headers
  std::ifstream file(path, std::ios::binary);
  std::vector<char> begin(4);
  if (!file.read(begin.data(), 4) || std::memcmp(begin.data(), "v/1\1", 4) != 0) return "";
  begin.resize(most);
  file.read(begin.data(), static_cast<std::streamsize>(most));
  Bytes bytes({begin.data(), static_cast<std::size_t>(file.gcount())});
  std::string_view name = "";
  try {
    const bool is_multipart = (bytes.number() & 0x1000) != 0;
    std::size_t part = 0;
    do {
      for (name = bytes.text(); !name.empty(); name = bytes.text()) {
        const std::string_view type = bytes.text();
        f(part, name, type, bytes.take(bytes.number()));
      }
      ++part;
    } while (is_multipart && !bytes.at_zero());
    return "";
  } catch (const Damaged& damage) {
    return fmt::format("damaged: its header's attribute '{}' {}", name.substr(0, 64), damage.why);
  }
}

}  // namespace

std::string exr_header_problem(const std::string& path) {
  return for_attributes(path, [](std::size_t, std::string_view, std::string_view type,
                                 std::string_view value) { check_attribute(type, value); });
}

std::map<std::size_t, int> exr_envmaps(const std::string& path) {
  std::map<std::size_t, int> found;
  for_attributes(path, [&](std::size_t part, std::string_view name, std::string_view type,
                           std::string_view value) {
    if (name == "envmap" && type == "envmap" && value.size() == 1)
      found[part] = static_cast<unsigned char>(value[0]);
  });
  return found;
}

}  // namespace tyndall::io
