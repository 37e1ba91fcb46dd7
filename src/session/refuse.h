/// \file
/// Checks that no output of a run replaces another file of the run.
#pragma once

#include <string>
#include <vector>

namespace tyndall::session {

/// \throws Error(usage)
[[noreturn]] void usage_error(const std::string& message);

/// \throws Error(usage) if one output would replace another
void refuse_repeats(const std::vector<std::string>& outputs);

/// \throws Error(usage) if an output would replace an input
/// \param first, others descriptions of the first and of the other inputs for the message
void refuse_inputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                   const char* first = "the scene itself",
                   const char* others = "read by the scene");

}  // namespace tyndall::session
