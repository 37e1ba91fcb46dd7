/// \file
/// Common parts of the targets: bytes as a file, and checks of errors.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "tyndall/render/error.h"

namespace tyndall::fuzz {

/// A memory file of `size` bytes.
class File {
 public:
  File(const std::uint8_t* bytes, std::size_t size) {
    const int first = ::memfd_create("fuzz", 0);
    number_ = ::fcntl(first, F_DUPFD, 10);  // above the numbers with a meaning
    ::close(first);
    if (number_ < 0 || ::write(number_, bytes, size) != static_cast<ssize_t>(size)) std::abort();
  }
  ~File() { ::close(number_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(number_); }

 private:
  int number_ = -1;
};

/// Calls read(). An Error must have a message and not be internal; other exceptions are findings.
template <class Read>
int expect_an_error_at_most(Read&& read) {
  try {
    read();
  } catch (const Error& error) {
    if (error.what()[0] == '\0' || error.code() == ExitCode::internal) std::abort();
  }
  return 0;
}

}  // namespace tyndall::fuzz
