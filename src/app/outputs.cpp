#include "app/outputs.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/detectors.h"
#include "io/pfm.h"
#include "session/console.h"
#include "session/refuse.h"
#include "tyndall/render/error.h"
#if TYNDALL_OPENEXR
#include "io/exr.h"
#endif
#if TYNDALL_ZLIB
#include "io/png.h"
#endif
#if TYNDALL_ZSTD
#include "io/part_file.h"
#endif

namespace tyndall::app {
namespace {

namespace fs = std::filesystem;

using session::usage_error;

struct Format {
  const char* extension;
  Writer (*make_writer)();
};

const Format formats[] = {
#if TYNDALL_OPENEXR
    {".exr",
     []() -> Writer {
       return [](const io::Run& run, io::OutputFile& file) {
         file.write(io::encode_exr(run.result.picture));
       };
     }},
#endif
#if TYNDALL_ZLIB
    {".png",
     []() -> Writer {
       return [](const io::Run& run, io::OutputFile& file) {
         file.write(io::encode_png(run.result.picture, run.result.frame.exposure));
       };
     }},
#endif
    {".pfm",
     []() -> Writer {
       return [](const io::Run& run, io::OutputFile& file) {
         file.write(io::encode_pfm(run.result.picture));
       };
     }},
#if TYNDALL_ZSTD
    {".tyn",
     []() -> Writer {
       return [](const io::Run& run, io::OutputFile& file) {
         const Partial& part = run.part;
         const bool is_light =
             part.film.pixels.empty() && part.measured[measurement::scattering].words.empty();
         if (is_light && part.slice.replicate < 0) return io::write_part(part, file);  // no copy
         io::write_part(without_light(part), file);
       };
     }},
#endif
};

}  // namespace

std::string extension_of(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void Outputs::add(const std::string& path) {
  const std::string extension = extension_of(path);
  for (const Format& format : formats)
    if (extension == format.extension) return add(path, format.make_writer());
  usage_error(fmt::format("{}: this build writes no '{}' pictures, only {}", path, extension,
                          known_formats()));
}

void Outputs::add(const std::string& path, Writer writer) {
  outputs_.push_back({path, std::move(writer), std::nullopt});
}

void Outputs::add_reports(const std::string& report, const std::string& detectors) {
  if (!report.empty())
    add(report, [](const io::Run& run, io::OutputFile& file) { file.write(io::report_json(run)); });
  if (!detectors.empty())
    add(detectors,
        [](const io::Run& run, io::OutputFile& file) { file.write(io::detectors_json(run)); });
}

std::vector<std::string> Outputs::distinct_paths(const std::vector<std::string>& others) const {
  std::vector<std::string> paths;
  for (const Output& output : outputs_) paths.push_back(output.path);
  for (const std::string& path : others)
    if (!path.empty()) paths.push_back(path);
  session::refuse_repeats(paths);
  return paths;
}

void Outputs::open() {
  for (Output& output : outputs_) output.file.emplace(output.path);
}

void Outputs::write(const io::Run& run, bool says) {
  std::string failures;
  for (Output& output : outputs_) {
    try {
      // Another program may have removed the temporary; the picture is written all the same.
      if (!output.file || !output.file->is_there()) output.file.emplace(output.path);
      output.writer(run, *output.file);
      output.file->commit();
      if (says) session::say(fmt::format("written  {}\n", output.path));
    } catch (const Error& error) {
      failures += (failures.empty() ? "" : "\n") + std::string(error.what());
    }
    output.file.reset();
  }
  if (!failures.empty()) throw Error(ExitCode::output_failed, failures);
}

std::string known_formats() {
  std::vector<std::string> names;
  for (const Format& format : formats) names.push_back(format.extension);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string default_extension() { return formats[0].extension; }

bool is_part(const std::string& path) { return extension_of(path) == ".tyn"; }

void require_detectors(const Scene& scene, const std::string& detectors) {
  if (!detectors.empty() && !detects(scene)) {
    usage_error(
        scene.integrator == scene::Integrator::path
            ? fmt::format("--detectors {}: they count photons, and the integrator path shoots none",
                          detectors)
            : fmt::format("--detectors {}: the scene has none; add \"detectors\" to it, such as "
                          "-D detectors.flux=[64,64]",
                          detectors));
  }
  if (detects(scene) && detectors.empty())
    session::warn("the scene's detectors are written nowhere: add --detectors FILE");
}

void print_hashes(const RenderResult& result, const std::string& prefix) {
  session::print(fmt::format("{}tallies {:016x} pixels {:016x}\n", prefix, result.hashes.tallies,
                             result.hashes.pixels));
}

}  // namespace tyndall::app
