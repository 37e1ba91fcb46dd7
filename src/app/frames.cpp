#include "app/frames.h"

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

#include "app/outputs.h"
#include "io/denoise.h"
#include "io/report.h"
#include "io/scene_json.h"
#include "render/camera.h"
#include "session/memory.h"
#include "session/refuse.h"
#include "session/session.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"
#if TYNDALL_OPENEXR
#include "io/exr.h"
#endif

namespace tyndall::app {
namespace {

namespace fs = std::filesystem;

using session::usage_error;

void require_sense(const RenderArguments& a) {
  if (a.denoises) io::require_denoiser();
  const auto refuse = [](bool given, const char* option) {
    if (given) usage_error(fmt::format("--frames and {}: not together", option));
  };
  refuse(!a.checkpoint.empty() || a.resume,
         "--checkpoint (the finished frames of a sequence are its checkpoint)");
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
      usage_error(fmt::format(
          "{}: has no ## for the frame's number; use a name such as frame.####.exr", path));
}

/// Rotates the camera about its look_at, around its up vector.
void turn(scene::Camera& camera, double degrees) {
  const glm::dmat4 rotation = glm::rotate(glm::dmat4(1), glm::radians(degrees), camera.up);
  camera.position = camera.look_at + glm::dmat3(rotation) * (camera.position - camera.look_at);
}

/// Reads the scenes of a sequence.
class Frames {
 public:
  Frames(const SceneArguments& scene, const FrameRange& range)
      : scene_(scene.scene), overrides_(scene.overrides) {
    for (int frame = range.first; frame <= range.last; frame += range.step)
      numbers_.push_back(frame);
  }

  std::size_t size() const { return numbers_.size(); }
  /// \return the number of frame `i`; i == size(): of the frame after the last.
  int number(std::size_t i) const { return i < size() ? numbers_[i] : numbers_.back() + 1; }
  std::string title(std::size_t i) const {
    return fmt::format("frame    {} ({} of {})", number(i), i + 1, size());
  }
  std::string in_frame(const std::string& text, std::size_t i) const {
    return of_frame(text, number(i), fraction(i));
  }
  /// \return the fraction of the sequence before frame `i`.
  double fraction(std::size_t i) const {
    return static_cast<double>(i) / static_cast<double>(size());
  }

  /// Looks for the files of all frames and warns of missing ones.
  /// \throws Error if a scene is wrong, if every frame lacks a file, or if a file is missing that
  /// all frames share.
  void look_up() {
    std::vector<std::vector<io::NamedFile>> files;
    std::map<std::string, std::vector<std::string>> paths;
    for (std::size_t i = 0; i < size(); ++i) {
      files.push_back(names_of(i));
      for (const io::NamedFile& file : files.back()) paths[file.key].push_back(file.path);
    }
    std::map<std::string, std::string> more;  // files of the frame after the last, not rendered
    for (const io::NamedFile& file : names_of(size())) more[file.key] = file.path;
    for (auto& [key, all] : paths) {
      const auto differs = [&](const std::string& path) { return path != all[0]; };
      // The frame after the last shows which files are numbered if there is only one frame.
      if (std::any_of(all.begin(), all.end(), differs)
          || (more.contains(key) && differs(more[key])))
        sequence_.numbered.emplace(key, std::move(all));
    }
    std::vector<int> lacking;
    std::string first;
    for (std::size_t i = 0; i < size(); ++i) {
      for (const io::NamedFile& file : files[i]) {
        std::error_code error;
        if (fs::exists(file.path, error)) continue;
        if (!sequence_.numbered.contains(file.key)) read(i);  // throws, with the place in the scene
        if (first.empty()) first = file.path;
        lacking.push_back(number(i));
        break;
      }
    }
    if (lacking.empty()) return;
    if (lacking.size() == size())
      throw Error(ExitCode::input_missing,
                  fmt::format("{}: no such file; every frame lacks one", first));
    session::warn(fmt::format("{} of {} frames lack a file, such as {}: {}", lacking.size(), size(),
                              first, listed(lacking)));
  }

  /// \throws Error; io::UnreadableFrame if only files of this frame are wrong.
  io::SceneFile read(std::size_t i) {
    const std::size_t known = sequence_.fits.size();
    io::SceneFile file = io::read_scene(
        scene_, overrides_of(i), [&](const std::string& text) { return in_frame(text, i); },
        &sequence_);
    if (sequence_.fits.size() > known)
      for (const auto& [key, fit] : sequence_.fits)
        if (!fit.file.empty() && is_fit_said_.insert(key).second)
          session::say(fmt::format("fit      {}: in all frames as in {}\n", key, fit.file));
    return file;
  }

  /// Prints a warning, unless an earlier frame had it.
  void warn(const std::string& text) {
    if (!text.empty() && warned_.insert(text).second) session::warn(text);
  }

  /// Reports that a frame cannot be read. Rethrows an error that other frames would have, too.
  void fail(std::size_t i, const Error& error) {
    const bool is_of_frame = dynamic_cast<const io::UnreadableFrame*>(&error) != nullptr;
    if (!is_of_frame && error.code() != ExitCode::scene_invalid) throw;
    session::say(fmt::format("{}: cannot be read\n{}\n", title(i), error.what()));
    failed_.push_back({number(i), error.code(), error.what()});
  }

  /// Lists the frames that could not be read. \return input_missing or scene_invalid; done if there
  /// are none
  ExitCode failures() const {
    if (failed_.empty()) return ExitCode::done;
    constexpr std::size_t most = 20;
    std::vector<int> numbers;
    std::string reasons;
    bool is_input = false;
    for (const Failed& frame : failed_) {
      is_input = is_input || frame.code == ExitCode::input_missing;
      numbers.push_back(frame.number);
      if (numbers.size() <= most) reasons += fmt::format("{}\n", frame.message);
    }
    session::say(fmt::format("tyndall: {} of {} frames could not be read: {}\n{}", numbers.size(),
                             size(), listed(numbers), reasons));
    return is_input ? ExitCode::input_missing : ExitCode::scene_invalid;
  }

 private:
  struct Failed {
    int number;
    ExitCode code;
    std::string message;
  };

  /// \return ascending numbers as "3, 7-12, 40"; ranges have the step of the sequence.
  std::string listed(const std::vector<int>& numbers) const {
    const int step = size() > 1 ? numbers_[1] - numbers_[0] : 1;
    std::string text;
    for (std::size_t first = 0; first < numbers.size();) {
      std::size_t last = first;
      while (last + 1 < numbers.size() && numbers[last + 1] - numbers[last] == step) ++last;
      text += fmt::format("{}{}", text.empty() ? "" : ", ", numbers[first]);
      if (last > first) text += fmt::format("-{}", numbers[last]);
      first = last + 1;
    }
    return text;
  }

  std::vector<std::string> overrides_of(std::size_t i) const {
    std::vector<std::string> overrides = overrides_;
    for (std::string& text : overrides) text = in_frame(text, i);
    return overrides;
  }

  std::vector<io::NamedFile> names_of(std::size_t i) const {
    try {
      return io::scene_files(scene_, overrides_of(i),
                             [&](const std::string& text) { return in_frame(text, i); });
    } catch (const Error& error) {
      if (i == size()) return {};  // the frame after the last may be no valid scene
      throw;
    }
  }

  const std::string& scene_;
  const std::vector<std::string>& overrides_;
  std::vector<int> numbers_;
  io::SequenceFiles sequence_;
  std::set<std::string> is_fit_said_, warned_;
  std::vector<Failed> failed_;
};

/// The scene file of a frame.
struct Loaded {
  io::SceneFile file;
  std::uint64_t key = 0;  ///< see light_hash()
};

/// Makes `to` share the volumes of `from`, which are equal, so that its own are released.
void share_volumes(const io::SceneFile& from, io::SceneFile& to) {
  if (from.volumes.empty()) return;
  Scene scene = *to.scene;
  scene.medium = from.scene->medium;
  to.scene = ResolvedScene(std::move(scene));
  for (std::size_t v = 0; v < std::min(from.volumes.size(), to.volumes.size()); ++v)
    to.volumes[v].volume = from.volumes[v].volume;
}

class Sequence {
 public:
  explicit Sequence(const RenderArguments& arguments)
      : arguments_(arguments), frames_(arguments, *arguments.frames), session_(arguments) {
    session_.on_warning = [this](const std::string& text) { frames_.warn(text); };
  }

  ExitCode run() {
    // Finds errors before hours of work: in the file names of all frames, in the first and in the
    // last scene.
    frames_.look_up();
    const std::size_t last = frames_.size() - 1;
    for (const std::size_t i : {std::size_t{0}, last}) {
      try {
        scene_of(i);
      } catch (const Error& error) {
        const bool is_of_frame = dynamic_cast<const io::UnreadableFrame*>(&error) != nullptr;
        if (!is_of_frame && (i == 0 || error.code() != ExitCode::scene_invalid)) throw;
        session::warn(fmt::format("frame {} will be skipped unless this is mended: {}",
                                  frames_.number(i), error.what()));
      }
    }
    if (last > 0) scenes_.erase(last);  // its volumes may be large
    session::catch_signals(5.0);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (!render_frame_or_stop(i)) {
        frames_.failures();
        session::say(
            fmt::format("tyndall: stopped by a signal in frame {}; the same command resumes it\n",
                        frames_.number(i)));
        return static_cast<ExitCode>(128 + session::caught_signal());
      }
      scenes_.erase(i);
    }
    return frames_.failures();
  }

 private:
  Loaded& scene_of(std::size_t i) {
    if (const auto known = scenes_.find(i); known != scenes_.end()) return known->second;
    io::SceneFile file = frames_.read(i);
    if (arguments_.turntable != 0) {
      Scene scene = *file.scene;
      if (scene.camera.matrix)
        usage_error("--turntable: the camera needs a look_at, and this one has a matrix");
      turn(scene.camera, arguments_.turntable * frames_.fraction(i));
      file.scene = ResolvedScene(std::move(scene));
    }
    const std::uint64_t key = light_hash(file.scene);
    return scenes_.emplace(i, Loaded{std::move(file), key}).first->second;
  }

  /// \return the scene; null if it cannot be read, which is reported.
  const Loaded* scene_or_failure(std::size_t i) {
    try {
      return &scene_of(i);
    } catch (const Error& error) {
      frames_.fail(i, error);
      return nullptr;
    }
  }

  /// \return whether the light of frame `i` has the key; false if the frame cannot be read. Its own
  /// turn reports the error.
  bool has_key(std::size_t i, std::uint64_t key) {
    try {
      return i < frames_.size() && scene_of(i).key == key;
    } catch (const Error&) {
      return false;
    }
  }

#if TYNDALL_OPENEXR
  static std::vector<std::pair<std::string, std::string>> provenance_of(const std::string& path) {
    try {
      return io::read_exr(path).provenance;
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("{}; it has the name of a frame: remove it, or change "
                                            "the names of the frames",
                                            error.what()));
    }
  }
#endif

  /// \return whether all pictures of a frame exist. \throws Error(usage) if one is of another scene
  bool is_there(const std::vector<std::string>& paths, std::size_t i) {
    for (const std::string& path : paths) {
      std::error_code error;  // a failed look-up counts as missing
      if (!fs::exists(path, error) || fs::file_size(path, error) == 0) return false;
    }
#if TYNDALL_OPENEXR
    for (const std::string& path : paths) {
      if (extension_of(path) != ".exr") continue;
      std::map<std::string, std::string> header;
      for (auto& [key, value] : provenance_of(path)) header[key] = value;
      if (header.contains("tyndall.complete") && header["tyndall.complete"] != "true")
        return false;  // of an interrupted render
      if (!header.contains("tyndall.scene_hash")) continue;
      try {
        if (header["tyndall.scene_hash"]
            != fmt::format("{:016x}", scene_hash(scene_of(i).file.scene)))
          usage_error(fmt::format(
              "{}: is there already, of another scene: remove it, or name others", path));
      } catch (const io::UnreadableFrame&) {
        session::warn(fmt::format("{}: is kept, but its scene can no longer be read", path));
      }
    }
#else
    static_cast<void>(i);
#endif
    return true;
  }

  /// \return false if a signal ended it.
  bool render_frame_or_stop(std::size_t i) {
    try {
      return render_frame(i) && (session::caught_signal() == 0 || i + 1 == frames_.size());
    } catch (const Stopped&) {
      session_.control().clear();
      return false;
    }
  }

  /// \return false if a signal ended it. \throws Error, Stopped
  bool render_frame(std::size_t i) {
    const int frame = frames_.number(i);
    const auto numbered = [&](const std::string& path) { return frames_.in_frame(path, i); };
    Outputs outputs;
    for (const std::string& path : arguments_.outputs) outputs.add(numbered(path));
    outputs.add_reports(arguments_.report.empty() ? "" : numbered(arguments_.report),
                        arguments_.detectors.empty() ? "" : numbered(arguments_.detectors));
    const std::vector<std::string> paths = outputs.distinct_paths();
    if (is_there(paths, i)) {
      session::say(frames_.title(i) + ": is there already\n");
      return true;
    }
    const Loaded* const loaded = scene_or_failure(i);
    if (!loaded) return true;
    session::say(frames_.title(i) + "\n");
    const io::SceneFile& file = loaded->file;
    session_.accept(file, paths);
    if (!std::exchange(has_begun_, true)) require_detectors(file.scene, arguments_.detectors);
    if (lit_ && (lit_->key != loaded->key || !session::memory_shortage(file.scene).empty()))
      lit_.reset();
    if (!lit_) session_.prepare(file.scene);
    outputs.open();
    const bool lights_next = has_key(i + 1, loaded->key);
    if (lights_next) share_volumes(file, scene_of(i + 1).file);

    RenderResult result;
    if (!finish_by_light(*loaded, frame, lights_next, result)) return false;
    if (lit_->frame == frame)
      lit_->seconds = result.seconds.bounds + result.seconds.photons
                      + result.seconds.measured[measurement::scattering];
    session_.finish(result, file.scene);
    if (arguments_.denoises) io::denoise(result.picture);
    outputs.write(session_.report(*lit_->renderer, result, file, arguments_.scene));
    if (!lit_->is_kept) lit_.reset();
    if (arguments_.print_hash) print_hashes(result, fmt::format("frame {} ", frame));
    return true;
  }

  /// Renders with the light of an earlier frame if it fits, else shoots it. \return false if a
  /// signal ended it.
  bool finish_by_light(const Loaded& loaded, int frame, bool lights_next, RenderResult& result) {
    const ResolvedScene& scene = loaded.file.scene;
    try {
      if (!reuse_light(scene)) begin(loaded, frame, lights_next && may_keep_);
      return finishes(result);
    } catch (const std::bad_alloc&) {
      if (!lit_ || !lit_->is_kept) throw;
      session_.control().clear();
      lit_.reset();
      may_keep_ = false;
      session_.prepare(scene);
      session::say("light    too large to keep between frames: each frame shoots its photons\n");
      begin(loaded, frame, false);
      return finishes(result);
    }
  }

  /// \return false if there is no light, or if the device that had it is lost.
  bool reuse_light(const ResolvedScene& scene) {
    if (!lit_) return false;
    try {
      lit_->renderer->look(scene);
    } catch (const Error& error) {
      if (error.code() != ExitCode::device || !session_.may_change_device()) throw;
      lit_.reset();
      return false;
    }
    session::say(fmt::format("light    of frame {}, {:.2f} s saved\n", lit_->frame, lit_->seconds));
    return true;
  }

  void begin(const Loaded& loaded, int frame, bool may_keep) {
    const ResolvedScene& scene = loaded.file.scene;
    RenderOptions options = session_.control().options();
    options.batch = arguments_.batch;
    // The light is kept as floats, half as large as the tallies.
    options.keeps_light =
        may_keep && session::memory_shortage(scene, 1 + most_replicates / 2).empty();
    lit_ = Lit{loaded.key, nullptr, frame, options.keeps_light};
    lit_->renderer = session_.begin(scene, options);
  }

  /// \return false if a signal ended it.
  bool finishes(RenderResult& result) {
    const bool is_done = session_.run(*lit_->renderer, false);
    if (is_done) result = lit_->renderer->result();
    return is_done;
  }

  /// The bounds and light of a frame; later frames may share them.
  struct Lit {
    std::uint64_t key;  ///< of the frame for which the light was shot
    std::unique_ptr<Renderer> renderer;
    int frame;
    bool is_kept;        ///< for the next frame
    double seconds = 0;  ///< [s] for bounds, medium and photons
  };

  const RenderArguments& arguments_;
  Frames frames_;
  session::Session session_;
  bool has_begun_ = false;
  std::map<std::size_t, Loaded> scenes_;  // not yet rendered
  std::optional<Lit> lit_;
  bool may_keep_ = true;  // the light has fitted into memory so far
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

ExitCode validate_frames(const SceneArguments& arguments, const FrameRange& range) {
  Frames frames(arguments, range);
  frames.look_up();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    try {
      const io::SceneFile file = frames.read(i);
      for (const std::string& warning : file.warnings) frames.warn(warning);
      frames.warn(session::memory_shortage(file.scene));
    } catch (const Error& error) {
      frames.fail(i, error);
    }
  }
  const ExitCode code = frames.failures();
  if (code == ExitCode::done)
    session::print(fmt::format("{}: valid in {} frames\n", arguments.scene, frames.size()));
  return code;
}

ExitCode render_frames(const RenderArguments& arguments) {
  require_sense(arguments);
  return Sequence(arguments).run();
}

}  // namespace tyndall::app
