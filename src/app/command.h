/// \file
/// A command of the program. Each *_command.cpp exports one, and main.cpp lists them.
#pragma once

#include <functional>

#include "tyndall/render/error.h"

namespace CLI {
class App;
}

namespace tyndall::app {

/// \return the exit code of a command. \throws Error, Stopped
using Run = std::function<ExitCode()>;

struct Command {
  const char* name;
  const char* help;
  /// Adds the options. \return a function that runs the command once the options are parsed
  Run (*add)(CLI::App& command);
  bool is_for_every_rank = false;  ///< false: only the first rank of an MPI job runs the command
};

extern const Command render_command, merge_command, bake_command, validate_command, info_command,
    convert_command, devices_command, schema_command, defaults_command;

}  // namespace tyndall::app
