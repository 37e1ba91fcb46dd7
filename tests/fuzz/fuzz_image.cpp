// Images of the sky, and the pictures that `tyndall info` reads.
#include "fuzz/fuzz.h"
#include "io/exr.h"
#include "io/image_file.h"
#include "tyndall/render/image.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace tyndall;
  const fuzz::File file(bytes, size);
  fuzz::expect_an_error_at_most([&] { io::load_image(file.path()); });
  return fuzz::expect_an_error_at_most([&] { io::read_exr(file.path()); });
}
