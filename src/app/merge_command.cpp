#include "app/merge_command.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/options.h"
#include "app/outputs.h"
#include "session/console.h"
#include "session/memory.h"
#include "session/refuse.h"
#include "session/signals.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"
#if TYNDALL_ZSTD
#include "io/part_file.h"
#endif

namespace tyndall::app {

void refuse_gaps(const Partial& part, const std::string& name, bool allowed, Needs needs) {
  std::string gaps;
  if (const Ranges photons = part.photons().missing({0, part.frame.photons}); !photons.empty())
    gaps += fmt::format("photons {}", photons.text());
  if (needs == Needs::all) {
    const Ranges samples = part.samples().missing({0, part.frame.samples});
    if (!samples.empty())
      gaps += fmt::format("{}samples {}", gaps.empty() ? "" : " and ", samples.text());
  }
  if (gaps.empty()) return;
  const std::string problem = fmt::format("{}: lacks {} of the render", name, gaps);
  Ranges cut;  // missing photons of replicates whose light samples have read: it cannot change
  for (std::size_t r = 0; r < part.replicates.size(); ++r) {
    const Replicate& replicate = part.replicates[r];
    if (!replicate.samples.empty())
      cut.add(replicate.photons.missing(part.frame.photons_of(static_cast<int>(r))));
  }
  if (!allowed) {
    const std::string remedy =
        cut.empty() ? "; add the parts that have them, or accept the gaps with --allow-gaps"
                    : fmt::format(
                        "; samples have read the light without photons {}, so no part can add "
                        "them: finish the render of these samples, or use --allow-gaps",
                        cut.text());
    throw Error(ExitCode::input_missing, problem + remedy);
  }
  session::warn(problem);
}

namespace {

struct MergeArguments {
  std::vector<std::string> parts;
  std::vector<std::string> outputs;  ///< parts (.tyn) or pictures
  bool allow_gaps = false;
  bool print_hash = false;
};

#if TYNDALL_ZSTD
void add_to(Partial& sum, const std::string& name, const std::string& path) {
  Partial part = io::read_part(path, session::available_memory());
  if (const Ranges twice = shot_twice(sum, part); !twice.empty()) {
    throw Error(ExitCode::input_missing,
                fmt::format("{}: cannot be merged with {}: both have photons {}", path, name,
                            twice.text()));
  }
  if (part.frame.exposure != sum.frame.exposure) {
    session::warn(
        fmt::format("{}: preview.exposure is {} there, {} in {}; previews have the larger one",
                    path, part.frame.exposure, sum.frame.exposure, name));
  }
  merge(sum, name, std::move(part), path);
}

/// \return the sum of all parts. \throws Error that names two files that cannot be merged
Partial sum_of(const std::vector<std::string>& paths) {
  Partial sum = io::read_part(paths[0], session::available_memory());
  for (std::size_t i = 1; i < paths.size(); ++i) {
    try {
      add_to(sum, "the parts before it", paths[i]);
    } catch (const Error&) {
      sum = {};
      for (std::size_t k = 0; k < i; ++k) {  // finds the file that paths[i] cannot be merged with
        Partial other = io::read_part(paths[k], session::available_memory());
        add_to(other, paths[k], paths[i]);
      }
      throw;
    }
  }
  return sum;
}
#endif

ExitCode run(const MergeArguments& arguments) {
#if TYNDALL_ZSTD
  Outputs outputs;
  for (const std::string& path : arguments.outputs) outputs.add(path);
  session::refuse_inputs(arguments.parts, outputs.distinct_paths(), "one of the parts",
                         "one of the parts");
  session::catch_signals();
  session::leave_on_signal();
  outputs.open();
  const Partial sum = sum_of(arguments.parts);
  const std::size_t others = arguments.parts.size() - 1;
  const std::string name =
      arguments.parts[0] + (others == 0 ? "" : fmt::format(" and {} more", others));
  const std::vector<std::string>& paths = arguments.outputs;
  if (!std::all_of(paths.begin(), paths.end(), is_part)) {
    if (sum.film.pixels.empty()) {
      throw Error(ExitCode::input_missing,
                  fmt::format("{}: photons alone make no picture; merge them into a part for "
                              "`tyndall render --illumination`",
                              name));
    }
    refuse_gaps(sum, name, arguments.allow_gaps, Needs::all);
  }
  for (const Replicate& r : sum.replicates) {
    if (sum.film.pixels.empty() || r.photons.empty() || !r.samples.empty()) continue;
    throw Error(
        ExitCode::input_missing,
        fmt::format("{}: no samples read the light of photons {}, so it would be lost; merge "
                    "photons and samples separately",
                    name, r.photons.text()));
  }
  RenderResult result = develop(sum);
  result.picture.provenance = io::provenance(result);
  for (const std::string& warning : result.warnings) session::warn(warning);
  session::say(fmt::format("merged   {} parts: photons {}, samples {}\n", arguments.parts.size(),
                           result.photons.text(), result.samples.text()));
  outputs.write({sum, result, name, "merged", {}});
  if (arguments.print_hash) print_hashes(result);
  return ExitCode::done;
#else
  static_cast<void>(arguments);
  throw Error(ExitCode::usage, "this build merges no parts (TYNDALL_ZSTD is off)");
#endif
}

Run add(CLI::App& command) {
  const auto arguments = std::make_shared<MergeArguments>();
  command.add_option("PART", arguments->parts, "Parts (.tyn), in any order")
      ->required()
      ->type_name("");
  command
      .add_option("-o,--output", arguments->outputs,
                  "Part or picture to write (" + known_formats() + "); may be repeated")
      ->required()
      ->type_name("FILE")
      ->allow_extra_args(false);
  command.add_flag("--allow-gaps", arguments->allow_gaps, "Allows missing photons and samples");
  command.add_flag("--print-hash", arguments->print_hash,
                   "Prints the hashes of tallies and pixels");
  return [arguments] { return run(*arguments); };
}

}  // namespace

const Command merge_command{"merge", "Adds up parts of a render, exactly", &add};

}  // namespace tyndall::app
