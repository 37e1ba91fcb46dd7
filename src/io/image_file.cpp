#include "io/image_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/exr_header.h"
#include "io/module.h"
#include "io/plugin/oiio.h"
#include "tyndall/base/math.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

#if TYNDALL_OPENIMAGEIO
constexpr bool has_reader = true;
#else
constexpr bool has_reader = false;
#endif

struct Pixels {
  int width = 0, height = 0;
  std::vector<Vec3f> texels;
};

/// The sRGB curve backwards.
float linear(float value) {
  return value <= 0.04045f ? value / 12.92f : power((value + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

std::shared_ptr<const Image> load_image(const std::string& path) {
  const auto fail = [&](const std::string& reason) {
    throw Error(ExitCode::input_missing, fmt::format("{}: {}", path, reason));
  };
  std::error_code error;
  if (!std::filesystem::exists(path, error)) fail(error ? error.message() : "no such file");
  if (!has_reader) fail("this build reads no images: it was made without OpenImageIO");
  std::string problem = exr_header_problem(path);
  if (!problem.empty()) fail(problem);
  const auto read = reinterpret_cast<TyndallReadImage*>(
      module_function("tyndall_oiio.so", "tyndall_read_image_1", problem));
  if (read == nullptr) fail("images cannot be read: " + problem);

  const auto room = [](void* user, int width, int height) {
    Pixels& pixels = *static_cast<Pixels*>(user);
    pixels.width = width;
    pixels.height = height;
    pixels.texels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    return &pixels.texels.front().x;
  };
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  Pixels pixels;
  int on_curve = 0;
  std::array<char, 512> message{};
  if (read(path.c_str(), room, &pixels, &on_curve, message.data(), message.size()) != 0)
    fail(message.data()[0] != '\0' ? message.data() : "cannot be read");
  if (on_curve != 0) {
    for (Vec3f& texel : pixels.texels) texel = {linear(texel.x), linear(texel.y), linear(texel.z)};
  }
  return std::make_shared<const Image>(pixels.width, pixels.height, std::move(pixels.texels));
}

}  // namespace tyndall::io
