// `tyndall render`: reads a scene, renders it, writes the outputs.
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/failure.h"
#include "app/frames.h"
#include "app/live.h"
#include "app/merge_command.h"
#include "app/options.h"
#include "app/outputs.h"
#include "app/ranks.h"
#include "app/render_arguments.h"
#include "io/denoise.h"
#include "io/detectors.h"
#include "io/output_file.h"
#include "io/report.h"
#include "io/scene_json.h"
#include "session/memory.h"
#include "session/refuse.h"
#include "session/session.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"
#if TYNDALL_ZSTD
#include "io/part_file.h"
#endif

namespace tyndall::app {
namespace {

namespace fs = std::filesystem;

using session::usage_error;

constexpr double preview_seconds = 5;

std::string default_output(const std::string& scene) {
  return fs::path(scene).stem().string() + default_extension();
}

/// Rejects ranges beyond the scene's counts: they would give an empty part.
void refuse_ranges_beyond(const Scene& scene, const RenderArguments& arguments) {
  const auto refuse = [](const char* option, const std::optional<IndexRange>& range,
                         std::uint64_t count, const char* key) {
    if (!range || range->end <= count) return;
    usage_error(fmt::format("{} {}:{}: the scene has {} ({})", option, range->begin, range->end,
                            count, key));
  };
  if (arguments.photons && scene.integrator == scene::Integrator::path)
    usage_error("--photon-range: paths (integrator \"path\") shoot no photons");
  refuse("--photon-range", arguments.photons, scene.photons, "photons.count");
  refuse("--sample-range", arguments.samples, scene.samples, "gather.samples");
}

/// \return the number of replicates whose light is held at once: all that --photon-range covers if
/// the part has photons only, else 1.
int lights_kept(const Scene& scene, const RenderArguments& arguments) {
  if (!arguments.photons || arguments.samples) return 1;
  Frame frame;
  frame.photons = scene.photons;
  frame.replicates = replicate_count(scene.photons, scene.samples);
  int lights = 0;
  for (int r = 0; r < frame.replicates; ++r) {
    const IndexRange all = frame.photons_of(r);
    lights += all.begin < arguments.photons->end && arguments.photons->begin < all.end;
  }
  return std::max(lights, 1);
}

/// \return the number of replicates whose light is held at once, so that a limit can end the render
/// after any samples.
int lights_at_once(const ResolvedScene& scene, const RenderArguments& arguments) {
  const bool is_limited = arguments.noise > 0 || arguments.time_limit > 0;
  if (!is_limited || (arguments.photons && !arguments.samples)) return 1;
  if (scene->integrator == scene::Integrator::path) return most_replicates;
  int lights = most_replicates;
  while (lights > 1 && !session::memory_shortage(scene, lights).empty()) --lights;
  if (lights == 1) {
    session::warn(
        "the light of two replicates does not fit into memory: they are rendered one after the "
        "other, and a limit ends the render late; lower photons.illumination.resolution");
  }
  return lights;
}

// ---- One run. ----

/// Serves a viewer, a preview, a checkpoint and SIGUSR1 while a render runs.
class Watch {
 public:
  /// \param control must outlive the watch
  Watch(const RenderArguments& arguments, session::RunControl& control,
        const std::function<void(RenderResult&)>& show)
      : arguments_(arguments), control_(control), show_(show) {
    if (!arguments.display.empty())
      display_.emplace(arguments.display, fs::path(arguments.scene).filename().string());
    control.time_limit = arguments.time_limit;
    control.noise = arguments.noise;
    control.look = [this](Renderer& renderer) { look(renderer); };
  }

  void write_checkpoint(Renderer& renderer) {
#if TYNDALL_ZSTD
    io::OutputFile file(arguments_.checkpoint);
    io::write_part(renderer.part(), file);
    file.commit();
#else
    static_cast<void>(renderer);
#endif
    written_ = Clock::now();
  }

  /// Shows the final picture in the viewer and writes it to the preview.
  void show_last(Renderer& renderer, const RenderResult& result) {
    if (!renderer.has_picture() && !result.is_preview) return;  // photons only
    if (display_) display_->show(result.picture);
    if (!arguments_.preview.empty()) write_preview(renderer, result);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void look(Renderer& renderer) {
    const bool can_show = renderer.has_picture() || renderer.has_preview();
    if (can_show && session::take_request_for_picture()) {
      control_.clear();
      try {
        RenderResult result =
            renderer.has_picture() ? renderer.result() : renderer.preview(preview_seconds);
        show_(result);
      } catch (const Error& error) {
        session::warn(error.what());  // the render goes on
      }
    }
    if (renderer.has_picture()) show_now_and_then(renderer);
    const double age = std::chrono::duration<double>(Clock::now() - written_).count();
    if (arguments_.checkpoint.empty() || age < arguments_.checkpoint_every) return;
    try {
      write_checkpoint(renderer);
    } catch (const Error& error) {
      control_.clear();
      session::warn(fmt::format("{} (the render goes on, and tries again later)", error.what()));
      written_ = Clock::now();
    }
  }

  /// Shows and writes the picture periodically, in at most a twentieth of the time.
  void show_now_and_then(Renderer& renderer) {
    if (!display_ && arguments_.preview.empty()) return;
    const auto start = Clock::now();
    const bool displays = display_ && start >= display_next_;
    const bool writes = !arguments_.preview.empty() && start >= preview_next_;
    if (!displays && !writes) return;
    const RenderResult result = renderer.result();
    if (displays) display_->show(result.picture);
    if (writes) write_preview(renderer, result);
    const auto next = [&](double every) {
      const double took = std::chrono::duration<double>(Clock::now() - start).count();
      return Clock::now()
             + std::chrono::duration_cast<Clock::duration>(
                 std::chrono::duration<double>(std::max(every, 20 * took)));
    };
    if (displays) display_next_ = next(1);
    if (writes) preview_next_ = next(arguments_.preview_every);
  }

  void write_preview(Renderer& renderer, const RenderResult& result) {
    try {
      Outputs outputs;
      outputs.add(arguments_.preview);
      outputs.open();
      outputs.write({renderer.part(), result, arguments_.scene, "", {}}, false);
    } catch (const Error& error) {
      control_.clear();
      session::warn(fmt::format("{} (the render goes on)", error.what()));
    }
  }

  const RenderArguments& arguments_;
  session::RunControl& control_;
  const std::function<void(RenderResult&)> show_;
  std::optional<Display> display_;
  std::chrono::steady_clock::time_point display_next_{}, preview_next_{};
  Clock::time_point written_ = Clock::now();
};

/// \return the options of the render, under `control`.
RenderOptions options_of(const RenderArguments& arguments, const ResolvedScene& scene,
                         session::RunControl& control) {
  RenderOptions options = control.options();
  options.batch = arguments.batch;
  options.photons = arguments.photons;
  options.samples = arguments.samples;
  if (!arguments.illumination.empty()) {
    options.photons = {0, 0};
    if (!options.samples) options.samples = {0, std::numeric_limits<std::uint64_t>::max()};
  }
  options.allow_gaps = arguments.allow_gaps;
  options.most_lights = lights_at_once(scene, arguments);
  return options;
}

/// Loads the parts of --resume and --illumination.
void take_up(const RenderArguments& arguments, Renderer& renderer) {
#if TYNDALL_ZSTD
  if (!arguments.illumination.empty()) {
    Partial light = io::read_part(arguments.illumination, session::available_memory());
    refuse_gaps(light, arguments.illumination, arguments.allow_gaps, Needs::photons);
    renderer.resume(std::move(light), arguments.illumination);
  }
  if (!arguments.resume) return;
  if (std::error_code error; !fs::exists(arguments.checkpoint, error)) {
    session::say(fmt::format("resume   {} does not exist yet: starts from the beginning\n",
                             arguments.checkpoint));
    return;
  }
  renderer.resume(io::read_part(arguments.checkpoint, session::available_memory()),
                  arguments.checkpoint);
  const Partial& part = renderer.part();
  std::uint64_t photons = 0;
  for (const Replicate& r : part.replicates) photons += r.photons.count();
  session::say(fmt::format("resume   {}: {} of {} photons, {} of {} samples are done\n",
                           arguments.checkpoint, photons, part.frame.photons,
                           part.samples().count(), part.frame.samples));
#else
  static_cast<void>(arguments), static_cast<void>(renderer);
#endif
}

void require_sense(const RenderArguments& arguments, const std::vector<std::string>& outputs) {
  if (arguments.denoises) io::require_denoiser();
#if !TYNDALL_ZSTD
  if (!arguments.checkpoint.empty() || !arguments.illumination.empty())
    usage_error("this build reads and writes no checkpoints and no parts (TYNDALL_ZSTD is off)");
#endif
  if (arguments.resume && arguments.checkpoint.empty())
    usage_error("--resume: --checkpoint FILE is missing");
  // If the look-up fails, so will opening the checkpoint, which reports it.
  if (std::error_code error; !arguments.checkpoint.empty() && !arguments.resume
                             && fs::exists(arguments.checkpoint, error)) {
    usage_error(fmt::format("{}: is there already; add --resume to go on from it, or remove it",
                            arguments.checkpoint));
  }
  if (arguments.photons && !arguments.illumination.empty())
    usage_error("--photon-range and --illumination: one shoots photons, the other reads them");
  if (!arguments.photons || arguments.samples) return;
  for (const std::string& path : outputs)
    if (!is_part(path))
      usage_error(
          fmt::format("{}: photons alone make no picture; name a part with -o FILE.tyn, or "
                      "add --sample-range",
                      path));
}

// ---- Many processes.

/// The signal to the other ranks whether to work: only rank 0 checks the command and the scene.
class Go {
 public:
  explicit Go(Communicator* ranks) : ranks_(ranks) {}
  ~Go() {
    if (!is_given_) send(false);
  }
  Go(const Go&) = delete;
  Go& operator=(const Go&) = delete;
  void give() {
    send(true);
    is_given_ = true;
  }
  bool is_given() const { return is_given_; }

  /// \return the signal of rank 0.
  static bool receive(Communicator& ranks) {
    char go = 0;
    ranks.broadcast(&go, 1);
    return go != 0;
  }

 private:
  void send(bool yes) {
    char go = yes ? 1 : 0;
    if (ranks_) ranks_->broadcast(&go, 1);
  }

  Communicator* const ranks_;
  bool is_given_ = false;
};

/// \return the threads of this rank; ranks on one machine share its processors.
int threads_of_rank(const RenderArguments& arguments, const Communicator& ranks) {
  if (arguments.threads > 0) return arguments.threads;
  cpu_set_t own;
  const int all = thread_count(0);
  if (::sched_getaffinity(0, sizeof own, &own) != 0) return all;
  const int bound = CPU_COUNT(&own);  // fewer than `all` if mpirun binds the rank
  return bound < all ? bound : std::max(1, all / ranks.local_size());
}

/// \return the device of this rank; ranks on one machine share its CUDA devices.
session::DeviceName device_of_rank(const RenderArguments& arguments, const Communicator& ranks) {
  session::DeviceName device = session::parse_device(arguments.device);
  if (device.kind == session::DeviceName::Kind::automatic && session::cuda_device_count() > 0)
    device.kind = session::DeviceName::Kind::cuda;
  if (device.kind == session::DeviceName::Kind::cuda && device.index == session::DeviceName::all)
    device.index = ranks.local_rank() % std::max(1, session::cuda_device_count());
  return device;
}

session::Session session_of(const RenderArguments& arguments, const Communicator* ranks) {
  if (ranks == nullptr) return session::Session(arguments);
  return session::Session(device_of_rank(arguments, *ranks), threads_of_rank(arguments, *ranks),
                          arguments.progress);
}

/// Works for rank 0 until the render ends.
ExitCode help(const RenderArguments& arguments, Communicator& ranks) {
  session::ignore_signals();  // rank 0 stops the work
  if (!Go::receive(ranks)) return ExitCode::done;
  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  const session::Device device =
      session::open_device(device_of_rank(arguments, ranks), threads_of_rank(arguments, ranks));
  serve(file.scene, *device.backend, ranks);
  return ExitCode::done;
}

/// \param ranks null: this process alone
ExitCode render_scene(const RenderArguments& arguments, Communicator* ranks, Go& go) {
  session::expect_requests();
  // Finds errors before the work begins: of the command line, the scene, then the machine.
  Outputs outputs;
  std::vector<std::string> pictures = arguments.outputs;
  if (pictures.empty()) pictures.push_back(default_output(arguments.scene));
  for (const std::string& path : pictures) outputs.add(path);
  require_sense(arguments, pictures);
  session::Session session = session_of(arguments, ranks);
  outputs.add_reports(arguments.report, arguments.detectors);
  const std::vector<std::string> written =
      outputs.distinct_paths({arguments.checkpoint, arguments.preview});
  if (!arguments.preview.empty()) {
    if (is_part(arguments.preview)) usage_error("--preview: a picture, not a part");
    Outputs().add(arguments.preview);  // throws if this build does not write the format
  }

  const io::SceneFile file = io::read_scene(arguments.scene, arguments.overrides);
  const ResolvedScene& scene = file.scene;
  std::vector<std::string> more_inputs;
  if (!arguments.illumination.empty()) more_inputs.push_back(arguments.illumination);
  session.accept(file, written, more_inputs);
  require_detectors(scene, arguments.detectors);
  refuse_ranges_beyond(scene, arguments);
  session.prepare(scene, lights_kept(scene, arguments));

  // The outputs below have temporaries. Writing a checkpoint after a signal may take longer.
  session::catch_signals(arguments.checkpoint.empty() ? 0.6 : 5.0);
  outputs.open();
  if (!arguments.checkpoint.empty()) io::OutputFile(arguments.checkpoint);  // may throw

  go.give();
  if (ranks != nullptr) session.distribute(*ranks);
  std::unique_ptr<Renderer> renderer;
  const auto write = [&](RenderResult& result) {
    session.finish(result, scene);
    if (arguments.denoises) io::denoise(result.picture);
    const io::Run run = session.report(*renderer, result, file, arguments.scene);
    if (ranks) {
      const Traffic& traffic = session.traffic();
      session::say(
          fmt::format("ranks    {}: {:.4g} MB sent and added up in {:.3g} s, waiting included\n",
                      ranks->size(), static_cast<double>(traffic.bytes) / 1e6, traffic.seconds));
    }
    outputs.write(run);
  };
  session::RunControl& control = session.control();
  Watch watch(arguments, control, write);
  renderer = session.begin(scene, options_of(arguments, scene, control));
  take_up(arguments, *renderer);
  const bool is_done = session.run(*renderer, true);
  const int signal = session::caught_signal();

  bool has_checkpoint = !arguments.checkpoint.empty();
  std::string lost;      // error of writing the checkpoint; thrown after the picture is written
  if (has_checkpoint) {  // also for a finished render: the outputs may fail
    try {
      watch.write_checkpoint(*renderer);
    } catch (const Error& error) {
      if (is_done) {
        session::warn(error.what());
      } else {
        lost = error.what();
      }
      has_checkpoint = is_done;
    }
  }
  const auto end = [&](ExitCode code) {
    if (!lost.empty()) throw Error(ExitCode::output_failed, lost);
    return code;
  };
  const std::string reason = signal != 0 ? "a signal" : control.limit();
  const std::string remedy =
      has_checkpoint ? fmt::format("; --checkpoint {} --resume goes on", arguments.checkpoint) : "";
  const ExitCode stopped = signal != 0 ? static_cast<ExitCode>(128 + signal) : ExitCode::limit;
  // Reaching a limit is no failure if every pixel has samples.
  const auto code_of = [&](const RenderResult& result) {
    return signal == 0 && (renderer->shoots_only() || !result.samples.empty()) ? ExitCode::done
                                                                               : stopped;
  };
  const bool shows = renderer->has_picture() || renderer->shoots_only();
  if (!is_done && !shows && signal != 0 && arguments.checkpoint.empty()) throw Stopped{};
  if (!is_done && !shows && !renderer->has_preview()) {
    session::say(fmt::format(
        "tyndall: stopped by {} before there was anything to see: no picture{}\n", reason, remedy));
    return end(stopped);
  }
  RenderResult result = shows ? renderer->result() : renderer->preview(preview_seconds);
  if (!is_done && signal == 0) result.limit = control.limit();
  try {
    write(result);
  } catch (const Error& error) {
    if (lost.empty()) throw;
    throw Error(error.code(), fmt::format("{}\n{}", error.what(), lost));
  }
  watch.show_last(*renderer, result);
  if (arguments.print_hash) print_hashes(result);
  if (is_done) {
    std::error_code error;
    if (has_checkpoint && !fs::remove(arguments.checkpoint, error) && error)
      session::warn(
          fmt::format("{}: cannot be removed: {}", arguments.checkpoint, error.message()));
    return ExitCode::done;
  }
  session::say(fmt::format(
      "tyndall: stopped by {}; {} photons {} of {} and samples {} of {}{}\n", reason,
      result.is_preview ? "the picture is a preview of" : "the output has", result.photons.text(),
      result.frame.photons, result.samples.text(), result.frame.samples, remedy));
  return end(code_of(result));
}

/// \return done, limit, or 128 + the signal. \throws Error; Stopped if nothing was written.
ExitCode run(const RenderArguments& arguments) {
  if (arguments.turntable != 0 && !arguments.frames) usage_error("--turntable: needs --frames A:B");
  if (arguments.frames && is_rank())
    usage_error("--frames: not under mpirun; run one command per machine, each with other frames");
  if (arguments.frames) return render_frames(arguments);
  const std::unique_ptr<Communicator> ranks = join_ranks();
  Go go(ranks && ranks->rank() == 0 ? ranks.get() : nullptr);
  if (!ranks) return render_scene(arguments, nullptr, go);
  const bool is_first = ranks->rank() == 0;
  try {
    return is_first ? render_scene(arguments, ranks.get(), go) : help(arguments, *ranks);
  } catch (...) {
    if (is_first && !go.is_given()) throw;  // ~Go() stops the other ranks
    // The other ranks may be waiting for this one.
    const std::string who = is_first ? "" : fmt::format("rank {}: ", ranks->rank());
    ranks->abort(report_failure(who));
    throw;
  }
}

Run add(CLI::App& command) {
  const auto arguments = std::make_shared<RenderArguments>();
  add_scene(command, *arguments);
  command
      .add_option("-o,--output", arguments->outputs,
                   "Picture to write (" + known_formats() + "); may be repeated; SCENE's name "
                   "in the current folder if not given")
      ->type_name("FILE")
      ->allow_extra_args(false);
  add_override(command, *arguments, "--photons", "photons.count", count(limits::photons),
               "Photons to shoot");
  add_override(command, *arguments, "--samples", "gather.samples", count(limits::samples),
               "Samples per pixel");
  add_override(command, *arguments, "-s,--seed", "seed", count(), "Seed of the random numbers");
  add_work(command, *arguments);
  command
      .add_option("--batch", arguments->batch, "Photons or samples at a time; changes no result")
      ->type_name("N")
      ->transform(count());
  command.add_option("--report", arguments->report, "Writes a report of the run as JSON")
      ->type_name("FILE");
  command
      .add_option("--detectors", arguments->detectors,
                  "Writes the counts of the scene's detectors as JSON")
      ->type_name("FILE");
  command.add_flag("--print-hash", arguments->print_hash,
                   "Prints the hashes of tallies and pixels, equal on every machine");

  command
      .add_option("--checkpoint", arguments->checkpoint,
                  "Saves the finished work in FILE while the render runs")
      ->type_name("FILE");
  command
      .add_option("--checkpoint-every", arguments->checkpoint_every,
                  "Interval of --checkpoint (60s)")
      ->type_name("TIME")
      ->transform(duration(true));
  command.add_flag("--resume", arguments->resume, "Resumes from the checkpoint if it exists");
  command
      .add_option("--time-limit", arguments->time_limit,
                  "Ends the render after 90s, 5m or 1h with the picture so far")
      ->type_name("TIME")
      ->transform(duration(false));
  command
      .add_option("--noise", arguments->noise,
                  "Ends the render once the relative error of noise is below X, such as 0.01")
      ->type_name("X")
      ->check(fraction());
  add_range(command, arguments->samples, "--sample-range",
            "Renders only these samples, of all pixels");
  add_range(command, arguments->photons, "--photon-range",
            "Shoots only these photons; with -o FILE.tyn");
  command
      .add_option("--illumination", arguments->illumination,
                  "Gathers the light of this part and shoots no photons")
      ->type_name("FILE");
  command.add_flag("--allow-gaps", arguments->allow_gaps, "Allows missing photons in that part");
  command.add_flag("--denoise", arguments->denoises,
                   "Denoises the pictures with Open Image Denoise");

  command
      .add_option("--display", arguments->display,
                  "Shows the picture in the viewer tev while it renders")
      ->type_name("HOST:PORT");
  CLI::Option* const preview = command
                                   .add_option("--preview", arguments->preview,
                                               "Writes the picture repeatedly while it renders")
                                   ->type_name("FILE");
  command.add_option("--every", arguments->preview_every, "Interval of --preview (5s)")
      ->type_name("TIME")
      ->needs(preview)  // by pointer: by name, CLI11 does not survive a lack of memory
      ->transform(duration(false));
  add_frames(command, arguments->frames,
             "Renders a sequence: ## in names, {frame} and {t} in the scene and -D vary by frame");
  command
      .add_option("--turntable", arguments->turntable,
                  "Turns the camera about its look_at by DEGREES in all frames together")
      ->type_name("DEGREES")
      ->check([](const std::string& text) -> std::string {
        char* end = nullptr;
        const double degrees = std::strtod(text.c_str(), &end);
        return *end == '\0' && std::isfinite(degrees) ? "" : "expected degrees, got '" + text + "'";
      });
  return [arguments] { return run(*arguments); };
}

}  // namespace

const Command render_command{"render", "Renders a scene", &add, true};

}  // namespace tyndall::app
