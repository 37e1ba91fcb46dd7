// Environment images, as the helper decodes them, and pictures, as read_exr() reads them.
#include <exception>

#include "fuzz/fuzz.h"
#include "io/exr.h"
#include "io/helper/images.h"
#include "io/helper/input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace tyndall;
  const fuzz::File file(bytes, size), memory(nullptr, 0);
  const auto give = [](const fuzz::File& from, int number) {
    const int opened = ::open(from.path().c_str(), O_RDWR);
    if (::dup2(opened, number) != number) std::abort();
    if (opened != number) ::close(opened);
  };
  const int others = ::fcntl(io::memory_descriptor, F_DUPFD, 10);  // the fuzzer may use this number
  give(file, STDIN_FILENO);
  give(memory, io::memory_descriptor);
  try {
    io::read_image();
  } catch (const io::Failure& failure) {
    if (failure.message.empty()) std::abort();
  } catch (const std::exception&) {  // a library's error for damage
  }
  ::close(io::memory_descriptor);
  if (others >= 0) {
    ::dup2(others, io::memory_descriptor);
    ::close(others);
  }
  return fuzz::expect_an_error_at_most([&] { io::read_exr(file.path()); });
}
