/// \file
/// What ends the program before its work is done.
#pragma once

#include <string_view>

namespace tyndall::app {

/// Says what the exception that is being handled is about. \param who who failed, such as
/// "rank 3: ", if that is a question \return the exit code. \pre within a catch block
int tell_failure(std::string_view who = "");

}  // namespace tyndall::app
