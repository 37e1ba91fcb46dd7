/// \file
/// Reads the file on standard input, and reports failures.
#pragma once

#include <cstdint>
#include <string>

#include "io/helper/protocol.h"
#include "io/json_text.h"

namespace tyndall::io {

/// An exception that ends the program with a message for Tyndall.
struct Failure {
  const char* kind;
  std::string message;
  Json grids = {};
};

inline constexpr const char* too_much_memory = "it needs more memory than is available to it";

[[noreturn]] void damaged(const std::string& message);

std::uint64_t input_size();

/// \throws Failure if the file ends before.
void read_at(std::uint64_t place, void* to, std::size_t bytes);

template <class T>
T read_value(std::uint64_t place) {
  T value;
  read_at(place, &value, sizeof value);
  return value;
}

}  // namespace tyndall::io
