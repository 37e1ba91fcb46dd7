#include "io/denoise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"
#include "tyndall/render/error.h"

namespace tyndall::test {
namespace {

#if TYNDALL_OIDN

/// \return a ramp with uniform relative noise of +-50 %.
Picture noisy_ramp() {
  Picture picture;
  picture.width = 96, picture.height = 64;
  Random random(1);
  PictureLayer albedo{"albedo", "RGB", {}};
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float ramp = 1 + static_cast<float>(x) / 32;
      for (int c = 0; c < 3; ++c)
        picture.rgba.push_back(ramp * (0.5f + static_cast<float>(random())));
      picture.rgba.push_back(static_cast<float>(y) / 64);
      albedo.values.insert(albedo.values.end(), 3, 0.9f);
    }
  }
  picture.layers.push_back(albedo);
  return picture;
}

/// \return the root mean square of the relative deviation from the ramp.
double deviation(const Picture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.rgba.size() / 4; ++i) {
    const double ramp = 1 + static_cast<double>(i % 96) / 32;
    sum += std::pow(double{picture.rgba[4 * i + 1]} / ramp - 1, 2);
  }
  return std::sqrt(sum / static_cast<double>(picture.rgba.size() / 4));
}

TEST(Denoise, keeps_the_noisy_colours_as_a_layer) {
  const Picture noisy = noisy_ramp();
  Picture picture = noisy;
  io::denoise(picture);
  EXPECT_GT(deviation(noisy), 0.28);
  EXPECT_LT(deviation(picture), 0.05);
  ASSERT_EQ(picture.layers.size(), 2u);
  EXPECT_EQ(picture.layers[1].name, "noisy");
  for (std::size_t i = 0; i < noisy.rgba.size() / 4; ++i) {
    ASSERT_EQ(picture.rgba[4 * i + 3], noisy.rgba[4 * i + 3]) << "alpha";
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(picture.layers[1].values[3 * i + c], noisy.rgba[4 * i + c]);
  }
  ASSERT_EQ(picture.provenance.size(), 1u);
  EXPECT_EQ(picture.provenance[0].first, "tyndall.denoised");
}

TEST(Denoise, keeps_a_picture_without_pixels) {
  Picture picture;
  io::denoise(picture);
  EXPECT_TRUE(picture.layers.empty());
}

#else

TEST(Denoise, keeps_the_noisy_colours_as_a_layer) {
  GTEST_SKIP() << "this build has no Open Image Denoise";
}

TEST(Denoise, is_refused_by_builds_without_the_library) {
  try {
    io::require_denoiser();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    EXPECT_NE(std::string(error.what()).find("OpenImageDenoise"), std::string::npos);
  }
}

#endif

}  // namespace
}  // namespace tyndall::test
