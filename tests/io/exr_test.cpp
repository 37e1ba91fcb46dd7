#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "io/pfm.h"
#include "tyndall/render/error.h"
#if TYNDALL_OPENEXR
#include "io/exr.h"
#endif
#if TYNDALL_ZLIB
#include "io/png.h"
#endif

namespace tyndall::io {
namespace {

Picture gradient(int width, int height) {
  Picture picture;
  picture.width = width;
  picture.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (float value :
           {0.1f * static_cast<float>(x), 1e-20f * static_cast<float>(y), 1e30f, 0.5f})
        picture.rgba.push_back(value);
  picture.provenance = {{"tyndall.ledger.count.shot", "8000000"}, {"tyndall.scene_hash", "0123"}};
  return picture;
}

TEST(Pfm, StartsAtTheBottomRow) {
  const std::string bytes = encode_pfm(gradient(3, 2));
  const std::string header = "PF\n3 2\n-1\n";
  ASSERT_EQ(bytes.size(), header.size() + 3 * 2 * 3 * sizeof(float));
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  float first[3];
  bytes.copy(reinterpret_cast<char*>(first), sizeof first, header.size());
  EXPECT_EQ(first[0], 0.0f);
  EXPECT_EQ(first[1], 1e-20f);
  EXPECT_EQ(first[2], 1e30f);
}

#if TYNDALL_ZLIB
TEST(Png, FollowsTheSrgbCurve) {
  EXPECT_EQ(srgb_byte(0.0), 0);
  EXPECT_EQ(srgb_byte(0.002), 7);  // the linear segment: 12.92 * 0.002 * 255 = 6.6
  EXPECT_EQ(srgb_byte(0.18), 118);
  EXPECT_EQ(srgb_byte(0.5), 188);
  EXPECT_EQ(srgb_byte(1.0), 255);
  EXPECT_EQ(srgb_byte(-1.0), 0);
  EXPECT_EQ(srgb_byte(std::numeric_limits<double>::infinity()), 255);
  EXPECT_EQ(srgb_byte(std::nan("")), 0);
}
#endif

#if TYNDALL_OPENEXR

class ExrTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::temp_directory_path()
            / (std::string("tyndall-")
               + testing::UnitTest::GetInstance()->current_test_info()->name() + ".exr");
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }

  std::string path_;
};

TEST_F(ExrTest, ComesBackBitForBit) {
  Picture picture = gradient(37, 21);
  picture.layers = {{"depth", "Z", {}}, {"variance", "RGB", {}}};
  for (int i = 0; i < 37 * 21; ++i) picture.layers[0].values.push_back(static_cast<float>(i));
  for (int i = 0; i < 3 * 37 * 21; ++i) picture.layers[1].values.push_back(-static_cast<float>(i));
  put(encode_exr(picture));
  const Picture read = read_exr(path_);
  ASSERT_EQ(read.layers.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.layers[i].name, picture.layers[i].name);
    EXPECT_EQ(read.layers[i].channels, picture.layers[i].channels);
    EXPECT_TRUE(read.layers[i].values == picture.layers[i].values);
  }
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 21);
  EXPECT_TRUE(read.rgba == picture.rgba);
  EXPECT_EQ(read.provenance, picture.provenance);
}

TEST_F(ExrTest, StoresThePositionOfACrop) {
  Picture picture = gradient(37, 21);
  picture.left = 100, picture.top = 200;
  picture.whole_width = 640, picture.whole_height = 480;
  put(encode_exr(picture));
  const Picture read = read_exr(path_);
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 21);
  EXPECT_EQ(read.left, 100);
  EXPECT_EQ(read.top, 200);
  EXPECT_EQ(read.whole_width, 640);
  EXPECT_EQ(read.whole_height, 480);
  EXPECT_TRUE(read.rgba == picture.rgba);
}

TEST_F(ExrTest, IsDeterministicAndReadableByOldReaders) {
  const Picture picture = gradient(64, 64);
  const std::string bytes = encode_exr(picture);
  EXPECT_TRUE(bytes == encode_exr(picture));
  EXPECT_LT(bytes.size(), picture.rgba.size() * sizeof(float));  // compressed
  EXPECT_NE(bytes.find("chromaticities"), std::string::npos);
  ASSERT_GT(bytes.size(), 8u);
  EXPECT_EQ(bytes.substr(4, 4), std::string("\2\0\0\0", 4));  // version 2, no long names, no parts
}

TEST_F(ExrTest, RefusesDamagedFiles) {
  const auto code_of = [&] {
    try {
      read_exr(path_);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(path_), std::string::npos) << error.what();
      return error.code();
    }
    return ExitCode::done;
  };
  EXPECT_EQ(code_of(), ExitCode::input_missing);
  put("not a picture");
  EXPECT_EQ(code_of(), ExitCode::input_missing);
  const std::string bytes = encode_exr(gradient(64, 64));
  put(bytes.substr(0, bytes.size() / 2));
  EXPECT_EQ(code_of(), ExitCode::input_missing);
}

#endif

}  // namespace
}  // namespace tyndall::io
