// `tyndall bake`: traces the photons of a scene and writes the fluence for other programs.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/options.h"
#include "io/bake_file.h"
#include "io/output_file.h"
#include "io/report.h"
#include "io/scene_json.h"
#include "session/refuse.h"
#include "session/session.h"
#include "tyndall/render/bake.h"
#include "tyndall/render/error.h"
#include "tyndall/render/prepare.h"

namespace tyndall::app {
namespace {

struct BakeArguments : SceneArguments, session::WorkArguments {
  std::vector<std::string> outputs;
  int order = 1;   ///< 0: without directions
  int voxels = 0;  ///< voxels of the density along the longest side; 0: the format's default
  bool per_light = false, half = false, multiple_only = false;
};

/// \return done, or 128 + the signal that ended the run. \throws Error, Stopped
ExitCode run(const BakeArguments& arguments) {
  const io::BakeOptions options{arguments.half, arguments.voxels, arguments.threads,
                                arguments.multiple_only};
  std::vector<std::string> paths;  // the outputs and the files beside them
  for (const std::string& path : arguments.outputs) {
    io::require_bake(path, options);
    for (const std::string& each : io::bake_paths(path)) paths.push_back(each);
    session::refuse_repeats(paths);
  }
  session::Session session(arguments);
  io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  const ResolvedScene scene =
      scene_to_bake(file.scene, arguments.order > 0, arguments.per_light, arguments.multiple_only);
  file.warnings = file.warnings_of(scene);
  session.accept(file, paths);
  session.prepare(scene, most_replicates);
  session::catch_signals(5.0);
  for (const std::string& path : paths) io::OutputFile{path};  // throws if it cannot be written

  RenderOptions render_options = session.control().options();
  render_options.photons = IndexRange{0, scene->photons};
  render_options.measures_matter = true;
  const std::unique_ptr<Renderer> renderer = session.begin(scene, render_options);
  for (const std::string& path : arguments.outputs)
    io::require_room(path, renderer->scene().cells.groups);
  const bool is_done = session.run(*renderer, true);
  const int signal = session::caught_signal();
  const std::uint64_t shot = renderer->part().photons().count();
  if (shot == 0) {
    if (signal != 0) throw Stopped{};
    throw Error(
        ExitCode::scene_invalid,
        fmt::format("{}: no light reaches the medium: there is nothing to bake", arguments.scene));
  }

  RenderResult result = renderer->result();
  result.is_complete = is_done;  // a bake has no samples
  session.finish(result, scene);
  const BakedLight light = bake(*renderer, scene);
  const io::Bake baked{arguments.scene, file, light, result.picture.provenance};
  session.report(*renderer, result, file, arguments.scene);
  // A failed output does not stop the others: the light may have taken hours.
  std::string failures;
  for (const std::string& path : arguments.outputs) {
    try {
      // The file at `path` is written last: it names the others.
      std::vector<std::string> warnings;
      std::vector<io::ConvertedFile> files = io::bake_files(baked, path, options, &warnings);
      for (const std::string& warning : warnings) session::warn(warning);
      std::rotate(files.begin(), files.begin() + 1, files.end());
      for (const io::ConvertedFile& part : files) {
        io::OutputFile output(part.path);
        output.write(part.bytes);
        output.commit();
        session::say(fmt::format("written  {}\n", part.path));
      }
    } catch (const Error& error) {
      failures += (failures.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  if (!failures.empty()) throw Error(ExitCode::output_failed, failures);
  if (is_done) return ExitCode::done;
  session::say(fmt::format("tyndall: stopped by a signal; the output has {} of {} photons\n", shot,
                           scene->photons));
  return static_cast<ExitCode>(128 + signal);
}

Run add(CLI::App& command) {
  const auto arguments = std::make_shared<BakeArguments>();
  add_scene(command, *arguments);
  command
      .add_option("-o,--output", arguments->outputs,
                  "File to write (" + io::known_bakes() + "); may be repeated")
      ->required()
      ->type_name("FILE")
      ->allow_extra_args(false);
  add_override(command, *arguments, "--photons", "photons.count", count(limits::photons),
               "Photons to shoot");
  add_override(command, *arguments, "-s,--seed", "seed", count(), "Seed of the random numbers");
  command
      .add_option("--order", arguments->order,
                  "1: with the directions of the light; 0: without (1)")
      ->type_name("N")
      ->transform(count(1));
  command.add_flag("--per-light", arguments->per_light, "Writes each light separately");
  command.add_flag("--multiple-only", arguments->multiple_only,
                   "Leaves out single scattering, for programs that add it");
  command.add_flag("--half", arguments->half, "Writes 16-bit floats");
  command
      .add_option("--voxels", arguments->voxels,
                  fmt::format("Voxels of the density along its longest side ({}; 128 in pages)",
                              io::default_voxels))
      ->type_name("N")
      ->transform(count(io::most_voxels, io::least_voxels));
  add_work(command, *arguments);
  return [arguments] { return run(*arguments); };
}

}  // namespace

const Command bake_command{"bake", "Writes a scene's light for other programs", &add};

}  // namespace tyndall::app
