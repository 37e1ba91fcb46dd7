/// \file
/// Standard output carries what was asked for; everything else goes to standard error.
#pragma once

#include <string_view>

namespace tyndall::session {

/// Makes sure that no output file gets the number of a standard stream that was closed before the
/// start.
void reserve_standard_streams();

/// \throws Error(output_failed).
void print(std::string_view text);

/// For people, on standard error. Never fails: a lost message is no reason to lose a picture.
void say(std::string_view text) noexcept;

/// Says one line that begins with "tyndall: warning: ".
void warn(std::string_view text);

}  // namespace tyndall::session
