#include "app/bake_command.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "app/console.h"
#include "app/devices.h"
#include "app/memory.h"
#include "app/outputs.h"
#include "app/progress.h"
#include "app/signals.h"
#include "io/bake_file.h"
#include "io/output_file.h"
#include "io/report.h"
#include "io/scene_json.h"
#include "tyndall/render/bake.h"
#include "tyndall/render/error.h"

namespace tyndall::app {

ExitCode bake_command(const BakeArguments& arguments) {
  const io::BakeOptions options{arguments.half, arguments.voxels, arguments.threads};
  for (const std::string& path : arguments.outputs) io::require_bake(path, options);
  const DeviceName device_name = parse_device(arguments.device);
  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  refuse_inputs(file.inputs, arguments.outputs);
  for (const std::string& warning : file.warnings) warn(warning);
  const Scene scene = scene_to_bake(file.scene, arguments.order > 0, arguments.per_light);
  if (const std::string shortage = memory_shortage(scene, most_replicates); !shortage.empty())
    throw Error(ExitCode::out_of_memory, shortage);
  const Device device = open_device(device_name, arguments.threads);

  catch_signals(5.0);
  // Can they be written? What lies beside them can where they can.
  for (const std::string& path : arguments.outputs) io::OutputFile{path};

  ProgressMeter meter(progress_style(arguments.progress));
  std::atomic<bool> ends_in_order = false;
  RenderOptions render_options;
  render_options.photons = IndexRange{0, scene.photons};
  render_options.measures_matter = true;
  render_options.progress = [&](const Progress& progress) {
    ends_in_order = std::string_view(progress.pass) == "photons";
    meter.show(progress);
  };
  render_options.stop = [&] { return !ends_in_order && caught_signal() != 0; };
  render_options.pause = [] { return caught_signal() != 0; };
  render_options.go_on = [](Renderer&, Moment) { return caught_signal() == 0; };
  Renderer renderer(scene, *device.backend, render_options);
  const bool is_done = renderer.run();
  end_patience();
  meter.clear();
  const int signal = caught_signal();
  const std::uint64_t shot = renderer.part().photons().count();
  if (shot == 0) {
    if (signal != 0) throw Stopped{};
    throw Error(
        ExitCode::scene_invalid,
        fmt::format("{}: no light reaches the medium: there is nothing to bake", arguments.scene));
  }

  const RenderResult result = renderer.result();
  const BakedLight light = bake(renderer, scene);
  const io::Bake baked{arguments.scene, file, light, io::provenance(result)};
  say(io::report_lines({renderer.part(), result, arguments.scene, device.name, file.volumes}));
  for (const std::string& path : arguments.outputs) {
    // The file that was asked for comes last, once what it names is there.
    std::vector<io::ConvertedFile> files = io::bake_files(baked, path, options);
    std::rotate(files.begin(), files.begin() + 1, files.end());
    for (const io::ConvertedFile& part : files) {
      io::OutputFile output(part.path);
      output.write(part.bytes);
      output.commit();
      say(fmt::format("written  {}\n", part.path));
    }
  }
  if (is_done) return ExitCode::done;
  say(fmt::format("tyndall: stopped by a signal; what was written has {} of {} photons\n", shot,
                  scene.photons));
  return static_cast<ExitCode>(128 + signal);
}

}  // namespace tyndall::app
