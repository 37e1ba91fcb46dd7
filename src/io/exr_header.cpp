#include "io/exr_header.h"

#include <array>
#include <cstdint>
#include <fstream>

#include <fmt/format.h>

namespace tyndall::io {
namespace {

/// \return a little-endian number of 32 bits, -1 at the end of the file.
std::int64_t number(std::istream& file) {
  std::array<unsigned char, 4> b{};
  if (!file.read(reinterpret_cast<char*>(b.data()), 4)) return -1;
  return b[0] | b[1] << 8 | b[2] << 16 | std::int64_t{b[3]} << 24;
}

/// \return a text that ends with a zero; longer ones than there may be are cut.
std::string text(std::istream& file) {
  std::string text;
  for (int c = file.get(); c > 0 && text.size() < 256; c = file.get()) text += static_cast<char>(c);
  return text;
}

}  // namespace

std::string exr_header_problem(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(0, std::ios::end);
  const std::int64_t size = file.tellg();
  file.seekg(0);
  if (number(file) != 20000630) return "";
  const bool is_multipart = (number(file) >> 8 & 0x10) != 0;
  for (;;) {
    std::string name = text(file);
    for (; !name.empty(); name = text(file)) {
      text(file);  // its type
      const std::int64_t bytes = number(file), left = size - file.tellg();
      if (!file || bytes > left)
        return fmt::format("damaged: its header's attribute '{}' is longer than the file", name);
      file.seekg(bytes, std::ios::cur);
    }
    if (!file) return "damaged: it was cut in its header";
    if (!is_multipart) return "";
    if (file.peek() == 0) return "";  // no more headers
  }
}

}  // namespace tyndall::io
