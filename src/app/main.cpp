// The command line: arguments in, exit code out (tyndall/render/error.h).
#include <malloc.h>

#include <csignal>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/failure.h"
#include "app/manual.h"
#include "app/outputs.h"
#include "app/ranks.h"
#include "render/startable_threads.h"
#include "session/console.h"
#include "session/signals.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall::app {
namespace {

constexpr const char* examples = R"(Examples:
  tyndall render cloud.json                          renders cloud.exr into the current folder
  tyndall render cloud.json -o cloud.exr -o cloud.png
  tyndall render cloud.json --photons 1e6 --samples 4 -D 'camera.resolution=[256,256]'
  tyndall validate cloud.json                        finds every error of a scene
  tyndall info smoke.vdb                             lists grids, and a component for a scene
  tyndall convert cloud.json -o cloud.py             the scene for Mitsuba 3; cloud.pbrt: for pbrt-v4
  tyndall render cloud.json --checkpoint cloud.tyn --resume     resumes after a crash or Ctrl-C
  tyndall merge a.tyn b.tyn -o cloud.exr             adds up parts (--sample-range A:B -o a.tyn)
  tyndall bake cloud.json -o light.vdb               the light for other programs, beside the density
  tyndall defaults                                   lists every key of a scene with its default

)";

std::string version() {
  std::string text = fmt::format("tyndall {}\narithmetic {}\npictures {}\ndevices cpu ({})",
                                 TYNDALL_VERSION, arithmetic_version, known_formats(),
#if TYNDALL_TBB
                                 "oneTBB"
#else
                                 "std::thread"
#endif
  );
#if TYNDALL_CUDA
  text += ", cuda";
#endif
  return text + "\n";
}

/// All commands, in the order of the help.
const Command* const commands[] = {&render_command,   &merge_command,  &bake_command,
                                   &validate_command, &info_command,   &convert_command,
                                   &devices_command,  &schema_command, &defaults_command};

/// `tyndall help`: the only command that depends on the others.
Run add_help(CLI::App& app) {
  CLI::App& help = *app.add_subcommand("help", "Prints this help, or that of a command");
  std::vector<std::string> names;
  for (const Command* command : commands) names.emplace_back(command->name);
  const auto topic = std::make_shared<std::string>(), format = std::make_shared<std::string>();
  help.add_option("COMMAND", *topic, "")->check(CLI::IsMember(names));
  help.add_option("--as", *format, "Prints a man page, or completions for bash or zsh")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"man", "bash", "zsh"}).description(""));
  return [&app, topic, format] {
    if (!format->empty()) {
      session::print(manual(app, *format, examples));
      return ExitCode::done;
    }
    app.clear();  // without this CLI11 prints the help of `help`
    session::print(examples
                   + (topic->empty() ? app.help() : app.get_subcommand(*topic)->help("tyndall")));
    return ExitCode::done;
  };
}

Run on_first_rank(const Run& run) {
  return [run] { return is_other_rank() ? ExitCode::done : run(); };
}

ExitCode run(int argc, char** argv) {
  CLI::App app("Tyndall renders clouds, smoke and fog by shooting photons through them.",
               "tyndall");
  app.set_version_flag("--version", version(), "Prints the version and the features of the build");
  app.require_subcommand(0, 1);
  std::map<std::string, Run> runs;
  for (const Command* command : commands) {
    const Run run = command->add(*app.add_subcommand(command->name, command->help));
    runs[command->name] = command->is_for_every_rank ? run : on_first_rank(run);
  }
  runs["help"] = on_first_rank(add_help(app));

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    session::print(examples + app.help());
    return ExitCode::done;
  } catch (const CLI::CallForVersion& call) {
    session::print(call.what());
    return ExitCode::done;
  } catch (const CLI::ParseError& error) {
    if (is_other_rank()) return ExitCode::usage;  // the first rank prints the message
    throw Error(ExitCode::usage, fmt::format("{} (see `tyndall help`)", error.what()));
  }

  if (app.get_subcommands().empty())
    throw Error(ExitCode::usage, "a command is missing (see `tyndall help`)");
  return runs.at(app.get_subcommands().front()->get_name())();
}

/// Under a memory limit, keeps malloc from reserving 64 MB of address space per thread.
void save_address_space() {
  if (is_memory_limited()) ::mallopt(M_ARENA_MAX, 1);
}

}  // namespace
}  // namespace tyndall::app

int main(int argc, char** argv) {
  using namespace tyndall;
  int code = 0;
  try {
    session::reserve_standard_streams();
    std::signal(SIGUSR1, SIG_IGN);  // until a render has begun, see expect_requests()
    std::signal(SIGXFSZ, SIG_IGN);  // so that write() fails for a file beyond the size limit
    app::save_address_space();
    code = static_cast<int>(app::run(argc, argv));
  } catch (...) {
    code = app::report_failure();
  }
  return session::end_catching(code);
}
