#include "app/convert_command.h"

#include <fmt/format.h>

#include "app/console.h"
#include "app/render_command.h"
#include "io/convert.h"
#include "io/output_file.h"

namespace tyndall::app {

void convert_command(const ConvertArguments& arguments) {
  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  for (const std::string& warning : file.warnings) warn(warning);
  const std::vector<io::ConvertedFile> converted =
      io::convert(file, arguments.output, arguments.voxels);
  std::vector<std::string> paths;
  for (const io::ConvertedFile& part : converted) paths.push_back(part.path);
  refuse_inputs(file.inputs, paths);
  // The scene comes last, once what it reads is there.
  for (auto part = converted.rbegin(); part != converted.rend(); ++part) {
    io::OutputFile output(part->path);
    output.write(part->bytes);
    output.commit();
    say(fmt::format("written  {}\n", part->path));
  }
}

}  // namespace tyndall::app
