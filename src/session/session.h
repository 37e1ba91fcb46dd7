/// \file
/// The steps of a run, for all commands that render and for the Python module.
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

/// Device, threads and progress style of a run.
struct WorkArguments {
  int threads = 0;                ///< 0: one per hardware thread
  std::string device = "auto";    ///< "auto", "cpu", "cuda", "cuda:1"
  std::string progress = "auto";  ///< auto, bar, plain, none
};

/// Performs runs on one device, one after the other. accept() and prepare() find errors before the
/// work, begin() and run() do the work, finish() completes the result.
class Session {
 public:
  /// \throws Error(usage)
  explicit Session(const WorkArguments& arguments);
  /// For a rank that shares its machine with others.
  Session(const DeviceName& device, int threads, const std::string& progress);

  /// Called with every warning.
  std::function<void(const std::string&)> on_warning = &warn;

  /// Checks a scene that was read: no output may replace its inputs or `more`. Passes on its
  /// warnings. \throws Error(usage)
  void accept(const io::SceneFile& file, const std::vector<std::string>& outputs,
              const std::vector<std::string>& more = {});
  /// Checks that memory suffices for a scene with the light of `lights` replicates, and opens the
  /// device. \throws Error(out_of_memory, device)
  void prepare(const ResolvedScene& scene, int lights = 1);
  /// Distributes later runs over all ranks. \pre prepare() \param ranks must outlive the session
  void distribute(Communicator& ranks);

  RunControl& control() { return control_; }
  /// \return whether the device was chosen automatically, so that another may replace it.
  bool may_change_device() const { return device_name_.kind == DeviceName::Kind::automatic; }
  const Traffic& traffic() const { return traffic_; }

  /// \return a render that has its bounds. It runs on the processor if an automatically chosen
  /// device fails. \pre prepare() \throws as Renderer
  std::unique_ptr<Renderer> begin(const ResolvedScene& scene, const RenderOptions& options);
  /// \param is_last the output follows; a signal no longer limits the time that writing it takes
  /// \return as Renderer::run()
  bool run(Renderer& renderer, bool is_last);
  /// Adds the picture's header, and passes on the warnings that the render of `scene` has added to
  /// those of accept().
  void finish(RenderResult& result, const ResolvedScene& scene) const;
  /// Prints the report of a result. \return the data of the report, for the outputs
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
