// The command line: arguments in, exit code out (tyndall/render/error.h).
#include <malloc.h>

#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/bake_command.h"
#include "app/console.h"
#include "app/convert_command.h"
#include "app/devices.h"
#include "app/failure.h"
#include "app/frames_command.h"
#include "app/manual.h"
#include "app/memory.h"
#include "app/merge_command.h"
#include "app/outputs.h"
#include "app/ranks.h"
#include "app/render_command.h"
#include "app/signals.h"
#include "io/bake_file.h"
#include "io/convert.h"
#include "io/info.h"
#include "io/scene_json.h"
#include "render/startable_threads.h"
#include "tyndall/render/check.h"
#include "tyndall/render/error.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"

namespace tyndall::app {
namespace {

constexpr const char* examples = R"(Examples:
  tyndall render cloud.json                          renders cloud.exr into the current folder
  tyndall render cloud.json -o cloud.exr -o cloud.png
  tyndall render cloud.json --photons 1e6 --samples 4 -D 'camera.resolution=[256,256]'
  tyndall validate cloud.json                        finds every error of a scene
  tyndall info smoke.vdb                             lists grids, and what a scene writes to use them
  tyndall convert cloud.json -o cloud.py             the scene for Mitsuba 3; cloud.pbrt: for pbrt-v4
  tyndall render cloud.json --checkpoint cloud.tyn --resume     goes on after a crash or Ctrl-C
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

constexpr std::uint64_t most_count = std::numeric_limits<std::uint64_t>::max();

/// Takes a number of things from `least` to `most`, "2000000" or "2e6", and rewrites it as plain
/// digits.
CLI::Validator count(std::uint64_t most, const std::string& expected, std::uint64_t least = 0) {
  const auto rewrite = [=](std::string& text) -> std::string {
    const char* end = text.data() + text.size();
    std::uint64_t digits = 0;
    if (const auto [stop, error] = std::from_chars(text.data(), end, digits);
        error == std::errc() && stop == end && digits >= least && digits <= most)
      return "";
    double value = -1.0;
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    const bool whole = error == std::errc() && stop == end && value >= 0.0 && value < 0x1p64
                       && value == std::floor(value);
    if (!whole || static_cast<std::uint64_t>(value) > most
        || static_cast<std::uint64_t>(value) < least)
      return fmt::format("expected {}, got '{}'", expected, text);
    text = fmt::format("{}", static_cast<std::uint64_t>(value));
    return "";
  };
  return {rewrite, ""};
}

CLI::Validator count(std::uint64_t most = most_count, std::uint64_t least = 0) {
  return count(most, fmt::format("an integer in [{}, {}]", least, most), least);
}

CLI::Validator count(const Range& range) {
  return count(static_cast<std::uint64_t>(range.high), describe(range),
               static_cast<std::uint64_t>(range.low));
}

/// Takes a time, "90s", "5m", "1.5h" or "90", to seconds.
CLI::Validator duration(bool may_be_zero) {
  const auto rewrite = [=](std::string& text) -> std::string {
    const char* end = text.data() + text.size();
    double value = -1;
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    const std::string_view unit(stop, static_cast<std::size_t>(end - stop));
    const double scale = unit.empty() || unit == "s" ? 1
                         : unit == "m"               ? 60
                         : unit == "h"               ? 3600
                                                     : 0;
    if (error != std::errc() || scale == 0 || !(value >= 0 && value < 1e12)
        || (value == 0 && !may_be_zero))
      return fmt::format("expected a time {}such as 90s, 5m or 1.5h, got '{}'",
                         may_be_zero ? "" : "above 0 ", text);
    text = fmt::format("{}", value * scale);
    return "";
  };
  return {rewrite, ""};
}

/// Takes a share of a whole, such as 0.01 for 1 %.
CLI::Validator share() {
  const auto check = [](const std::string& text) -> std::string {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && stop == end && value > 0 && value < 1) return "";
    return fmt::format("expected a number above 0 and below 1, such as 0.01 for 1 %, got '{}'",
                       text);
  };
  return {check, ""};
}

/// Reads "A:B", whose numbers may be written as 2e6.
IndexRange read_range(const std::string& option, const std::string& text) {
  const std::size_t colon = text.find(':');
  std::string begin = text.substr(0, colon),
              end = colon == std::string::npos ? "" : text.substr(colon + 1);
  const CLI::Validator number = count();
  if (!number(begin).empty() || !number(end).empty() || std::stoull(begin) >= std::stoull(end)) {
    throw Error(ExitCode::usage,
                fmt::format("{}: expected A:B with A below B, the first and one beyond the last, "
                            "got '{}'",
                            option, text));
  }
  return {std::stoull(begin), std::stoull(end)};
}

/// Reads "A:B" or "A:B:STEP".
FrameRange read_frames(const std::string& text) {
  FrameRange range;
  int* const numbers[] = {&range.first, &range.last, &range.step};
  const char *at = text.data(), *end = at + text.size();
  int count = 0;
  while (count < 3) {
    const auto [stop, error] = std::from_chars(at, end, *numbers[count]);
    if (error != std::errc()) break;
    ++count;
    at = stop;
    if (at == end || *at != ':') break;
    ++at;
  }
  if (count == 1) range.last = range.first;
  if (text.find('-') != text.npos)
    throw Error(ExitCode::usage,
                fmt::format("--frames {}: frames are numbered from 0 on; number the files anew, or "
                            "write what depends on the frame with {{t}}",
                            text));
  if (at != end || text.ends_with(':') || count < 1 || range.first < 0 || range.last < range.first
      || range.step < 1 || range.last > 100000000) {
    throw Error(
        ExitCode::usage,
        fmt::format("--frames: expected A, A:B or A:B:STEP, the first and the last frame, got "
                    "'{}'",
                    text));
  }
  return range;
}

/// An option that sets the scene's `key`. CLI11 handles options in the order of their definition,
/// so these come after -D and win over it.
void add_override(CLI::App& command, const std::string& flags, const std::string& key,
                  const CLI::Validator& validator, std::vector<std::string>& overrides,
                  const std::string& help) {
  command
      .add_option_function<std::string>(
          flags,
          [&overrides, key](const std::string& count) { overrides.push_back(key + "=" + count); },
          help)
      ->transform(validator)
      ->type_name("N");
}

void add_scene(CLI::App& command, std::string& scene, std::vector<std::string>& overrides) {
  command.add_option("SCENE", scene, "Scene file (JSON)")->required()->type_name("");
  command
      .add_option("-D,--define", overrides, "Replaces a value of the scene, e.g. -D camera.fov=30")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
}

void add_frames(CLI::App& command, std::optional<FrameRange>& frames, const std::string& help) {
  command
      .add_option_function<std::string>(
          "--frames", [&frames](const std::string& text) { frames = read_frames(text); }, help)
      ->type_name("A[:B[:STEP]]");
}

/// Where it works, and what it shows of that.
void add_work(CLI::App& command, int& threads, std::string& device, std::string& progress) {
  command.add_option("-t,--threads", threads, "Threads (0: all of the machine's)")
      ->type_name("N")
      ->transform(count(4096));
  command
      .add_option(
          "--device", device,
          "auto (CUDA devices where there are any, else the processor), cpu, cuda (all) or cuda:N")
      ->type_name("NAME");
  command.add_option("--progress", progress, "auto (a bar on terminals), bar, plain or none")
      ->type_name("STYLE")
      ->check(CLI::IsMember({"auto", "bar", "plain", "none"}).description(""));
}

int run(int argc, char** argv) {
  CLI::App app("Tyndall renders clouds, smoke and fog by shooting photons through them.",
               "tyndall");
  app.set_version_flag("--version", version(), "Prints the version and what was compiled in");
  app.require_subcommand(0, 1);

  RenderArguments arguments;
  CLI::App* render = app.add_subcommand("render", "Renders a scene");
  add_scene(*render, arguments.scene, arguments.overrides);
  render
      ->add_option("-o,--output", arguments.outputs,
                   "Picture to write (" + known_formats() + "); may be repeated; SCENE's name "
                   "in the current folder if not given")
      ->type_name("FILE")
      ->allow_extra_args(false);
  add_override(*render, "--photons", "photons.count", count(limits::photons), arguments.overrides,
               "Photons to shoot");
  add_override(*render, "--samples", "gather.samples", count(limits::samples), arguments.overrides,
               "Samples per pixel");
  add_override(*render, "-s,--seed", "seed", count(), arguments.overrides,
               "Seed of the random numbers");
  add_work(*render, arguments.threads, arguments.device, arguments.progress);
  render->add_option("--batch", arguments.batch, "Photons or samples at a time; changes no result")
      ->type_name("N")
      ->transform(count());
  render->add_option("--report", arguments.report, "Writes the account of the run as JSON")
      ->type_name("FILE");
  render
      ->add_option("--detectors", arguments.detectors,
                   "Writes what the scene's detectors counted as JSON")
      ->type_name("FILE");
  render->add_flag("--print-hash", arguments.print_hash,
                   "Prints the hashes of tallies and pixels, equal on every machine");

  const auto add_range = [&](const char* flag, std::optional<IndexRange>& range, const char* help) {
    render
        ->add_option_function<std::string>(
            flag, [&range, flag](const std::string& text) { range = read_range(flag, text); }, help)
        ->type_name("A:B");
  };
  render
      ->add_option("--checkpoint", arguments.checkpoint,
                   "Keeps what is done in FILE while the render runs")
      ->type_name("FILE");
  render->add_option("--checkpoint-every", arguments.checkpoint_every, "How often (60s)")
      ->type_name("TIME")
      ->transform(duration(true));
  render->add_flag("--resume", arguments.resume, "Goes on from the checkpoint, where it is there");
  render
      ->add_option("--time-limit", arguments.time_limit,
                   "Ends the render after 90s, 5m or 1h with the picture so far")
      ->type_name("TIME")
      ->transform(duration(false));
  render
      ->add_option("--noise", arguments.noise,
                   "Ends it where the relative error by noise is below X, such as 0.01")
      ->type_name("X")
      ->check(share());
  add_range("--sample-range", arguments.samples, "These samples alone, of the whole picture");
  add_range("--photon-range", arguments.photons, "These photons alone; with -o FILE.tyn");
  render
      ->add_option("--illumination", arguments.illumination,
                   "Gathers from the light of this part and shoots nothing")
      ->type_name("FILE");
  render->add_flag("--allow-gaps", arguments.allow_gaps, "... even if photons are missing in it");
  render->add_flag("--denoise", arguments.denoises,
                   "Takes the noise out of the pictures, with Open Image Denoise");

  render
      ->add_option("--display", arguments.display,
                   "Shows the picture while it is made in the viewer tev")
      ->type_name("HOST:PORT");
  CLI::Option* const preview =
      render
          ->add_option("--preview", arguments.preview,
                       "Writes the picture while it is made, again and again")
          ->type_name("FILE");
  render->add_option("--every", arguments.preview_every, "How often (5s)")
      ->type_name("TIME")
      ->needs(preview)  // by name, CLI11 would not survive a lack of memory
      ->transform(duration(false));
  add_frames(*render, arguments.frames,
             "A sequence: ## in names, {frame} and {t} in the scene and -D are each frame's");
  render
      ->add_option("--turntable", arguments.turntable,
                   "The camera turns by so many degrees about what it looks at")
      ->type_name("DEGREES")
      ->check([](const std::string& text) -> std::string {
        char* end = nullptr;
        const double degrees = std::strtod(text.c_str(), &end);
        return *end == '\0' && std::isfinite(degrees) ? "" : "expected degrees, got '" + text + "'";
      });

  MergeArguments merging;
  CLI::App* merge = app.add_subcommand("merge", "Adds up parts of a render, exactly");
  merge->add_option("PART", merging.parts, "Parts (.tyn), in any order")->required()->type_name("");
  merge
      ->add_option("-o,--output", merging.outputs,
                   "Part or picture to write (" + known_formats() + "); may be repeated")
      ->required()
      ->type_name("FILE")
      ->allow_extra_args(false);
  merge->add_flag("--allow-gaps", merging.allow_gaps, "Makes a picture of what is there");
  merge->add_flag("--print-hash", merging.print_hash, "Prints the hashes of tallies and pixels");

  BakeArguments baking;
  CLI::App* bake = app.add_subcommand("bake", "Writes a scene's light for other programs");
  add_scene(*bake, baking.scene, baking.overrides);
  bake->add_option("-o,--output", baking.outputs,
                   "File to write (" + io::known_bakes() + "); may be repeated")
      ->required()
      ->type_name("FILE")
      ->allow_extra_args(false);
  add_override(*bake, "--photons", "photons.count", count(limits::photons), baking.overrides,
               "Photons to shoot");
  add_override(*bake, "-s,--seed", "seed", count(), baking.overrides, "Seed of the random numbers");
  bake->add_option("--order", baking.order,
                   "1: with the directions that light comes from; 0: without (1)")
      ->type_name("N")
      ->transform(count(1));
  bake->add_flag("--per-light", baking.per_light, "Each light by itself");
  bake->add_flag("--multiple-only", baking.multiple_only,
                 "Without what lights scatter once, for programs that add it");
  bake->add_flag("--half", baking.half, "Floats of 16 bits");
  bake->add_option("--voxels", baking.voxels,
                   fmt::format("Of the density, along its longest side ({}; 128 in pages)",
                               io::default_voxels))
      ->type_name("N")
      ->transform(count(io::most_voxels, io::least_voxels));
  add_work(*bake, baking.threads, baking.device, baking.progress);

  CLI::App* validate = app.add_subcommand("validate", "Finds every error of a scene");
  add_scene(*validate, arguments.scene, arguments.overrides);
  add_frames(*validate, arguments.frames, "The scenes of a sequence, each with its volumes");
  CLI::App* info =
      app.add_subcommand("info", "Tells what is in a volume, mesh, scene, image or part");
  std::string described;
  bool as_json = false;
  info->add_option("FILE", described, ".vdb, .nvdb, .obj, .json, .tyn or an image")
      ->required()
      ->type_name("");
  info->add_flag("--json", as_json, "The same as JSON");
  CLI::App* convert = app.add_subcommand("convert", "Writes a scene for pbrt-v4 or Mitsuba 3");
  ConvertArguments conversion;
  add_scene(*convert, conversion.scene, conversion.overrides);
  convert
      ->add_option("-o,--output", conversion.output,
                   "Scene to write: .pbrt, or .py for Mitsuba; grids lie beside it")
      ->required()
      ->type_name("FILE");
  conversion.voxels = io::default_voxels;
  convert
      ->add_option(
          "--voxels", conversion.voxels,
          fmt::format("Along the longest side of what is sampled ({})", io::default_voxels))
      ->type_name("N")
      ->transform(count(io::most_voxels, io::least_voxels));
  CLI::App* devices = app.add_subcommand("devices", "Lists what can render");
  CLI::App* schema = app.add_subcommand("schema", "Prints the JSON Schema of scenes");
  CLI::App* defaults =
      app.add_subcommand("defaults", "Prints every key of a scene with its default");
  CLI::App* help = app.add_subcommand("help", "Prints this help, or that of a command");
  std::string topic;
  help->add_option("COMMAND", topic, "")
      ->check(CLI::IsMember({"render", "merge", "bake", "validate", "info", "convert", "devices",
                             "schema", "defaults"}));

  std::string manual_format;
  help->add_option("--as", manual_format,
                   "All of it as man (a page), or completions of bash or zsh")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"man", "bash", "zsh"}).description(""));

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print(examples + app.help());
    return 0;
  } catch (const CLI::CallForVersion& call) {
    print(call.what());
    return 0;
  } catch (const CLI::ParseError& error) {
    if (is_other_rank()) return static_cast<int>(ExitCode::usage);  // the first one says it
    throw Error(ExitCode::usage, fmt::format("{} (see `tyndall help`)", error.what()));
  }

  if (app.get_subcommands().empty())
    throw Error(ExitCode::usage, "a command is missing (see `tyndall help`)");
  if (*render && arguments.turntable != 0 && !arguments.frames)
    throw Error(ExitCode::usage, "--turntable: wants --frames A:B");
  if (*render && arguments.frames && is_rank())
    throw Error(ExitCode::usage, "--frames: not under mpirun; give each machine frames of its own");
  if (*render && arguments.frames) return static_cast<int>(frames_command(arguments));
  if (*render) return static_cast<int>(render_command(arguments));
  if (is_other_rank()) return 0;
  if (*bake) return static_cast<int>(bake_command(baking));
  if (*merge) merge_command(merging);
  if (*validate && arguments.frames) return static_cast<int>(validate_frames(arguments));
  if (*validate) {
    const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
    for (const std::string& warning : file.warnings) warn(warning);
    // The scene is none the worse for it: another machine may render it.
    const std::string shortage = memory_shortage(file.scene);
    if (!shortage.empty()) warn(shortage);
    if (shortage.empty())
      for (const std::string& warning : lights_that_give_nothing(file.scene)) warn(warning);
    print(fmt::format("{}: valid\n", arguments.scene));
  }
  if (*info) {
    const io::Info told = io::info(described, as_json);
    print(told.text);
    if (!told.problem.empty()) throw Error(ExitCode::input_missing, told.problem);
  }
  if (*convert) convert_command(conversion);
  if (*devices) print(list_devices());
  if (*schema) print(io::schema());
  if (*defaults) print(io::defaults());
  if (*help && !manual_format.empty()) {
    print(manual(app, manual_format, examples));
  } else if (*help) {
    app.clear();  // else CLI11 gives the help of `help`
    print(examples + (topic.empty() ? app.help() : app.get_subcommand(topic)->help("tyndall")));
  }
  return 0;
}

/// Where there is little, each thread does not reserve 64 MB of it for its allocations.
void save_address_space() {
  if (is_memory_limited()) ::mallopt(M_ARENA_MAX, 1);
}

}  // namespace
}  // namespace tyndall::app

int main(int argc, char** argv) {
  using namespace tyndall;
  int code = 0;
  try {
    app::reserve_standard_streams();
    std::signal(SIGUSR1, SIG_IGN);  // a render takes it once it has begun, see expect_requests()
    std::signal(SIGXFSZ, SIG_IGN);  // a file that grows beyond its limit is an error of writing
    app::save_address_space();
    code = app::run(argc, argv);
  } catch (...) {
    code = app::tell_failure();
  }
  return app::end_catching(code);
}
