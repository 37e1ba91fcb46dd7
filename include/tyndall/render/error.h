/// \file
/// Errors that are reported to the user. The exit codes are an interface: scripts depend on them.
#pragma once

#include <stdexcept>
#include <string>

namespace tyndall {

enum class ExitCode {
  done = 0,
  internal = 1,       ///< a defect of Tyndall, such as a ledger that does not close
  usage = 2,          ///< the command line
  scene_invalid = 3,  ///< the scene file's contents
  input_missing = 4,  ///< an input file that is missing or damaged
  output_failed = 5,  ///< an output that cannot be written
  out_of_memory = 6,
  device = 7,         ///< no usable GPU, or one that failed
  limit = 8,          ///< stopped by a time limit before every pixel had a sample
  interrupted = 130,  ///< SIGINT
  terminated = 143,   ///< SIGTERM
};

/// what() gives the problem, its cause and a remedy; one line per problem.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace tyndall
