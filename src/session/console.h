/// \file
/// Results go to standard output, everything else to standard error.
#pragma once

#include <string_view>

namespace tyndall::session {

/// Opens standard streams that were closed before the start, so that no output file gets their
/// numbers.
void reserve_standard_streams();

/// Prints to standard output. \throws Error(output_failed)
void print(std::string_view text);

/// Prints a message to standard error. Never fails: a lost message must not cost a picture.
void say(std::string_view text) noexcept;

/// Prints a line that begins with "tyndall: warning: " to standard error.
void warn(std::string_view text);

}  // namespace tyndall::session
