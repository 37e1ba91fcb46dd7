/// \file
/// The table of commands and options as a man page and as shell completions.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace tyndall::app {

/// \param format "man" (roff, section 1), "bash" or "zsh"
std::string manual(const CLI::App& app, const std::string& format, const std::string& examples);

}  // namespace tyndall::app
