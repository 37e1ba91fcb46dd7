// `tyndall convert`: writes a scene for another renderer.
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/options.h"
#include "io/convert.h"
#include "io/output_file.h"
#include "session/console.h"
#include "session/refuse.h"
#include "session/signals.h"

namespace tyndall::app {
namespace {

struct ConvertArguments : SceneArguments {
  std::string output;
  int voxels = io::default_voxels;  ///< along the longest side of a field that is sampled
};

ExitCode run(const ConvertArguments& arguments) {
  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  for (const std::string& warning : file.warnings) session::warn(warning);
  session::catch_signals();  // the outputs below have temporaries
  session::leave_on_signal();
  io::OutputFile scene(arguments.output);  // throws if it cannot be written
  const std::vector<io::ConvertedFile> converted =
      io::convert(file, arguments.output, arguments.voxels);
  std::vector<std::string> paths;
  for (const io::ConvertedFile& part : converted) paths.push_back(part.path);
  session::refuse_inputs(file.inputs, paths);
  const auto write = [](io::OutputFile& output, const std::string& bytes) {
    output.write(bytes);
    output.commit();
    session::say(fmt::format("written  {}\n", output.path()));
  };
  // The scene is written last: it reads the others.
  for (std::size_t i = 1; i < converted.size(); ++i) {
    io::OutputFile grid(converted[i].path);
    write(grid, converted[i].bytes);
  }
  write(scene, converted[0].bytes);
  return ExitCode::done;
}

Run add(CLI::App& command) {
  const auto arguments = std::make_shared<ConvertArguments>();
  add_scene(command, *arguments);
  command
      .add_option("-o,--output", arguments->output,
                  "Scene to write: .pbrt, or .py for Mitsuba; grids lie beside it")
      ->required()
      ->type_name("FILE");
  command
      .add_option(
          "--voxels", arguments->voxels,
          fmt::format("Voxels along the longest side of a sampled field ({})", io::default_voxels))
      ->type_name("N")
      ->transform(count(io::most_voxels, io::least_voxels));
  return [arguments] { return run(*arguments); };
}

}  // namespace

const Command convert_command{"convert", "Writes a scene for pbrt-v4 or Mitsuba 3", &add};

}  // namespace tyndall::app
