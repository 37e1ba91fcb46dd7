#include "io/png.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "io/module.h"
#include "io/plugin/oiio.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ExitCode::output_failed,
              fmt::format("PNG files cannot be written: {}; write .exr instead", reason));
}

}  // namespace

PngEncoder::PngEncoder() {
  std::string problem;
  function_ = module_function("tyndall_oiio.so", "tyndall_encode_png_1", problem);
  if (function_ == nullptr) fail(problem);
}

std::string PngEncoder::encode(const Picture& picture, double exposure) const {
  const double gain = std::exp2(exposure);
  std::vector<unsigned char> rgb;
  rgb.reserve(picture.rgba.size() / 4 * 3);
  for (std::size_t pixel = 0; pixel < picture.rgba.size(); pixel += 4)
    for (std::size_t c = 0; c < 3; ++c)
      rgb.push_back(srgb_byte(gain * static_cast<double>(picture.rgba[pixel + c])));

  const TyndallSink append = [](void* user, const void* bytes, std::size_t size) {
    static_cast<std::string*>(user)->append(static_cast<const char*>(bytes), size);
  };
  std::string file;
  std::array<char, 256> message{};
  const auto encode_png = reinterpret_cast<TyndallEncodePng*>(function_);
  if (encode_png(picture.width, picture.height, rgb.data(), append, &file, message.data(),
                 message.size())
      != 0)
    fail(message.data());
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
