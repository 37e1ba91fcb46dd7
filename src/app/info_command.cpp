// `tyndall info`: describes a file.
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "app/command.h"
#include "io/info.h"
#include "session/console.h"

namespace tyndall::app {
namespace {

struct InfoArguments {
  std::string file;
  bool as_json = false;
};

ExitCode run(const InfoArguments& arguments) {
  const io::Info info = io::info(arguments.file, arguments.as_json);
  session::print(info.text);
  if (!info.problem.empty()) throw Error(ExitCode::input_missing, info.problem);
  return ExitCode::done;
}

Run add(CLI::App& command) {
  const auto arguments = std::make_shared<InfoArguments>();
  command.add_option("FILE", arguments->file, ".vdb, .nvdb, .obj, .json, .tyn or an image")
      ->required()
      ->type_name("");
  command.add_flag("--json", arguments->as_json, "Prints JSON");
  return [arguments] { return run(*arguments); };
}

}  // namespace

const Command info_command{"info", "Describes a volume, mesh, scene, image or part", &add};

}  // namespace tyndall::app
