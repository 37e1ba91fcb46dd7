#include "io/helper/input.h"

#include <sys/stat.h>
#include <unistd.h>

namespace tyndall::io {

void damaged(const std::string& message) { throw Failure{error_damaged, message}; }

std::uint64_t input_size() {
  struct stat status {};
  if (::fstat(STDIN_FILENO, &status) != 0) damaged("cannot be read");
  return static_cast<std::uint64_t>(status.st_size);
}

void read_at(std::uint64_t place, void* to, std::size_t bytes) {
  auto* out = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = ::pread(STDIN_FILENO, out, bytes, static_cast<off_t>(place));
    if (got <= 0) damaged(got == 0 ? "its end is missing" : "cannot be read");
    out += got;
    place += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
}

}  // namespace tyndall::io
