/// \file
/// Metadata and pixels of images. The expected values follow from the specifications of the
/// formats.
#include "io/image_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "io/info.h"
#include "support/images.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using namespace test;

#if TYNDALL_OPENEXR || TYNDALL_OPENIMAGEIO  // the build has the helper

constexpr float infinity = std::numeric_limits<float>::infinity(),
                nan = std::numeric_limits<float>::quiet_NaN();

class ImageFile : public testing::Test {
 protected:
  ImageFile() {
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~ImageFile() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string put(const std::string& bytes, const std::string& name = "sky.exr") const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  LoadedImage load(const std::string& bytes, const std::string& name = "sky.exr") const {
    return load_image(put(bytes, name));
  }
  /// \return the error message after the file's name, "read" if there is none.
  std::string refusal(const std::string& bytes, const std::string& name = "sky.exr") const {
    try {
      load(bytes, name);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::input_missing);
      const std::string message = error.what(), start = path(name) + ": ";
      EXPECT_EQ(message.substr(0, start.size()), start);
      return message.substr(std::min(start.size(), message.size()));
    }
    return "read";
  }

  fs::path folder_;
};

void expect_color(const Vec3f& t, float r, float g, float b, float tolerance = 1e-6f) {
  EXPECT_NEAR(t.x, r, tolerance);
  EXPECT_NEAR(t.y, g, tolerance);
  EXPECT_NEAR(t.z, b, tolerance);
}

// ---- OpenEXR

#if TYNDALL_OPENEXR

ExrPart plain(float red = 1, float green = 2, float blue = 3) {
  ExrPart part;
  part.channels = exr_rgb("", red, green, blue);
  return part;
}

TEST_F(ImageFile, the_data_window_lies_within_the_display_window) {
  ExrPart part = plain();
  part.data = {4, 2, 11, 5};
  part.channels[2].value = [](int x, int y) { return static_cast<float>(100 * y + x); };
  const LoadedImage loaded = load(exr_file({part}));
  const Image& image = *loaded.image;
  ASSERT_EQ(image.width(), 16);
  ASSERT_EQ(image.height(), 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) {
      const Vec3f& t = image.texels()[static_cast<std::size_t>(16 * y + x)];
      if (x >= 4 && x <= 11 && y >= 2 && y <= 5)
        expect_color(t, static_cast<float>(100 * y + x), 2, 3);
      else
        expect_color(t, 0, 0, 0);
    }
  }
  EXPECT_TRUE(loaded.warnings.empty());
}

TEST_F(ImageFile, pixels_outside_the_display_window_are_cut) {
  ExrPart part = plain();
  part.display = {10, 20, 25, 27};
  part.data = {7, 18, 40, 24};
  part.channels[2].value = [](int x, int y) { return static_cast<float>(100 * y + x); };
  const LoadedImage loaded = load(exr_file({part}));
  const std::vector<Vec3f>& t = loaded.image->texels();
  ASSERT_EQ(t.size(), 128u);
  EXPECT_EQ(t[0].x, 2010);
  EXPECT_EQ(t[16 * 4 + 15].x, 2425);
  EXPECT_EQ(t[16 * 5].x, 0);
}

TEST_F(ImageFile, the_layer_with_the_picture_is_chosen) {
  const auto with = [](std::vector<std::vector<ExrChannel>> layers) {
    ExrPart part;
    for (const auto& layer : layers)
      part.channels.insert(part.channels.end(), layer.begin(), layer.end());
    return exr_file({part});
  };
  const auto first = [&](const std::string& bytes) { return load(bytes).image->texels()[0]; };
  expect_color(first(with({exr_rgb("AO", 9, 9, 9), exr_rgb("beauty", 1, 2, 3)})), 1, 2, 3);
  expect_color(first(with({exr_rgb("", 1, 2, 3), exr_rgb("zenith", 9, 9, 9)})), 1, 2, 3);
  expect_color(first(with({exr_rgb("View Layer.Combined", 1, 2, 3),
                           exr_rgb("View Layer.DiffCol", 9, 9, 9)})),
               1, 2, 3);
  // Layers such as depth have no colours.
  expect_color(first(with({exr_rgb("sky", 1, 2, 3),
                           {{"A", [](int, int) { return 9.0f; }}},
                           {{"depth.Z", [](int, int) { return 9.0f; }}}})),
               1, 2, 3);
  const std::string several = refusal(with({exr_rgb("day", 1, 2, 3), exr_rgb("night", 4, 5, 6)}));
  EXPECT_EQ(several.substr(0, 45), "2 of its layers could be the sky: day; night;") << several;
  EXPECT_NE(several.find("--ch day.R,day.G,day.B"), std::string::npos) << several;
  const std::string none = refusal(with({{{"Z", [](int, int) { return 9.0f; }}}}));
  EXPECT_EQ(none, "it has no colours: no channels R, G, B, and no Y; its channels: Z");
}

TEST_F(ImageFile, the_part_with_the_picture_is_chosen) {
  ExrPart depth, rgba = plain(), other = plain(9, 9, 9);
  depth.name = "depth";
  depth.channels = {{"Z", [](int, int) { return 1000.0f; }}};
  rgba.name = "rgba";
  other.name = "AO";
  expect_color(load(exr_file({depth, rgba})).image->texels()[0], 1, 2, 3);
  expect_color(load(exr_file({other, rgba})).image->texels()[0], 1, 2, 3);
  rgba.name = "night";
  const std::string several = refusal(exr_file({depth, other, rgba}));
  EXPECT_EQ(several.substr(0, 67),
            "2 of its layers could be the sky: part 1 'AO'; part 2 'night'; writ")
      << several;
}

TEST_F(ImageFile, grey_is_three_channels_of_one_value) {
  ExrPart part;
  part.channels = {{"Y", [](int, int) { return 0.25f; }}};
  expect_color(load(exr_file({part})).image->texels()[5], 0.25f, 0.25f, 0.25f);
}

TEST_F(ImageFile, luminance_and_chroma_become_colors) {
  // Y is the luminance of Rec. 709, RY = (R - Y) / Y, BY = (B - Y) / Y.
  ExrPart part;
  part.channels = {{"BY", [](int, int) { return -0.8f; }, 2},
                   {"RY", [](int, int) { return 0.6f; }, 2},
                   {"Y", [](int, int) { return 0.5f; }}};
  part.data = part.display = {0, 0, 63, 63};
  const LoadedImage loaded = load(exr_file({part}));
  const float green = (0.5f - 0.2126f * 0.8f - 0.0722f * 0.1f) / 0.7152f;
  expect_color(loaded.image->texels()[64 * 32 + 32], 0.8f, green, 0.1f, 2e-3f);
}

TEST_F(ImageFile, a_map_of_longitude_and_latitude_is_used_and_a_cube_refused) {
  ExrPart part = plain();
  part.attributes = exr_attribute("envmap", "envmap", std::string(1, '\0'));
  EXPECT_TRUE(load(exr_file({part})).warnings.empty());
  part.attributes = exr_attribute("envmap", "envmap", std::string(1, '\1'));
  EXPECT_EQ(refusal(exr_file({part})).substr(0, 41), "a cube map of six faces (envmap): convert");
  part.attributes = exr_attribute("envmap", "envmap", std::string(1, '\7'));
  EXPECT_EQ(refusal(exr_file({part})).substr(0, 53),
            "its envmap is 7, neither 0 (latlong) nor 1 (a cube): ");
  const Json shown = Json::parse(info(put(exr_file({part})), true).text);
  EXPECT_EQ(shown["envmap"], 7);
  EXPECT_EQ(shown["use"].get<std::string>().substr(0, 23), "none: its envmap is 7, ");
}

TEST_F(ImageFile, primaries_become_those_of_rec_709) {
  const auto with = [](const std::vector<float>& xy, float r, float g, float b) {
    ExrPart part = plain(r, g, b);
    part.attributes = exr_attribute("chromaticities", "chromaticities", bytes_of(xy));
    return exr_file({part});
  };
  const std::vector<float> rec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f},
      rec2020{0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},
      aces{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.0770f, 0.32168f, 0.33767f};
  const auto first = [&](const std::string& bytes) { return load(bytes).image->texels()[0]; };
  EXPECT_EQ(first(with(rec709, 0.3f, 0.2f, 0.1f)).x, 0.3f);  // exactly
  // ITU-R BT.2087 has the inverse matrix: 0.6274, 0.3293, 0.0433; 0.0691, 0.9195, 0.0114; 0.0164,
  // 0.0880, 0.8956.
  expect_color(first(with(rec2020, 0.6274f + 0.3293f * 0.5f + 0.0433f * 0.25f,
                          0.0691f + 0.9195f * 0.5f + 0.0114f * 0.25f,
                          0.0164f + 0.0880f * 0.5f + 0.8956f * 0.25f)),
               1, 0.5f, 0.25f, 2e-4f);
  expect_color(first(with(rec2020, 2, 2, 2)), 2, 2, 2, 1e-5f);
  expect_color(first(with(aces, 2, 2, 2)), 2, 2, 2, 1e-5f);  // white stays white
  // Colours outside of Rec. 709 are clamped, with a warning.
  const LoadedImage green = load(with(rec2020, 0, 1, 0));
  ASSERT_EQ(green.warnings.size(), 1u);
  EXPECT_EQ(green.warnings[0],
            "128 of its 128 pixels are negative: taken as 0 (the first: column 0, row 0 from the "
            "top left)");
  EXPECT_EQ(refusal(with(std::vector<float>(8, 0.3f), 1, 1, 1)),
            "damaged: its primaries span no colors");
}

TEST_F(ImageFile, ignored_metadata_is_reported) {
  ExrPart part = plain();
  part.attributes = exr_attribute("whiteLuminance", "float", bytes_of({100}));
  const LoadedImage loaded = load(exr_file({part}));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_EQ(loaded.warnings[0].substr(0, 48), "its whiteLuminance of 100 cd/m2 is not applied: ");
  part.attributes = "";
  part.pixel_aspect = 2;
  const std::string wide = put(exr_file({part}));
  ASSERT_EQ(load_image(wide).warnings.size(), 1u);
  EXPECT_EQ(load_image(wide).warnings[0].substr(0, 41),
            "its pixelAspectRatio of 2 is not applied:");
  EXPECT_EQ(Json::parse(info(wide, true).text)["pixel aspect ratio"], 2);
}

TEST_F(ImageFile, infinite_pixels_are_the_largest_half_or_the_largest_pixel) {
  ExrPart part = plain(1, 1, 1);
  part.channels[2].value = [](int x, int y) {
    return x == 3 && y == 2 ? infinity : x == 5 && y == 6 ? nan : 1.0f;
  };
  LoadedImage loaded = load(exr_file({part}));
  expect_color(loaded.image->texels()[2 * 16 + 3], 65504, 1, 1);
  expect_color(loaded.image->texels()[6 * 16 + 5], 0, 1, 1);
  ASSERT_EQ(loaded.warnings.size(), 2u);
  EXPECT_EQ(loaded.warnings[0],
            "1 of its 128 pixels are infinite: taken as 65504 (the first: column 3, row 2 from the "
            "top left)");
  EXPECT_EQ(loaded.warnings[1],
            "1 of its 128 pixels are no numbers (NaN): taken as 0 (the first: column 5, row 6 from "
            "the top left)");
  part.channels[0].value = [](int x, int) { return x == 0 ? 1e6f : -infinity; };
  loaded = load(exr_file({part}));
  EXPECT_EQ(loaded.image->texels()[2 * 16 + 3].x, 1e6f);
  EXPECT_EQ(loaded.image->texels()[1].z, 0);
  ASSERT_EQ(loaded.warnings.size(), 3u);
  EXPECT_EQ(loaded.warnings[2].substr(0, 45), "120 of its 128 pixels are negative: taken as ");
  part.channels[0].value = [](int, int) { return 1e20f; };
  loaded = load(exr_file({part}));
  EXPECT_EQ(loaded.image->texels()[2 * 16 + 3].x, 1e12f);
}

TEST_F(ImageFile, errors_of_damage_name_the_file) {
  const std::string whole = exr_file({plain()});
  for (const std::size_t bytes : {whole.size() / 2, whole.size() - 20, std::size_t{40}}) {
    const std::string message = refusal(whole.substr(0, bytes), "cut.exr");
    EXPECT_EQ(message.substr(0, 9), "damaged: ") << bytes;
    EXPECT_EQ(message.find("/proc"), std::string::npos) << message;
  }
  EXPECT_NE(refusal(whole.substr(0, whole.size() - 20), "cut.exr").find(path("cut.exr")),
            std::string::npos);
}

TEST_F(ImageFile, info_shows_the_metadata_of_an_image) {
  ExrPart depth, rgba = plain();
  depth.name = "depth";
  depth.channels = {{"Z", [](int, int) { return 1000.0f; }}};
  rgba.name = "rgba";
  rgba.data = {4, 2, 11, 5};
  depth.attributes = exr_attribute(  // must be the same in all parts
      "chromaticities", "chromaticities",
      bytes_of({0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f}));
  rgba.attributes = depth.attributes + exr_attribute("envmap", "envmap", std::string(1, '\0'));
  const Json shown = Json::parse(info(put(exr_file({depth, rgba})), true).text);
  EXPECT_EQ(shown["size"], Json({16, 8}));
  EXPECT_EQ(shown["format"], "exr");
  EXPECT_EQ(shown["parts"][0]["channels"], "Z");
  EXPECT_EQ(shown["parts"][1]["data window"], Json({4, 2, 11, 5}));
  EXPECT_EQ(shown["parts"][1]["envmap"], "latlong");
  EXPECT_EQ(shown["taken"], "part 1 'rgba'");
  EXPECT_EQ(shown["primaries"][0], 0.708);
  EXPECT_EQ(shown["use"], "the image of an environment light");
  const Json none = Json::parse(info(put(exr_file({depth})), true).text);
  EXPECT_EQ(none["channels"], "Z");
  EXPECT_EQ(none["use"].get<std::string>().substr(0, 24), "none: it has no colours:");
}

#endif

// ---- Radiance

/// \return grey pixels of 0.5, 1, 2, 4, ...
std::string powers(int count) {
  std::string pixels;
  for (int i = 0; i < count; ++i) pixels += std::string(3, '\x80') + static_cast<char>(128 + i);
  return pixels;
}

TEST_F(ImageFile, exposures_divide_and_multiply_each_other) {
  const auto loaded =
      load(radiance_file("EXPOSURE=4\nFORMAT=32-bit_rle_rgbe\n\tEXPOSURE=100\nEXPOSURE=0.5\n"
                         "COLORCORR=1 2 4\n",
                         "-Y 1 +X 2", powers(2)),
           "sky.hdr");
  expect_color(loaded.image->texels()[0], 0.25f, 0.125f, 0.0625f);
  expect_color(loaded.image->texels()[1], 0.5f, 0.25f, 0.125f);
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_EQ(loaded.told["exposure"], 2);
  EXPECT_EQ(refusal(radiance_file("EXPOSURE=0\n", "-Y 1 +X 2", powers(2)), "sky.hdr"),
            "damaged: its EXPOSURE is 0, not above 0");
  EXPECT_EQ(refusal(radiance_file("EXPOSURE=much\n", "-Y 1 +X 2", powers(2)), "sky.hdr"),
            "damaged: its EXPOSURE is 'much', not 1 number");
}

// "Radiance File Formats": the first axis is the major one; +X points right, +Y points up.
TEST_F(ImageFile, all_orders_of_pixels_are_turned_upright) {
  struct Order {
    const char* resolution;
    std::vector<int> upright;  // the stored index of each upright pixel, row by row
  };
  const Order orders[] = {{"-Y 2 +X 3", {0, 1, 2, 3, 4, 5}}, {"-Y 2 -X 3", {2, 1, 0, 5, 4, 3}},
                          {"+Y 2 +X 3", {3, 4, 5, 0, 1, 2}}, {"+Y 2 -X 3", {5, 4, 3, 2, 1, 0}},
                          {"+X 3 -Y 2", {0, 2, 4, 1, 3, 5}}, {"-X 3 -Y 2", {4, 2, 0, 5, 3, 1}},
                          {"+X 3 +Y 2", {1, 3, 5, 0, 2, 4}}, {"-X 3 +Y 2", {5, 3, 1, 4, 2, 0}}};
  for (const Order& order : orders) {
    SCOPED_TRACE(order.resolution);
    const auto loaded =
        load(radiance_file("FORMAT=32-bit_rle_rgbe\n", order.resolution, powers(6)), "sky.hdr");
    ASSERT_EQ(loaded.image->width(), 3);
    ASSERT_EQ(loaded.image->height(), 2);
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(loaded.image->texels()[i].x, std::ldexp(0.5f, order.upright[i])) << i;
  }
  EXPECT_EQ(refusal(radiance_file("", "-Y 2 +Y 3", powers(6)), "sky.hdr").substr(0, 36),
            "damaged: '-Y 2 +Y 3' is not the size");
}

// rpict(1): views are perspectives (-vtv, the default), parallel (l), cylinders (c) or fisheyes (a,
// h, s).
TEST_F(ImageFile, a_radiance_picture_with_a_view_is_no_map) {
  const auto read = [&](const std::string& lines) {
    return load(radiance_file(lines, "-Y 1 +X 2", powers(2)), "sky.hdr");
  };
  const auto warning = [&](const std::string& lines) {
    const LoadedImage loaded = read(lines);
    EXPECT_EQ(loaded.warnings.size(), 1u) << lines;
    return loaded.warnings.empty() ? "" : loaded.warnings[0];
  };
  EXPECT_EQ(warning("VIEW= -vta -vp 0 0 0 -vh 360\n"),
            "its VIEW is an angular fisheye (-vta), but it is read as longitude and latitude; "
            "convert it to these first");
  EXPECT_EQ(warning("VIEW= -vtc\n").substr(0, 42), "its VIEW is a cylindrical panorama (-vtc),");
  EXPECT_EQ(warning("VIEW= -vp 1 2 3\n").substr(0, 33), "its VIEW is a perspective (-vtv),");
  EXPECT_EQ(warning("VIEW= -vth\nVIEW= -vp 1 2 3\n").substr(0, 43),
            "its VIEW is a hemispherical fisheye (-vth),");
  EXPECT_EQ(warning("VIEW= -vtx\n").substr(0, 38), "its VIEW is of an unknown type (-vtx),");
  EXPECT_TRUE(read("\tVIEW= -vta\n").warnings.empty());
  EXPECT_EQ(warning("PIXASPECT=4\nPIXASPECT=0.5\n").substr(0, 34),
            "its PIXASPECT of 2 is not applied:");
  EXPECT_TRUE(read("PIXASPECT=1\n").warnings.empty());
  EXPECT_EQ(refusal(radiance_file("PIXASPECT=0\n", "-Y 1 +X 2", powers(2)), "sky.hdr"),
            "damaged: its PIXASPECT is 0, not above 0");
  const std::string wide =
      put(radiance_file("VIEW= -vtl -vh 3\nPIXASPECT=2\n", "-Y 1 +X 2", powers(2)), "sky.hdr");
  const Json told = Json::parse(info(wide, true).text);
  EXPECT_EQ(told["view"], "-vtl -vh 3");
  EXPECT_EQ(told["pixel aspect ratio"], 2);
}

TEST_F(ImageFile, radiance_has_primaries_and_pictures_in_xyz) {
  const std::string grey = powers(2);
  const auto rgb = load(radiance_file("PRIMARIES= .708 .292 .170 .797 .131 .046 .3127 .3290\n",
                                      "-Y 1 +X 2", std::string("\x80\0\0\x81", 4) + grey.substr(4)),
                        "sky.hdr");
  EXPECT_NEAR(rgb.image->texels()[0].x, 1.6605, 1e-3);  // red of Rec. 2020
  EXPECT_EQ(rgb.image->texels()[0].y, 0);
  EXPECT_NEAR(rgb.image->texels()[1].y, 1, 1e-5);
  const auto xyz = load(radiance_file("FORMAT=32-bit_rle_xyze\n", "-Y 1 +X 2", grey), "sky.hdr");
  expect_color(xyz.image->texels()[1], 1, 1, 1, 1e-5f);  // X = Y = Z is white there
  EXPECT_NE(refusal(radiance_file("FORMAT=ascii\n", "-Y 1 +X 2", grey), "sky.hdr").find("ascii"),
            std::string::npos);
}

TEST_F(ImageFile, radiance_packs_rows_in_two_ways) {
  // The new format encodes each component separately. Of 8 pixels, 4 have red 0x80, 4 have 0x40.
  std::string row("\2\2\0\x08", 4);
  row += std::string("\x84\x80\x84\x40", 4);        // red: two runs of 4
  row += std::string("\x88\x40", 2);                // green: a run of 8
  row += std::string("\x08\1\2\3\4\5\6\7\x08", 9);  // blue: 8 literal bytes
  row += std::string("\x88\x81", 2);                // exponent
  const auto modern = load(radiance_file("", "-Y 1 +X 8", row), "sky.hdr");
  for (std::size_t x = 0; x < 8; ++x)
    expect_color(modern.image->texels()[x], x < 4 ? 1.0f : 0.5f, 0.5f,
                 static_cast<float>(x + 1) / 128);
  // In the old format a pixel (1, 1, 1, n) repeats the last one n times.
  const auto old =
      load(radiance_file("", "-Y 1 +X 8",
                         std::string("\x80\x80\x80\x81\1\1\1\5", 8)
                             + std::string("\x40\x40\x40\x81", 4) + std::string("\1\1\1\1", 4)),
           "sky.hdr");
  for (std::size_t x = 0; x < 8; ++x) EXPECT_EQ(old.image->texels()[x].x, x < 6 ? 1.0f : 0.5f);
  EXPECT_EQ(refusal(radiance_file("", "-Y 1 +X 8", row.substr(0, row.size() - 1)), "sky.hdr"),
            "damaged: its end is missing");
}

// ---- TIFF, JPEG, PFM

#if TYNDALL_OPENIMAGEIO

TEST_F(ImageFile, the_orientation_of_tiff_and_jpeg_is_applied) {
  const std::vector<float> rgb{1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6, 6, 6};
  // TIFF 6.0: the sides of the first row and the first column.
  const std::vector<std::vector<int>> upright{
      {1, 2, 3, 4, 5, 6}, {3, 2, 1, 6, 5, 4}, {6, 5, 4, 3, 2, 1}, {4, 5, 6, 1, 2, 3},
      {1, 4, 2, 5, 3, 6}, {4, 1, 5, 2, 6, 3}, {6, 3, 5, 2, 4, 1}, {3, 6, 2, 5, 1, 4}};
  for (int orientation : {1, 2, 3, 4, 5, 6, 7, 8}) {
    SCOPED_TRACE(orientation);
    const auto loaded = load(tiff_file(3, 2, rgb, orientation), "sky.tif");
    EXPECT_EQ(loaded.image->width(), orientation < 5 ? 3 : 2);
    const std::vector<int>& wanted = upright[static_cast<std::size_t>(orientation - 1)];
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(loaded.image->texels()[i].x, static_cast<float>(wanted[i])) << i;
  }
  const auto upside_down = load(jpeg_file(3), "sky.jpg");
  EXPECT_LT(upside_down.image->texels()[0].x, 0.1f);
  EXPECT_GT(upside_down.image->texels()[16 * 8 - 1].x, 0.9f);
  EXPECT_LT(upside_down.image->texels()[16 * 7].x, 0.1f);
  EXPECT_EQ(upside_down.told["orientation"], 3);
  const auto turned = load(jpeg_file(6), "sky.jpg");  // the first row is at the right
  EXPECT_EQ(turned.image->width(), 8);
  EXPECT_GT(turned.image->texels()[7].x, 0.9f);
  EXPECT_LT(turned.image->texels()[0].x, 0.1f);
}

TEST_F(ImageFile, invalid_floats_of_pfm_are_replaced_too) {
  const auto loaded = load(pfm_file(2, 1, {1, infinity, 70000, nan, 0, -1}), "sky.pfm");
  expect_color(loaded.image->texels()[0], 1, 70000, 70000);
  expect_color(loaded.image->texels()[1], 0, 0, 0);
  EXPECT_EQ(loaded.warnings.size(), 3u);
}

#endif
#endif

}  // namespace
}  // namespace tyndall::io
