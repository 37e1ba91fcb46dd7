// The only file that uses OpenImageIO. It is built as a separate module, see io/module.h.
#include "io/plugin/oiio.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>
#include <string_view>

#include <OpenImageIO/imageio.h>

namespace {

/// \return OpenImageIO's name of a file's format, from its first bytes; empty for formats that
/// environment maps do not use. OpenImageIO would try dozens of readers, even for medical images.
std::string format_of(const char* path) {
  std::string head(10, '\0');
  head.resize(std::ifstream(path, std::ios::binary).read(head.data(), 10).gcount());
  const struct {
    std::string_view begins;
    const char* format;
  } formats[] = {{"\x89PNG", "png"},     {"\xff\xd8\xff", "jpeg"},
                 {{"II*\0", 4}, "tiff"}, {{"MM\0*", 4}, "tiff"},
                 {{"II+\0", 4}, "tiff"}, {{"MM\0+", 4}, "tiff"},
                 {"PF", "pnm"},          {"Pf", "pnm"}};
  for (const auto& [begins, format] : formats)
    if (head.compare(0, begins.size(), begins) == 0) return format;
  return "";
}

/// \return the transfer curve of integer pixels: see DecodedImage::curve.
double curve_of(const OIIO::ImageSpec& spec) {
  if (spec.format.is_floating_point()) return 0;
  const double gamma = double{spec.get_float_attribute("oiio:Gamma", 0.0f)};
  const bool is_linear = spec.get_string_attribute("oiio:ColorSpace", "sRGB") == "Linear";
  if (is_linear) return 0;
  // PNG writers store a gamma of 1 / 2.2 for the sRGB curve.
  return gamma > 0 && std::abs(gamma - 2.2) > 0.05 ? gamma : 1;
}

/// \return the problem, empty for none.
std::string read(const char* path, TyndallRoom* room, TyndallTell* report, void* user) {
  const std::string format = format_of(path);
  if (format.empty()) return "of another format than .exr, .hdr, .png, .jpg, .tif or .pfm";
  const auto input = OIIO::ImageInput::create(format);
  if (!input) return OIIO::geterror();
  OIIO::ImageSpec spec;
  if (!input->open(path, spec)) return input->geterror();
  if (spec.deep || spec.depth > 1 || spec.width < 1 || spec.height < 1 || spec.nchannels < 1)
    return "not a flat image";
  if (spec.get_string_attribute("textureformat").find("CubeFace") != std::string::npos)
    return "a cube map of six faces: convert it to longitude and latitude";
  const std::string projection = spec.get_string_attribute("GPano:ProjectionType");
  if (!projection.empty() && projection != "equirectangular")
    return "a panorama of projection '" + projection.substr(0, 40)
           + "': convert it to longitude and latitude";

  TyndallImage image{};
  image.width = spec.width;
  image.height = spec.height;
  image.left = spec.x - spec.full_x;
  image.top = spec.y - spec.full_y;
  image.whole_width = spec.full_width;
  image.whole_height = spec.full_height;
  image.orientation = spec.get_int_attribute("Orientation", 1);
  image.curve = curve_of(spec);
  const std::string profile = spec.get_string_attribute("ICCProfile:profile_description");
  std::string names;
  for (const std::string& name : spec.channelnames) names += (names.empty() ? "" : ", ") + name;
  report(user, "format", format == "pnm" ? "pfm" : format.c_str());
  report(user, "pixels", spec.format.c_str());
  report(user, "channels", names.c_str());
  if (!profile.empty()) report(user, "color profile", profile.c_str());
  if (spec.find_attribute("ICCProfile") && profile.find("sRGB") == std::string::npos)
    report(user, nullptr,
           ("its color profile" + (profile.empty() ? "" : " '" + profile.substr(0, 60) + "'")
            + " is not applied: its colors count as those of Rec. 709")
               .c_str());
  float* const rgb = room(user, &image);
  if (rgb == nullptr) return "";
  const int channels = spec.nchannels < 3 ? 1 : 3;
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, rgb)) return input->geterror();
  if (channels == 1) {
    for (std::size_t i = static_cast<std::size_t>(spec.width) * spec.height; i-- > 0;)
      rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = rgb[i];
  }
  if (input->seek_subimage(1, 0))
    report(user, nullptr, "it holds several images: the first one is used");
  return "";
}

}  // namespace

int tyndall_read_image_2(const char* path, TyndallRoom* room, TyndallTell* report, void* user,
                         char* message, std::size_t message_size) {
  std::string problem;
  try {  // no exception may cross the C interface
    OIIO::attribute("threads", 1);
    problem = read(path, room, report, user);
    if (problem.empty()) return 0;
  } catch (const std::bad_alloc&) {
    problem = "out of memory";
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::size_t length = std::min(problem.size(), message_size - 1);
  std::memcpy(message, problem.data(), length);
  message[length] = '\0';
  return 1;
}
