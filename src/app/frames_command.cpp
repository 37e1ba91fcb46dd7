#include "app/frames_command.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "app/console.h"
#include "app/devices.h"
#include "app/memory.h"
#include "app/outputs.h"
#include "app/progress.h"
#include "app/signals.h"
#include "io/denoise.h"
#include "io/report.h"
#include "io/scene_json.h"
#include "render/camera.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"
#if TYNDALL_OPENEXR
#include "io/exr.h"
#endif

namespace tyndall::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void usage_error(const std::string& message) { throw Error(ExitCode::usage, message); }

void require_sense(const RenderArguments& a) {
  if (a.denoises) io::require_denoiser();
  const auto refuse = [](bool given, const char* option) {
    if (given) usage_error(fmt::format("--frames and {}: not together", option));
  };
  refuse(!a.checkpoint.empty() || a.resume,
         "--checkpoint (what is done of a sequence is its frames)");
  refuse(a.allow_gaps, "--allow-gaps");
  refuse(a.photons.has_value(), "--photon-range");
  refuse(a.samples.has_value(), "--sample-range");
  refuse(!a.illumination.empty(), "--illumination");
  refuse(a.time_limit > 0, "--time-limit");
  refuse(a.noise > 0, "--noise");
  refuse(!a.display.empty(), "--display");
  refuse(!a.preview.empty(), "--preview");
  if (a.outputs.empty())
    usage_error("--frames: name the pictures with -o, such as -o frame.####.exr");
  std::vector<std::string> written = a.outputs;
  for (const std::string& more : {a.report, a.detectors})
    if (!more.empty()) written.push_back(more);
  for (const std::string& path : written)
    if (of_frame(path, 1, 0) == path)
      usage_error(
          fmt::format("{}: has no place for the frame's number, such as frame.####.exr", path));
}

/// About what it looks at, around its own up.
void turn(scene::Camera& camera, double degrees) {
  const glm::dmat4 rotation = glm::rotate(glm::dmat4(1), glm::radians(degrees), camera.up);
  camera.position = camera.look_at + glm::dmat3(rotation) * (camera.position - camera.look_at);
}

/// The scene of a frame, as it was read.
struct Loaded {
  io::SceneFile file;
  std::uint64_t key = 0;  ///< of all that makes the light: everything but the camera and its paths
};

std::uint64_t key_of(Scene& scene) {
  scene::Camera camera = std::exchange(scene.camera, {});
  const std::uint64_t key = scene_hash(scene);
  scene.camera = std::move(camera);
  return key;
}

/// Lets the volumes of `to`, which are those of `from`, go.
void share_volumes(const io::SceneFile& from, io::SceneFile& to) {
  to.scene.medium = from.scene.medium;
  for (std::size_t v = 0; v < std::min(from.volumes.size(), to.volumes.size()); ++v)
    to.volumes[v].volume = from.volumes[v].volume;
}

void require_memory(const Scene& scene) {
  if (const std::string shortage = memory_shortage(scene); !shortage.empty())
    throw Error(ExitCode::out_of_memory, shortage);
}

class Sequence {
 public:
  explicit Sequence(const RenderArguments& arguments)
      : arguments_(arguments),
        device_name_(parse_device(arguments.device)),
        meter_(progress_style(arguments.progress)) {}

  ExitCode run() {
    const FrameRange& range = *arguments_.frames;
    for (int frame = range.first; frame <= range.last; frame += range.step)
      frames_.push_back(frame);
    // What is wrong with the first or the last is said before hours of work.
    scene_of(0);
    scene_of(frames_.size() - 1);
    if (frames_.size() > 1) scenes_.erase(frames_.size() - 1);  // its volumes may be large
    catch_signals(5.0);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (!render_frame_or_stop(i)) {
        say(fmt::format("tyndall: stopped by a signal in frame {}; the same line goes on there\n",
                        frames_[i]));
        return static_cast<ExitCode>(128 + caught_signal());
      }
      scenes_.erase(i);
    }
    return ExitCode::done;
  }

 private:
  double share(std::size_t i) const {
    return static_cast<double>(i) / static_cast<double>(frames_.size());
  }

  const std::shared_ptr<Loaded>& scene_of(std::size_t i) {
    if (const auto known = scenes_.find(i); known != scenes_.end()) return known->second;
    std::vector<std::string> overrides = arguments_.overrides;
    for (std::string& text : overrides) text = of_frame(text, frames_[i], share(i));
    io::SceneFile file = io::read_scene(arguments_.scene, overrides, [&](const std::string& text) {
      return of_frame(text, frames_[i], share(i));
    });
    if (arguments_.turntable != 0) {
      if (file.scene.camera.matrix)
        usage_error("--turntable: turns a camera about its look_at, and this one has a matrix");
      turn(file.scene.camera, arguments_.turntable * share(i));
    }
    const std::uint64_t key = key_of(file.scene);
    return scenes_.emplace(i, std::make_shared<Loaded>(Loaded{std::move(file), key})).first->second;
  }

  /// Whether the light of frame `i` has the key; not where it cannot be read, which is said in its
  /// turn: the frames before it are none the worse for it.
  bool has_key(std::size_t i, std::uint64_t key) {
    try {
      return i < frames_.size() && scene_of(i)->key == key;
    } catch (const Error&) {
      return false;
    }
  }

#if TYNDALL_OPENEXR
  static std::vector<std::pair<std::string, std::string>> provenance_of(const std::string& path) {
    try {
      return io::read_exr(path).provenance;
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("{}; it is in the place of a frame: remove it, or name "
                                            "others",
                                            error.what()));
    }
  }
#endif

  /// \return whether the pictures of a frame are there. \throws Error(usage) where they are of
  /// another scene
  bool is_there(const std::vector<std::string>& paths, std::size_t i) {
    for (const std::string& path : paths) {
      std::error_code error;  // what cannot be looked up is not there
      if (!fs::exists(path, error) || fs::file_size(path, error) == 0) return false;
    }
#if TYNDALL_OPENEXR
    for (const std::string& path : paths) {
      if (extension_of(path) != ".exr") continue;
      const std::string expected = fmt::format("{:016x}", scene_hash(scene_of(i)->file.scene));
      for (const auto& [key, value] : provenance_of(path)) {
        if (key == "tyndall.scene_hash" && value != expected)
          usage_error(fmt::format(
              "{}: is there already, of another scene: remove it, or name others", path));
        if (key == "tyndall.complete" && value != "true")
          return false;  // of a render that was left
      }
    }
#else
    static_cast<void>(i);
#endif
    return true;
  }

  /// \return false where a signal ended it.
  bool render_frame_or_stop(std::size_t i) {
    try {
      return render_frame(i) && (caught_signal() == 0 || i + 1 == frames_.size());
    } catch (const Stopped&) {
      meter_.clear();
      return false;
    }
  }

  /// The same, or throws Stopped.
  bool render_frame(std::size_t i) {
    const int frame = frames_[i];
    const auto numbered = [&](const std::string& path) { return of_frame(path, frame, share(i)); };
    Outputs outputs;
    for (const std::string& path : arguments_.outputs) outputs.add(numbered(path));
    outputs.add_reports(arguments_.report.empty() ? "" : numbered(arguments_.report),
                        arguments_.detectors.empty() ? "" : numbered(arguments_.detectors));
    outputs.refuse_repeats();
    const std::string title = fmt::format("frame    {} ({} of {})", frame, i + 1, frames_.size());
    if (is_there(outputs.paths(), i)) {
      say(title + ": is there already\n");
      return true;
    }
    say(title + "\n");
    const std::shared_ptr<const Loaded> loaded = scene_of(i);
    const io::SceneFile& file = loaded->file;
    refuse_inputs(file.inputs, outputs.paths());
    for (const std::string& warning : file.warnings)
      if (warned_.insert(warning).second) warn(warning);
    if (!std::exchange(has_begun_, true)) require_detectors(file.scene, arguments_.detectors);
    if (lit_ && (lit_->by->key != loaded->key || !memory_shortage(file.scene).empty()))
  const std::optional<std::uint64_t> seed = std::exchange(scene.gather_seed, {});
      lit_.reset();
    if (!lit_) require_memory(file.scene);
  scene.gather_seed = seed;
    outputs.open();
    if (!device_.backend) device_ = open_device(device_name_, arguments_.threads);
    const bool lights_next = has_key(i + 1, loaded->key);
    if (lights_next) share_volumes(file, scene_of(i + 1)->file);

    RenderResult result;
    if (!finish_by_light(loaded, frame, lights_next, result)) return false;
    if (lit_->frame == frame)
      lit_->seconds = result.seconds.bounds + result.seconds.photons + result.seconds.matter;
    finish(result, file.warnings);
    if (arguments_.denoises) io::denoise(result.picture);
    const io::Run run{lit_->renderer->part(), result, arguments_.scene, device_.name, file.volumes};
    say(io::report_lines(run));
    outputs.write(run);
    if (!lit_->is_kept) lit_.reset();
    if (arguments_.print_hash) {
      print(fmt::format("frame {} tallies {:016x} pixels {:016x}\n", frame, result.hashes.tallies,
                        result.hashes.pixels));
    }
    return true;
  }

  /// With the light that there is, or its own. \return false where a signal ended it.
  bool finish_by_light(const std::shared_ptr<const Loaded>& loaded, int frame, bool lights_next,
                       RenderResult& result) {
    const Scene& scene = loaded->file.scene;
    try {
      if (!looks(scene)) begin(loaded, frame, lights_next && may_keep_);
      return finishes(result);
    } catch (const std::bad_alloc&) {
      if (!lit_ || !lit_->is_kept) throw;
      meter_.clear();
      lit_.reset();
      may_keep_ = false;
      require_memory(scene);
      say("light    too large to keep beside a frame: it is shot for each\n");
      begin(loaded, frame, false);
      return finishes(result);
    }
  }

  /// \return false where there is no light, or the device that had it is lost.
  bool looks(const Scene& scene) {
    if (!lit_) return false;
    try {
      lit_->renderer->look(scene);
    } catch (const Error& error) {
      if (error.code() != ExitCode::device || device_name_.kind != DeviceName::Kind::automatic)
        throw;
      lit_.reset();
      return false;
    }
    say(fmt::format("light    of frame {}, {:.2f} s saved\n", lit_->frame, lit_->seconds));
    return true;
  }

  void begin(const std::shared_ptr<const Loaded>& loaded, int frame, bool may_keep) {
    const Scene& scene = loaded->file.scene;
    RenderOptions options = interruptible(meter_);
    options.batch = arguments_.batch;
    // Kept as floats, half as large as what is shot.
    options.keeps_light = may_keep && memory_shortage(scene, 1 + most_replicates / 2).empty();
    lit_ = Lit{loaded, nullptr, frame, options.keeps_light};
    lit_->renderer = begin_render(scene, device_, device_name_, arguments_.threads, options,
                                  [this] { meter_.clear(); });
  }

  /// \return false where a signal ended it.
  bool finishes(RenderResult& result) {
    const bool is_done = lit_->renderer->run();
    meter_.clear();
    if (is_done) result = lit_->renderer->result();
    return is_done;
  }

  /// A frame's bounds and light, for itself and those after it that share them.
  struct Lit {
    std::shared_ptr<const Loaded> by;  ///< whose matter the renderer reads
    std::unique_ptr<Renderer> renderer;
    int frame;
    bool is_kept;  ///< for the next one
    double seconds = 0;
  };

  const RenderArguments& arguments_;
  const DeviceName device_name_;
  Device device_;
  ProgressMeter meter_;
  bool has_begun_ = false;
  std::set<std::string> warned_;  // once for all frames
  std::vector<int> frames_;
  std::map<std::size_t, std::shared_ptr<Loaded>> scenes_;  // that are still to be rendered
  std::optional<Lit> lit_;
  bool may_keep_ = true;  // there was room for it so far
};

}  // namespace

std::string of_frame(const std::string& text, int frame, double t) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto starts = [&](std::string_view word) {
      return text.compare(at, word.size(), word) == 0;
    };
    std::size_t run = 0;
    while (at + run < text.size() && text[at + run] == '#') ++run;
    if (run >= 2) {
      out += fmt::format("{:0{}}", frame, run);
      at += run;
    } else if (starts("{frame}")) {
      out += std::to_string(frame);
      at += 7;
    } else if (starts("{t}")) {
      out += fmt::format("{}", t);
      at += 3;
    } else {
      out += text[at++];
    }
  }
  return out;
}

ExitCode frames_command(const RenderArguments& arguments) {
  require_sense(arguments);
  return Sequence(arguments).run();
}

}  // namespace tyndall::app
