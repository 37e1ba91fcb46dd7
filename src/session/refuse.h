/// \file
/// What a run refuses to do with the files that it reads and writes.
#pragma once

#include <string>
#include <vector>

namespace tyndall::session {

/// \throws Error(usage)
[[noreturn]] void usage_error(const std::string& message);

/// No output may replace another. \throws Error(usage)
void refuse_repeats(const std::vector<std::string>& outputs);

/// No output may replace what the run reads. \throws Error(usage)
/// \param first, others what the inputs are
void refuse_inputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                   const char* first = "the scene itself",
                   const char* others = "read by the scene");

}  // namespace tyndall::session
