// The only file with OpenImageIO; built as a module of its own, see io/module.h.
#include "io/plugin/oiio.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

namespace {

std::vector<unsigned char> encode(int width, int height, const unsigned char* rgb,
                                  std::string& problem) {
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("png", &memory);
  if (!output)
    problem = OIIO::geterror();
  else if (!output->open("memory.png", spec) || !output->write_image(OIIO::TypeDesc::UINT8, rgb)
           || !output->close())
    problem = output->geterror();
  return bytes;
}

/// \return OpenImageIO's name of a file's format, by how it begins; empty for what no sky is kept
/// in. OpenImageIO itself would try dozens of readers one after the other, medical ones among them.
std::string format_of(const char* path) {
  std::string head(10, '\0');
  head.resize(std::ifstream(path, std::ios::binary).read(head.data(), 10).gcount());
  const struct {
    std::string_view begins;
    const char* format;
  } formats[] = {{"\x76\x2f\x31\x01", "openexr"},
                 {"#?RADIANCE", "hdr"},
                 {"#?RGBE", "hdr"},
                 {"\x89PNG", "png"},
                 {"\xff\xd8\xff", "jpeg"},
                 {{"II*\0", 4}, "tiff"},
                 {{"MM\0*", 4}, "tiff"},
                 {"PF", "pnm"},
                 {"Pf", "pnm"}};
  for (const auto& [begins, format] : formats)
    if (head.compare(0, begins.size(), begins) == 0) return format;
  return "";
}

/// \return the problem, empty for none.
std::string read(const char* path, TyndallRoom* room, void* user, int& on_curve) {
  const std::string format = format_of(path);
  if (format.empty()) return "of another format than .exr, .hdr, .png, .jpg, .tif or .pfm";
  const auto input = OIIO::ImageInput::create(format);
  if (!input) return OIIO::geterror();
  OIIO::ImageSpec spec;
  if (!input->open(path, spec)) return input->geterror();
  constexpr long long most = 1 << 28;
  if (spec.deep || spec.depth > 1 || spec.width < 1 || spec.height < 1 || spec.nchannels < 1)
    return "not a flat image";
  if (static_cast<long long>(spec.width) * spec.height > most) return "more than 2^28 pixels";
  // No format that light is kept in packs more than a thousand pixels into a byte.
  const long long pixels = static_cast<long long>(spec.width) * spec.height,
                  bytes = static_cast<long long>(OIIO::Filesystem::file_size(path));
  if (pixels / 2000 > bytes)
    return "claims " + std::to_string(pixels) + " pixels in " + std::to_string(bytes) + " bytes";
  // Radiance files and the like are linear, whatever they say.
  on_curve = !spec.format.is_floating_point()
             && spec.get_string_attribute("oiio:ColorSpace", "sRGB") != "Linear";
  const int channels = spec.nchannels < 3 ? 1 : 3;
  float* const rgb = room(user, spec.width, spec.height);
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, rgb)) return input->geterror();
  if (channels == 1) {
    for (std::size_t i = static_cast<std::size_t>(spec.width) * spec.height; i-- > 0;)
      rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = rgb[i];
  }
  return "";
}

/// Runs `work`, which returns its problem. No exception may cross the border.
template <class Work>
int guarded(char* message, std::size_t message_size, const Work& work) {
  std::string problem;
  try {
    problem = work();
    if (problem.empty()) return 0;
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::size_t length = std::min(problem.size(), message_size - 1);
  std::memcpy(message, problem.data(), length);
  message[length] = '\0';
  return 1;
}

}  // namespace

int tyndall_encode_png_1(int width, int height, const unsigned char* rgb, TyndallSink sink,
                         void* user, char* message, std::size_t message_size) {
  return guarded(message, message_size, [&] {
    std::string problem;
    const std::vector<unsigned char> bytes = encode(width, height, rgb, problem);
    if (problem.empty() && bytes.empty()) problem = "OpenImageIO wrote nothing";
    if (problem.empty()) sink(user, bytes.data(), bytes.size());
    return problem;
  });
}

int tyndall_read_image_1(const char* path, TyndallRoom* room, void* user, int* on_curve,
                         char* message, std::size_t message_size) {
  return guarded(message, message_size, [&] { return read(path, room, user, *on_curve); });
}
