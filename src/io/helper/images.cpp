#include "io/helper/images.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "io/helper/decoded_image.h"
#include "io/helper/grid_memory.h"
#include "io/module.h"
#include "io/plugin/oiio.h"
#include "tyndall/base/math.h"
#include "tyndall/render/image.h"

namespace tyndall::io {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

// ---- Formats

/// Decodes other formats than OpenEXR and Radiance with OpenImageIO.
DecodedImage decode_other() {
  DecodedImage image;
#if TYNDALL_OPENIMAGEIO
  std::string problem;
  const auto read = reinterpret_cast<TyndallReadImage*>(
      module_function("tyndall_oiio.so", "tyndall_read_image_2", problem));
  if (read == nullptr) throw Failure{error_memory, "the library that reads it: " + problem};
  struct Call {
    DecodedImage& image;
    Failure failure{nullptr, ""};
  } call{image};
  const auto room = [](void* user, const TyndallImage* t) -> float* {
    Call& c = *static_cast<Call*>(user);
    DecodedImage& i = c.image;
    i.left = t->left, i.top = t->top;
    i.whole_width = t->whole_width, i.whole_height = t->whole_height;
    i.orientation = t->orientation;
    i.curve = t->curve;
    try {
      i.resize(t->width, t->height);
    } catch (const Failure& failure) {  // no exception may cross the C interface
      c.failure = failure;
      return nullptr;
    } catch (const std::bad_alloc&) {
      c.failure = {error_memory, too_much_memory};
      return nullptr;
    }
    return i.rgb.data();
  };
  const auto report = [](void* user, const char* key, const char* text) {
    DecodedImage& i = static_cast<Call*>(user)->image;
    if (key == nullptr)
      i.warnings.emplace_back(text);
    else
      i.told[key] = text;
  };
  std::array<char, 512> message{};
  const int failed = read(input_path, room, report, &call, message.data(), message.size());
  if (call.failure.kind != nullptr) throw call.failure;
  if (failed != 0) damaged(message[0] != '\0' ? message.data() : "cannot be read");
#else
  throw Failure{error_format,
                "this build reads only .exr and .hdr: it was made without OpenImageIO"};
#endif
  return image;
}

DecodedImage decode() {
  std::string head(std::min<std::uint64_t>(input_size(), 10), '\0');
  read_at(0, head.data(), head.size());
  if (head.empty()) throw Failure{error_format, "an empty file"};
  DecodedImage image;
  if (head.starts_with("\x76\x2f\x31\x01")) {
#if TYNDALL_OPENEXR
    image = decode_exr();
    image.told["format"] = "exr";
#else
    throw Failure{error_format, "this build reads no .exr: it was made without OpenEXR"};
#endif
  } else if (head.starts_with("#?")) {
    image = decode_radiance();
    image.told["format"] = "hdr";
  } else {
    image = decode_other();
  }
  return image;
}

// ---- The upright picture

/// The position of a pixel of the upright picture in the stored one.
struct Stored {
  int x, y;
};
Stored stored(int orientation, int x, int y, int width, int height) {
  switch (orientation) {
    case 2:
      return {width - 1 - x, y};
    case 3:
      return {width - 1 - x, height - 1 - y};
    case 4:
      return {x, height - 1 - y};
    case 5:
      return {y, x};
    case 6:
      return {y, height - 1 - x};
    case 7:
      return {width - 1 - y, height - 1 - x};
    case 8:
      return {width - 1 - y, x};
    default:
      return {x, y};
  }
}

/// Expands the stored pixels to the whole picture, black around them, and turns it upright.
void lay_out(DecodedImage& image) {
  const int whole_width = image.whole_width > 0 ? image.whole_width : image.width;
  const int whole_height = image.whole_height > 0 ? image.whole_height : image.height;
  const bool is_cut = image.left != 0 || image.top != 0 || image.width != whole_width
                      || image.height != whole_height;
  if (image.orientation < 1 || image.orientation > 8)
    damaged(fmt::format("its orientation is {}, not 1 to 8", image.orientation));
  if (is_cut || image.orientation != 1) {
    const bool turns = image.orientation > 4;
    const int width = turns ? whole_height : whole_width;
    const int height = turns ? whole_width : whole_height;
    std::vector<float> rgb(std::size_t{3} * static_cast<std::size_t>(width)
                           * static_cast<std::size_t>(height));
    float* out = rgb.data();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x, out += 3) {
        const Stored at = stored(image.orientation, x, y, whole_width, whole_height);
        const long long column = static_cast<long long>(at.x) - image.left,
                        row = static_cast<long long>(at.y) - image.top;
        if (column < 0 || column >= image.width || row < 0 || row >= image.height) continue;
        const auto from = static_cast<std::size_t>(3 * (row * image.width + column));
        for (std::size_t c = 0; c < 3; ++c) out[c] = image.rgb[from + c];
      }
    }
    image.rgb = std::move(rgb);
    image.width = width;
    image.height = height;
  }
  if (is_cut) image.told["stored pixels"] = "a part of the whole: black around it";
  if (image.orientation != 1) image.told["orientation"] = image.orientation;
}

/// Counts the pixels with one kind of fault.
class Faults {
 public:
  explicit Faults(const DecodedImage& image) : image_(image) {}

  void add(std::size_t pixel) {
    if (count_ == 0) first_ = pixel;
    if (count_ == 0 || last_ != pixel) ++count_;
    last_ = pixel;
  }
  /// \param what "are infinite: taken as 65504"
  void warn(std::vector<std::string>& warnings, const std::string& what) const {
    if (count_ == 0) return;
    const auto width = static_cast<std::size_t>(image_.width);
    warnings.push_back(
        fmt::format("{} of its {} pixels {} (the first: column {}, row {} from the "
                    "top left)",
                    count_, image_.rgb.size() / 3, what, first_ % width, first_ / width));
  }

 private:
  const DecodedImage& image_;
  std::size_t count_ = 0, first_ = 0, last_ = 0;
};

/// Replaces NaN by 0, and infinity by the largest 16-bit float, or by the largest number of the
/// file if that is larger.
void mend(DecodedImage& image) {
  float largest = largest_half;
  for (const float v : image.rgb)
    if (v > largest && v <= largest_float) largest = v;
  Faults infinite(image), not_numbers(image);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    float& v = image.rgb[i];
    if (v >= -largest_float && v <= largest_float) continue;
    if (v != v) {
      not_numbers.add(i / 3);
      v = 0;
    } else if (v > 0) {
      infinite.add(i / 3);
      v = largest;
    }
  }
  infinite.warn(image.warnings, fmt::format("are infinite: taken as {:.7g}", largest));
  not_numbers.warn(image.warnings, "are no numbers (NaN): taken as 0");
}

/// \return the inverse of the sRGB curve.
float linear(float value) {
  return value <= 0.04045f ? value / 12.92f : power((value + 0.055f) / 1.055f, 2.4f);
}

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) m[i][j] += a[i][k] * b[k][j];
  return m;
}

double determinant(const Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
         - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
         + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

Matrix inverse(const Matrix& m) {
  const double d = determinant(m);
  Matrix r{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, e = (i + 2) % 3;
      r[i][j] = (m[a][c] * m[b][e] - m[a][e] * m[b][c]) / d;
    }
  }
  return r;
}

std::array<double, 3> applied(const Matrix& m, const std::array<double, 3>& v) {
  std::array<double, 3> r{};
  for (std::size_t i = 0; i < 3; ++i) r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return r;
}

constexpr Primaries rec709{{0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290}};

std::array<double, 3> white_of(const Primaries& p) {
  return {p.xy[6] / p.xy[7], 1, (1 - p.xy[6] - p.xy[7]) / p.xy[7]};
}

/// \return CIE 1931 X, Y, Z of red, green and blue as columns; white has Y = 1.
Matrix xyz_of(const Primaries& p) {
  Matrix m{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double x = p.xy[2 * c], y = p.xy[2 * c + 1];
    m[0][c] = x, m[1][c] = y, m[2][c] = 1 - x - y;
  }
  if (!(std::abs(determinant(m)) > 1e-6) || !(p.xy[7] > 1e-6))
    damaged("its primaries span no colors");
  const std::array<double, 3> amounts = applied(inverse(m), white_of(p));
  for (auto& row : m)
    for (std::size_t c = 0; c < 3; ++c) row[c] *= amounts[c];
  return m;
}

/// \return the matrix from linear colours of `from` to linear Rec. 709. White maps to white, by
/// Bradford's adaptation as in OpenEXR's own programs.
Matrix to_rec709(const Primaries& from) {
  constexpr Matrix bradford{
      {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
  const std::array<double, 3> own = applied(bradford, white_of(from)),
                              wanted = applied(bradford, white_of(rec709));
  Matrix adapt{};
  for (std::size_t c = 0; c < 3; ++c) adapt[c][c] = wanted[c] / own[c];
  const Matrix adapted = times(inverse(bradford), times(adapt, times(bradford, xyz_of(from))));
  return times(inverse(xyz_of(rec709)), adapted);
}

/// Converts to linear Rec. 709, and undoes the exposure of the file.
void convert(DecodedImage& image) {
  if (image.curve == 1) {
    for (float& v : image.rgb) v = linear(v);
    image.told["curve"] = "sRGB";
  } else if (image.curve > 0) {
    for (float& v : image.rgb) v = power(max(v, 0.0f), static_cast<float>(image.curve));
    image.told["curve"] = fmt::format("power {:.4g}", image.curve);
  } else {
    image.told["curve"] = "linear";
  }
  if (image.divisor != std::array<double, 3>{1, 1, 1}) {
    for (std::size_t i = 0; i < image.rgb.size(); ++i)
      image.rgb[i] = static_cast<float>(static_cast<double>(image.rgb[i]) / image.divisor[i % 3]);
  }
  if (!image.primaries) return;
  for (const double x : image.primaries->xy)  // rounded: many files store floats
    image.told["primaries"].push_back(std::strtod(fmt::format("{:.6g}", x).c_str(), nullptr));
  bool is_rec709 = true;
  for (std::size_t i = 0; i < 8; ++i)
    is_rec709 = is_rec709 && std::abs(image.primaries->xy[i] - rec709.xy[i]) < 1e-3;
  if (is_rec709) return;
  const Matrix m = to_rec709(*image.primaries);
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const std::array<double, 3> c =
        applied(m, {static_cast<double>(image.rgb[i]), static_cast<double>(image.rgb[i + 1]),
                    static_cast<double>(image.rgb[i + 2])});
    for (std::size_t k = 0; k < 3; ++k) image.rgb[i + k] = static_cast<float>(c[k]);
  }
}

/// Clamps values that are not valid radiances.
void clamp(DecodedImage& image) {
  Faults negative(image), huge(image);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    float& v = image.rgb[i];
    if (v >= 0 && v <= Image::largest_texel) continue;
    (v < 0 ? negative : huge).add(i / 3);
    v = v < 0 ? 0 : Image::largest_texel;
  }
  negative.warn(image.warnings, "are negative: taken as 0");
  huge.warn(image.warnings, fmt::format("are beyond {0:g}: taken as {0:g}", Image::largest_texel));
}

}  // namespace

void DecodedImage::resize(long long columns, long long rows) {
  constexpr long long most = 1 << 28;
  if (columns < 1 || rows < 1 || columns > most || rows > most || columns * rows > most)
    damaged(fmt::format("{} x {} pixels: expected 1 to 2^28", columns, rows));
  // No image format packs more than about a thousand pixels into a byte.
  const auto bytes = static_cast<long long>(input_size());
  if (columns * rows / 2000 > bytes)
    damaged(fmt::format("its header claims {} pixels in {} bytes", columns * rows, bytes));
  width = static_cast<int>(columns);
  height = static_cast<int>(rows);
  rgb.resize(static_cast<std::size_t>(3 * columns * rows));
}

Json read_image() {
  DecodedImage image = decode();
  Json report;
  if (image.problem.empty()) {
    lay_out(image);
    mend(image);
    convert(image);
    clamp(image);
    GridBuffer buffer(image.rgb.size() * sizeof(float));
    std::memcpy(buffer.data(), image.rgb.data(), buffer.size());
    report["image"] = {{"width", image.width},
                       {"height", image.height},
                       {"checksum", checksum(buffer.data(), buffer.size())}};
  }
  report["told"] = image.told;
  report["warnings"] = image.warnings;
  report["problem"] = image.problem;
  return report;
}

}  // namespace tyndall::io
