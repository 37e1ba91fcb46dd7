/// \file
/// Options of several commands, and validators of their values.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "session/session.h"
#include "tyndall/render/part.h"
#include "tyndall/scene/limits.h"

namespace tyndall::app {

struct SceneArguments {
  std::string scene;
  std::vector<std::string> overrides;  ///< "path=value"
};

/// Frames first, first + step, ... up to last.
struct FrameRange {
  int first = 1, last = 1, step = 1;
};

/// Accepts an integer in [least, most], written as "2000000" or "2e6", and rewrites it as plain
/// digits.
CLI::Validator count(std::uint64_t most = std::numeric_limits<std::uint64_t>::max(),
                     std::uint64_t least = 0);
CLI::Validator count(const Range& range);
/// Accepts a time, "90s", "5m", "1.5h" or "90", and rewrites it in seconds.
CLI::Validator duration(bool may_be_zero);
/// Accepts a number in (0, 1), such as 0.01 for 1 %.
CLI::Validator fraction();

void add_scene(CLI::App& command, SceneArguments& arguments);
/// Adds an option that sets the scene's `key`. CLI11 handles options in the order of their
/// definition, so these override -D.
void add_override(CLI::App& command, SceneArguments& arguments, const std::string& flags,
                  const std::string& key, const CLI::Validator& validator, const std::string& help);
void add_work(CLI::App& command, session::WorkArguments& arguments);
/// Adds `flag` A:B. The numbers may be written as 2e6.
void add_range(CLI::App& command, std::optional<IndexRange>& range, const std::string& flag,
               const std::string& help);
/// Adds --frames A, A:B or A:B:STEP.
void add_frames(CLI::App& command, std::optional<FrameRange>& frames, const std::string& help);

}  // namespace tyndall::app
