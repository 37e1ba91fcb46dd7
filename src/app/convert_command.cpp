#include "app/convert_command.h"

#include <fmt/format.h>

#include "app/console.h"
#include "app/outputs.h"
#include "app/signals.h"
#include "io/convert.h"
#include "io/output_file.h"

namespace tyndall::app {

void convert_command(const ConvertArguments& arguments) {
  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  for (const std::string& warning : file.warnings) warn(warning);
  catch_signals();  // from here on there are temporaries
  leave_on_signal();
  io::OutputFile scene(arguments.output);  // can it be written at all?
  const std::vector<io::ConvertedFile> converted =
      io::convert(file, arguments.output, arguments.voxels);
  std::vector<std::string> paths;
  for (const io::ConvertedFile& part : converted) paths.push_back(part.path);
  refuse_inputs(file.inputs, paths);
  const auto write = [](io::OutputFile& output, const std::string& bytes) {
    output.write(bytes);
    output.commit();
    say(fmt::format("written  {}\n", output.path()));
  };
  // The scene comes last, once what it reads is there.
  for (std::size_t i = 1; i < converted.size(); ++i) {
    io::OutputFile grid(converted[i].path);
    write(grid, converted[i].bytes);
  }
  write(scene, converted[0].bytes);
}

}  // namespace tyndall::app
