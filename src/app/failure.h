/// \file
/// Reports exceptions that end the program early.
#pragma once

#include <string_view>

namespace tyndall::app {

/// Reports the exception that is being handled. \param who the process that failed, such as
/// "rank 3: "; empty if there is only one \return the exit code. \pre within a catch block
int report_failure(std::string_view who = "");

}  // namespace tyndall::app
