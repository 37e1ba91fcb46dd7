/// \file
/// The parent's side of io/helper/protocol.h: a separate helper process reads each image or volume
/// and writes each volume.
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

/// \throws Error: input_missing if `path` is not a readable regular file, out_of_memory if this
/// process can open no more files.
Descriptor open_input(const std::string& path);

/// \return an empty memory file. `path` is named in errors. \throws Error(out_of_memory)
Descriptor memory_file(const std::string& path);

/// Calls the helper on `file`, with an empty memory file for its result. \param words the command
/// and its arguments, without the limits \param voxels along the longest side of a mesh, 0 for
/// other files; the limits grow with their square \return the helper's object, which may hold
/// "error". \throws Error that names `path` if the helper itself fails: input_missing for a file
/// that crashes it, out_of_memory if it inherits too few resources from this process.
Json call_helper(const std::string& path, const Descriptor& file, const Descriptor& memory,
                 std::vector<std::string> words, int voxels = 0);

/// \return `text`, cut to `most` bytes.
std::string cut(const std::string& text, std::size_t most = 60);

}  // namespace tyndall::io
