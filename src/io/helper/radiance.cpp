// Radiance pictures. OpenImageIO drops their exposure and primaries, and rotates the orders +X +Y
// and -X -Y in the wrong direction.
// Reference: G. Ward, "Radiance File Formats", section Picture File.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/helper/decoded_image.h"

namespace tyndall::io {
namespace {

class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  unsigned char next() {
    if (at_ == bytes_.size()) damaged("its end is missing");
    return static_cast<unsigned char>(bytes_[at_++]);
  }
  std::string line() {
    constexpr std::size_t longest = 65536;
    const std::size_t end = bytes_.find('\n', at_);
    if (end == bytes_.npos || end - at_ > longest) damaged("its header does not end");
    std::string text(bytes_.substr(at_, end - at_));
    at_ = end + 1;
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return text;
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

/// \return `count` numbers. \throws Failure
std::vector<double> numbers(const std::string& key, const std::string& text, std::size_t count) {
  std::vector<double> values;
  const char* at = text.c_str();
  for (std::size_t i = 0; i < count; ++i) {
    char* end = nullptr;
    values.push_back(std::strtod(at, &end));
    if (end == at || !std::isfinite(values.back()))
      damaged(fmt::format("its {} is '{}', not {} number{}", key, text.substr(0, 60), count,
                          count == 1 ? "" : "s"));
    at = end;
  }
  return values;
}

void require_positive(const std::string& key, double value) {
  if (!(value > 0)) damaged(fmt::format("its {} is {:g}, not above 0", key, value));
}

/// The scan order of the pixels, and its orientation in TIFF.
struct Order {
  std::string_view major, minor;
  int orientation;
};
constexpr Order orders[] = {{"-Y", "+X", 1}, {"-Y", "-X", 2}, {"+Y", "-X", 3}, {"+Y", "+X", 4},
                            {"+X", "-Y", 5}, {"-X", "-Y", 6}, {"-X", "+Y", 7}, {"+X", "+Y", 8}};

/// Reads a line such as "-Y 512 +X 1024".
void read_resolution(const std::string& line, DecodedImage& image) {
  char major[3] = "", minor[3] = "";
  long long rows = 0, columns = 0;
  if (std::sscanf(line.c_str(), "%2s %lld %2s %lld", major, &rows, minor, &columns) == 4) {
    for (const Order& order : orders) {
      if (order.major != major || order.minor != minor) continue;
      image.orientation = order.orientation;
      image.told["order"] = line;
      return image.resize(columns, rows);
    }
  }
  damaged(fmt::format("'{}' is not the size of a Radiance picture, such as '-Y 512 +X 1024'",
                      line.substr(0, 60)));
}

/// Warns about the projection of a VIEW: Radiance has no projection to longitude and latitude.
/// \param options of all lines VIEW= joined; without -vt the view is a perspective
void warn_about_view(const std::string& options, DecodedImage& image) {
  constexpr std::pair<char, const char*> types[] = {
      {'v', "a perspective"},           {'l', "a parallel projection"},
      {'c', "a cylindrical panorama"},  {'a', "an angular fisheye"},
      {'h', "a hemispherical fisheye"}, {'s', "a planispheric fisheye"}};
  std::string words, type = "-vtv";
  std::istringstream all(options);
  for (std::string word; all >> word;) {
    words += (words.empty() ? "" : " ") + word;
    if (word.starts_with("-vt")) type = word;
  }
  const char* name = "of an unknown type";
  for (const auto& [letter, shown] : types)
    if (type.size() == 4 && type[3] == letter) name = shown;
  image.told["view"] = words.substr(0, 200);
  image.warnings.push_back(
      fmt::format("its VIEW is {} ({}), but it is read as longitude and latitude; convert it "
                  "to these first",
                  name, type.substr(0, 20)));
}

/// Reads a row in the new format: run-length encoding of each component separately.
void read_new_row(Bytes& bytes, std::vector<unsigned char>& row, std::size_t width) {
  for (std::size_t part = 0; part < 4; ++part) {
    for (std::size_t x = 0; x < width;) {
      const unsigned code = bytes.next();
      const bool is_run = code > 128;
      const std::size_t count = is_run ? code - 128 : code;
      if (count == 0 || count > width - x) damaged("a row is longer than the picture is wide");
      unsigned char value = is_run ? bytes.next() : 0;
      for (std::size_t i = 0; i < count; ++i, ++x) {
        if (!is_run) value = bytes.next();
        row[4 * x + part] = value;
      }
    }
  }
}

/// Reads a row in the old format: whole pixels in order; (1, 1, 1, n) repeats the last one n times.
void read_old_row(Bytes& bytes, std::vector<unsigned char>& row, std::size_t width,
                  const unsigned char (&first)[4]) {
  unsigned shift = 0;
  for (std::size_t x = 0; x < width;) {
    unsigned char pixel[4];
    for (int i = 0; i < 4; ++i) pixel[i] = x == 0 && shift == 0 ? first[i] : bytes.next();
    if (x > 0 && pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
      const std::size_t count = std::size_t{pixel[3]} << shift;
      if (shift > 16 || count > width - x) damaged("a row is longer than the picture is wide");
      for (std::size_t i = 0; i < 4 * count; ++i) row[4 * x + i] = row[4 * x + i - 4];
      x += count;
      shift += 8;
    } else {
      for (std::size_t i = 0; i < 4; ++i) row[4 * x + i] = pixel[i];
      ++x;
      shift = 0;
    }
  }
}

void read_rows(Bytes& bytes, DecodedImage& image) {
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<unsigned char> row(4 * width);
  float* out = image.rgb.data();
  for (int y = 0; y < image.height; ++y) {
    unsigned char first[4];
    for (unsigned char& byte : first) byte = bytes.next();
    const bool is_new =
        width >= 8 && width < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (is_new && (std::size_t{first[2]} << 8 | first[3]) != width)
      damaged("a row has another width than the picture");
    if (is_new)
      read_new_row(bytes, row, width);
    else
      read_old_row(bytes, row, width, first);
    for (std::size_t x = 0; x < width; ++x) {
      const unsigned char* p = &row[4 * x];
      const float unit = p[3] == 0 ? 0.0f : static_cast<float>(std::ldexp(1.0, p[3] - (128 + 8)));
      for (int c = 0; c < 3; ++c) *out++ = static_cast<float>(p[c]) * unit;
    }
  }
}

}  // namespace

DecodedImage decode_radiance() {
  std::string file(input_size(), '\0');
  read_at(0, file.data(), file.size());
  Bytes bytes(file);
  DecodedImage image;
  double exposure = 1, aspect = 1;
  bool is_exposed = false, has_view = false;
  std::string view;
  bytes.line();  // "#?RADIANCE"
  // Indented lines are the headers of source pictures; they are ignored.
  for (std::string line = bytes.line(); !line.empty(); line = bytes.line()) {
    const std::size_t equals = line.find('=');
    if (equals == line.npos || line[0] == ' ' || line[0] == '\t') continue;
    const std::string key = line.substr(0, equals), value = line.substr(equals + 1);
    if (key == "FORMAT") {
      image.told["pixels"] = value;
      if (value.find("32-bit_rle_xyze") != value.npos)
        image.primaries = Primaries{{1, 0, 0, 1, 0, 0, 1.0 / 3, 1.0 / 3}};  // X, Y and Z themselves
      else if (value.find("32-bit_rle_rgbe") == value.npos)
        throw Failure{error_format, fmt::format("a Radiance picture of FORMAT={}, neither "
                                                "32-bit_rle_rgbe nor 32-bit_rle_xyze",
                                                value.substr(0, 60))};
    } else if (key == "EXPOSURE") {  // several lines multiply
      const double factor = numbers(key, value, 1)[0];
      require_positive(key, factor);
      exposure *= factor;
      is_exposed = true;
    } else if (key == "COLORCORR") {
      const std::vector<double> factors = numbers(key, value, 3);
      for (std::size_t c = 0; c < 3; ++c) {
        require_positive(key, factors[c]);
        image.divisor[c] *= factors[c];
      }
      image.told["color correction"] = image.divisor;
    } else if (key == "PRIMARIES") {
      const std::vector<double> xy = numbers(key, value, 8);
      Primaries primaries;
      std::copy(xy.begin(), xy.end(), primaries.xy.begin());
      if (!image.primaries) image.primaries = primaries;
    } else if (key == "PIXASPECT") {  // several lines multiply
      const double factor = numbers(key, value, 1)[0];
      require_positive(key, factor);
      aspect *= factor;
    } else if (key == "VIEW") {  // a later line overrides only the options that it names
      view += value + ' ';
      has_view = true;
    } else if (key == "GAMMA" && numbers(key, value, 1)[0] != 1) {
      image.warnings.push_back(
          fmt::format("its GAMMA of {} is not applied: Radiance's pictures "
                      "are linear",
                      value.substr(0, 20)));
    }
  }
  if (has_view) warn_about_view(view, image);
  if (aspect != 1) {
    image.told["pixel aspect ratio"] = aspect;
    image.warnings.push_back(
        fmt::format("its PIXASPECT of {:g} is not applied: {}", aspect, whole_sphere));
  }
  if (is_exposed) image.told["exposure"] = exposure;
  require_positive("EXPOSURE, all together,", exposure);
  for (double& d : image.divisor) {
    d *= exposure;
    if (!std::isfinite(d)) damaged("its EXPOSURE is no number");
  }
  read_resolution(bytes.line(), image);
  read_rows(bytes, image);
  return image;
}

}  // namespace tyndall::io
