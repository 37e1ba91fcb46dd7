// `tyndall validate`: finds every error of a scene, or of the scenes of a sequence.
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/frames.h"
#include "app/options.h"
#include "io/scene_json.h"
#include "session/console.h"
#include "session/memory.h"
#include "tyndall/render/prepare.h"

namespace tyndall::app {
namespace {

struct ValidateArguments : SceneArguments {
  std::optional<FrameRange> frames;
};

ExitCode run(const ValidateArguments& arguments) {
  if (arguments.frames) return validate_frames(arguments, *arguments.frames);
  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  for (const std::string& warning : file.warnings) session::warn(warning);
  // Too little memory here is no error of the scene: another machine may render it.
  const std::string shortage = session::memory_shortage(file.scene);
  if (!shortage.empty()) session::warn(shortage);
  if (shortage.empty())
    for (const std::string& warning : lights_that_give_nothing(file.scene)) session::warn(warning);
  session::print(fmt::format("{}: valid\n", arguments.scene));
  return ExitCode::done;
}

Run add(CLI::App& command) {
  const auto arguments = std::make_shared<ValidateArguments>();
  add_scene(command, *arguments);
  add_frames(command, arguments->frames, "The scenes of a sequence, each with its volumes");
  return [arguments] { return run(*arguments); };
}

}  // namespace

const Command validate_command{"validate", "Finds every error of a scene", &add};

}  // namespace tyndall::app
