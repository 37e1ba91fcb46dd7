// The only file with OpenImageIO; built as a module of its own, see io/png.h.
#include "io/plugin/oiio_png.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <string>
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

}  // namespace

int tyndall_encode_png_1(int width, int height, const unsigned char* rgb, TyndallSink sink,
                         void* user, char* message, std::size_t message_size) {
  std::string problem;
  try {  // no exception may cross the border
    const std::vector<unsigned char> bytes = encode(width, height, rgb, problem);
    if (problem.empty() && bytes.empty()) problem = "OpenImageIO wrote nothing";
    if (problem.empty()) {
      sink(user, bytes.data(), bytes.size());
      return 0;
    }
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::size_t length = std::min(problem.size(), message_size - 1);
  std::memcpy(message, problem.data(), length);
  message[length] = '\0';
  return 1;
}
