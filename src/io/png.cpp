#include "io/png.h"

#include <dlfcn.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "io/plugin/oiio_png.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* module_name = "tyndall_oiio.so";

/// Beside the executable (a build), or where an installation puts it, seen from there.
std::vector<fs::path> module_places() {
  const fs::path bin = fs::read_symlink("/proc/self/exe").parent_path();
  std::vector<fs::path> places{bin / module_name};
#ifdef TYNDALL_PLUGIN_DIR
  places.push_back((bin / TYNDALL_PLUGIN_DIR / module_name).lexically_normal());
#endif
  return places;
}

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ExitCode::output_failed,
              fmt::format("PNG files cannot be written: {}; write .exr instead", reason));
}

}  // namespace

PngEncoder::PngEncoder() {
  std::string looked;
  for (const fs::path& place : module_places()) {
    std::error_code error;
    if (!fs::exists(place, error)) {
      looked += (looked.empty() ? "" : ", ") + place.parent_path().string();
      continue;
    }
    void* module = ::dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module == nullptr) fail(::dlerror());
    function_ = ::dlsym(module, "tyndall_encode_png_1");
    if (function_ == nullptr) fail(::dlerror());
    return;
  }
  fail(fmt::format("{} was not found in {}", module_name, looked));
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
