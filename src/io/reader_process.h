/// \file
/// The parent's side of io/helper/protocol.h: one process of its own for each file that is read, or
/// written as a volume.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "io/json_text.h"

namespace tyndall::io {

/// \throws Error(input_missing): the file and why it is not read.
[[noreturn]] void fail_reading(const std::string& path, const std::string& why);

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { close(); }
  void close();
  int number() const { return number_; }
  std::uint64_t size() const;  ///< [byte] of its file

 private:
  int number_;
};

/// \throws Error: input_missing where `path` is no regular file that can be read, out_of_memory
/// where this process may open no more files.
Descriptor open_input(const std::string& path);

/// An empty file in memory, for what is read from `path`. \throws Error(out_of_memory)
Descriptor memory_file(const std::string& path);

/// Calls the helper on `file`, with an empty memory file for what it hands back. \param words the
/// command and its arguments, without the limits \param voxels along the longest side of a mesh:
/// what it takes follows their square; 0: no mesh \return its object, which may hold "error".
/// \throws Error that names `path` where the helper itself fails: input_missing for a file that it
/// dies of, out_of_memory where this process passes too little on to it.
Json call_helper(const std::string& path, const Descriptor& file, const Descriptor& memory,
                 std::vector<std::string> words, int voxels = 0);

/// \return `text`, cut to `most` bytes.
std::string cut(const std::string& text, std::size_t most = 60);

}  // namespace tyndall::io
