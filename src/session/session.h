/// \file
/// The protocol of a run, for all commands that render and for the Python module.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/report.h"
#include "io/scene_json.h"
#include "session/console.h"
#include "session/devices.h"
#include "session/run_control.h"
#include "tyndall/render/communicator.h"
#include "tyndall/render/render.h"

namespace tyndall::session {

/// Where a run works, and what it shows of that.
struct WorkArguments {
  int threads = 0;                ///< 0: one per hardware thread
  std::string device = "auto";    ///< "auto", "cpu", "cuda", "cuda:1"
  std::string progress = "auto";  ///< auto, bar, plain, none
};

/// One run after the other on one device: accept() and prepare() find out what is wrong before the
/// work, begin() and run() do it, finish() completes its result.
class Session {
 public:
  /// \throws Error(usage)
  explicit Session(const WorkArguments& arguments);
  /// Of a rank that shares its machine with others.
  Session(const DeviceName& device, int threads, const std::string& progress);

  /// Gets every warning.
  std::function<void(const std::string&)> on_warning = &warn;

  /// Takes a scene that was read: refuses to write over its inputs and `more`, and prints its
  /// warnings. \throws Error(usage)
  void accept(const io::SceneFile& file, const std::vector<std::string>& outputs,
              const std::vector<std::string>& more = {});
  /// Finds out whether memory is enough for a scene, and for the light of so many replicates, and
  /// opens the device. \throws Error(out_of_memory, device)
  void prepare(const ResolvedScene& scene, int lights = 1);
  /// From here on all ranks do the work. \pre prepare() \param ranks must outlive the session
  void distribute(Communicator& ranks);

  RunControl& control() { return control_; }
  /// \return whether nobody has named the device: then another will do, too.
  bool may_change_device() const { return device_name_.kind == DeviceName::Kind::automatic; }
  const Traffic& traffic() const { return traffic_; }

  /// \return a render that has its bounds; if it finds too little memory on a device that nobody
  /// has named, it is on the processor. \pre prepare() \throws as Renderer
  std::unique_ptr<Renderer> begin(const ResolvedScene& scene, const RenderOptions& options);
  /// \param is_last what follows is written whatever time it takes \return Renderer::run()
  bool run(Renderer& renderer, bool is_last);
  /// Gives the picture its header, and prints the warnings that the render of `scene` has added to
  /// those that accept() printed.
  void finish(RenderResult& result, const ResolvedScene& scene) const;
  /// Says the account of a result. \return it for those who write it
  io::Run report(Renderer& renderer, const RenderResult& result, const io::SceneFile& file,
                 const std::string& scene) const;

 private:
  const DeviceName device_name_;
  const int threads_;
  RunControl control_;
  Device device_;
  Traffic traffic_;
  std::unique_ptr<Backend> distributed_;
};

}  // namespace tyndall::session
