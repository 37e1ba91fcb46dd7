#include "io/denoise.h"

#include <algorithm>
#include <memory>
#include <string>

#if TYNDALL_OIDN
#include <OpenImageDenoise/oidn.h>
#endif

#include "tyndall/render/error.h"

namespace tyndall::io {

#if TYNDALL_OIDN

void require_denoiser() {}

void denoise(Picture& picture) {
  if (picture.rgba.empty()) return;
  const auto width = static_cast<std::size_t>(picture.width);
  const auto height = static_cast<std::size_t>(picture.height);
  const std::unique_ptr<OIDNDeviceImpl, decltype(&oidnReleaseDevice)> device(
      oidnNewDevice(OIDN_DEVICE_TYPE_CPU), oidnReleaseDevice);
  const auto require_success = [&] {
    const char* message = nullptr;
    if (oidnGetDeviceError(device.get(), &message) != OIDN_ERROR_NONE)
      throw Error(ExitCode::internal, std::string("Open Image Denoise: ") + message);
  };
  require_success();
  oidnCommitDevice(device.get());
  const std::unique_ptr<OIDNFilterImpl, decltype(&oidnReleaseFilter)> filter(
      oidnNewFilter(device.get(), "RT"), oidnReleaseFilter);
  const auto set_image = [&](const char* name, float* values, std::size_t channels) {
    oidnSetSharedFilterImage(filter.get(), name, values, OIDN_FORMAT_FLOAT3, width, height, 0,
                             channels * sizeof(float), 0);
  };
  std::vector<float> clean(3 * width * height);
  set_image("color", picture.rgba.data(), 4);
  for (PictureLayer& layer : picture.layers)
    if (layer.name == "albedo") set_image("albedo", layer.values.data(), 3);
  set_image("output", clean.data(), 3);
  oidnSetFilterBool(filter.get(), "hdr", true);
  oidnCommitFilter(filter.get());
  oidnExecuteFilter(filter.get());
  require_success();

  PictureLayer noisy{"noisy", "RGB", std::vector<float>(clean.size())};
  for (std::size_t i = 0; i < width * height; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      noisy.values[3 * i + c] = picture.rgba[4 * i + c];
      picture.rgba[4 * i + c] = clean[3 * i + c];
    }
  }
  picture.layers.push_back(std::move(noisy));
  const int version = oidnGetDeviceInt(device.get(), "version");  // 20501: 2.5.1
  picture.provenance.emplace_back("tyndall.denoised", "Open Image Denoise "
                                                          + std::to_string(version / 10000) + "."
                                                          + std::to_string(version / 100 % 100));
}

#else

void require_denoiser() {
  throw Error(
      ExitCode::usage,
      "--denoise: this build has no Open Image Denoise; build it where CMake's find_package "
      "finds OpenImageDenoise, or give the EXR's layers to a denoiser of your own");
}

void denoise(Picture&) { require_denoiser(); }

#endif

}  // namespace tyndall::io
