#include "app/render_command.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <functional>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/console.h"
#include "app/memory.h"
#include "app/progress.h"
#include "app/signals.h"
#include "io/detectors.h"
#include "io/output_file.h"
#include "io/pfm.h"
#include "io/report.h"
#include "io/scene_json.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/check.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"
#if TYNDALL_OPENEXR
#include "io/exr.h"
#endif
#if TYNDALL_OPENIMAGEIO
#include "io/png.h"
#endif

namespace tyndall::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void usage_error(const std::string& message) { throw Error(ExitCode::usage, message); }

// ---- Picture formats. ----

using Encoder = std::function<std::string(const io::Run&)>;

struct Format {
  const char* extension;
  Encoder (*make_encoder)();  // finds out whether it can work
};

const Format formats[] = {
#if TYNDALL_OPENEXR
    {".exr",
     []() -> Encoder {
       return [](const io::Run& run) { return io::encode_exr(run.result.picture); };
     }},
#endif
#if TYNDALL_OPENIMAGEIO
    {".png",
     []() -> Encoder {
       return [png = io::PngEncoder()](const io::Run& run) {
         return png.encode(run.result.picture, run.scene.exposure);
       };
     }},
#endif
    {".pfm",
     []() -> Encoder {
       return [](const io::Run& run) { return io::encode_pfm(run.result.picture); };
     }},
};

const Format& format_of(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Format& format : formats)
    if (extension == format.extension) return format;
  usage_error(fmt::format("{}: this build writes no '{}' pictures, only {}", path, extension,
                          known_formats()));
}

std::string default_output(const std::string& scene) {
  return fs::path(scene).stem().string() + formats[0].extension;
}

/// No output may replace another.
void refuse_repeats(const std::vector<std::string>& outputs) {
  std::vector<fs::path> places;
  for (const std::string& path : outputs) {
    std::error_code error;
    fs::path place = fs::weakly_canonical(fs::absolute(path), error);
    if (!error && std::find(places.begin(), places.end(), place) != places.end())
      usage_error(fmt::format("{}: is asked for twice", path));
    places.push_back(std::move(place));
  }
}

// ---- Devices. ----

struct DeviceName {
  bool cuda = false;
  int index = 0;

  std::string text() const { return cuda ? fmt::format("cuda:{}", index) : "cpu"; }
};

DeviceName parse_device(const std::string& text) {
  if (text == "cpu") return {};
  if (text == "cuda") return {true, 0};
  DeviceName device{true, 0};
  const char* end = text.data() + text.size();
  if (text.rfind("cuda:", 0) == 0) {
    const auto [stop, error] = std::from_chars(text.data() + 5, end, device.index);
    if (error == std::errc() && stop == end && device.index >= 0) return device;
  }
  usage_error(fmt::format("--device: expected cpu, cuda or cuda:N, got '{}'", text));
}

std::unique_ptr<Backend> make_backend(const DeviceName& device, int threads) {
  if (!device.cuda) return make_cpu_backend(threads);
#if TYNDALL_CUDA
  return make_cuda_backend(device.index);
#else
  throw Error(ExitCode::device,
              fmt::format("--device {}: this build has no CUDA; use --device cpu", device.text()));
#endif
}

// ---- One run. ----

ProgressStyle progress_style(const std::string& name) {
  if (name == "bar") return ProgressStyle::bar;
  if (name == "plain") return ProgressStyle::plain;
  return name == "auto" && ::isatty(STDERR_FILENO) == 1 ? ProgressStyle::bar : ProgressStyle::none;
}

RenderResult render_with_progress(const Scene& scene, Backend& backend,
                                  const RenderArguments& arguments) {
  ProgressMeter meter(progress_style(arguments.progress));
  RenderOptions options;
  options.batch = arguments.batch;
  options.progress = [&](const Progress& progress) { meter.show(progress); };
  options.stop = [] { return caught_signal() != 0; };
  return render(scene, backend, options);
}

struct Output {
  io::OutputFile file;
  Encoder encode;
};

/// Writes every output that can be written, and fails afterwards where one could not: the others
/// may hold hours of work.
void write_outputs(std::vector<Output>& outputs, const io::Run& run) {
  std::string failures;
  for (Output& output : outputs) {
    try {
      output.file.write(output.encode(run));
      output.file.commit();
      say(fmt::format("written  {}\n", output.file.path()));
    } catch (const Error& error) {
      failures += (failures.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  if (!failures.empty()) throw Error(ExitCode::output_failed, failures);
}

}  // namespace

std::string known_formats() {
  std::vector<std::string> names;
  for (const Format& format : formats) names.push_back(format.extension);
  return fmt::format("{}", fmt::join(names, ", "));
}

void refuse_inputs(const std::vector<std::string>& inputs,
                   const std::vector<std::string>& outputs) {
  for (const std::string& path : outputs) {
    for (const std::string& input : inputs) {
      std::error_code error;
      if (!fs::equivalent(input, path, error)) continue;
      const bool scene = input == inputs.front();
      usage_error(fmt::format("{}: is {}", path, scene ? "the scene itself" : "read by the scene"));
    }
  }
}

void render_command(const RenderArguments& arguments) {
  // Whatever can be wrong comes to light before the work begins: first the command line, then the
  // scene, then the machine.
  std::vector<std::string> paths = arguments.outputs;
  if (paths.empty()) paths.push_back(default_output(arguments.scene));
  std::vector<Encoder (*)()> encoders;
  for (const std::string& path : paths) encoders.push_back(format_of(path).make_encoder);
  const DeviceName device = parse_device(arguments.device);
  if (!arguments.report.empty()) {
    paths.push_back(arguments.report);
    encoders.push_back([]() -> Encoder { return io::report_json; });
  }
  if (!arguments.detectors.empty()) {
    paths.push_back(arguments.detectors);
    encoders.push_back([]() -> Encoder { return io::detectors_json; });
  }
  refuse_repeats(paths);

  const auto [scene, warnings, inputs, volumes] =
      io::read_scene(arguments.scene, arguments.overrides);
  refuse_inputs(inputs, paths);
  for (const std::string& warning : warnings) warn(warning);
  if (!arguments.detectors.empty() && !detects(scene)) {
    usage_error(
        fmt::format("--detectors {}: the scene has none; add \"detectors\" to it, such as "
                    "-D detectors.flux=[64,64]",
                    arguments.detectors));
  }
  if (detects(scene) && arguments.detectors.empty())
    warn("the scene's detectors are written nowhere: add --detectors FILE");
  if (const std::string shortage = memory_shortage(scene); !shortage.empty())
    throw Error(ExitCode::out_of_memory, shortage);
  const std::unique_ptr<Backend> backend = make_backend(device, arguments.threads);

  catch_signals();  // from here on there are temporaries
  std::vector<Output> outputs;
  for (std::size_t i = 0; i < paths.size(); ++i)
    outputs.push_back({io::OutputFile(paths[i]), encoders[i]()});

  RenderResult result = render_with_progress(scene, *backend, arguments);
  leave_on_signal();
  if (caught_signal() != 0) throw Stopped{};

  result.picture.provenance = io::provenance(scene, result);
  // render() checks the scene too; what was said with its place in the file need not be said again.
  for (const std::string& warning : result.warnings)
    if (std::none_of(warnings.begin(), warnings.end(),
                     [&](const auto& said) { return said.ends_with(warning); }))
      warn(warning);
  const io::Run run{scene, result, arguments.scene, device.text(), volumes};
  say(io::report_lines(run));
  write_outputs(outputs, run);
  if (arguments.print_hash)
    print(fmt::format("tallies {:016x} pixels {:016x}\n", result.hashes.tallies,
                      result.hashes.pixels));
}

}  // namespace tyndall::app
