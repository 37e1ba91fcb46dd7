// Scene files: any bytes are either read and checked, or refused.
#include "io/scene_json.h"

#include "fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace tyndall;
  return fuzz::expect_an_error_at_most([&] {
    const fuzz::File file(bytes, size);
    io::read_scene(file.path(), {});
  });
}
