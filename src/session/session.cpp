#include "session/session.h"

#include <algorithm>

#include "session/memory.h"
#include "session/refuse.h"
#include "tyndall/render/error.h"

namespace tyndall::session {

Session::Session(const WorkArguments& arguments)
    : Session(parse_device(arguments.device), arguments.threads, arguments.progress) {}

Session::Session(const DeviceName& device, int threads, const std::string& progress)
    : device_name_(device), threads_(threads), control_(progress_style(progress)) {}

void Session::accept(const io::SceneFile& file, const std::vector<std::string>& outputs,
                     const std::vector<std::string>& more) {
  std::vector<std::string> inputs = file.inputs;
  inputs.insert(inputs.end(), more.begin(), more.end());
  refuse_inputs(inputs, outputs);
  for (const std::string& warning : file.warnings) on_warning(warning);
}

void Session::prepare(const ResolvedScene& scene, int lights) {
  if (const std::string shortage = memory_shortage(scene, lights); !shortage.empty())
    throw Error(ExitCode::out_of_memory, shortage);
  if (!device_.backend) device_ = open_device(device_name_, threads_);
}

void Session::distribute(Communicator& ranks) {
  distributed_ = make_distributed_backend(*device_.backend, ranks, &traffic_);
}

std::unique_ptr<Renderer> Session::begin(const ResolvedScene& scene, const RenderOptions& options) {
  if (distributed_) return std::make_unique<Renderer>(scene, *distributed_, options);
  try {
    return std::make_unique<Renderer>(scene, *device_.backend, options);
  } catch (const Error& error) {
    // No photon has been traced yet: another device can take over.
    if (error.code() != ExitCode::device || !may_change_device()) throw;
    control_.clear();
    device_ = open_device(device_name_, threads_, error.what());
    return std::make_unique<Renderer>(scene, *device_.backend, options);
  }
}

bool Session::run(Renderer& renderer, bool is_last) {
  const bool is_done = renderer.run();
  if (is_last) end_patience();
  control_.clear();
  return is_done;
}

void Session::finish(RenderResult& result, const ResolvedScene& scene) const {
  result.picture.provenance = io::provenance(result);
  const auto added = result.warnings.begin() + std::ssize(scene.warnings);
  std::for_each(added, result.warnings.end(), on_warning);
}

io::Run Session::report(Renderer& renderer, const RenderResult& result, const io::SceneFile& file,
                        const std::string& scene) const {
  io::Run run{renderer.part(), result, scene, device_.name, file.volumes};
  say(io::report_lines(run));
  return run;
}

}  // namespace tyndall::session
