#include "session/devices.h"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "session/console.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall::session {
namespace {

#if TYNDALL_CUDA
CudaDevices known_cuda_devices() { return cuda_devices(); }
#else
CudaDevices known_cuda_devices() { return {{}, "this build has no CUDA"}; }
std::unique_ptr<Backend> make_cuda_backend(int) {
  throw Error(ExitCode::device, "this build has no CUDA; use --device cpu");
}
#endif

Device cpu(int threads) { return {make_cpu_backend(threads), "cpu"}; }

Device cuda(int index) {
  if (index != DeviceName::all) return {make_cuda_backend(index), fmt::format("cuda:{}", index)};
  std::vector<std::unique_ptr<Backend>> backends;
  std::vector<int> indices;
  const int count = std::max(1, cuda_device_count());  // no device: throws for device 0
  for (int i = 0; i < count; ++i) {
    try {
      backends.push_back(make_cuda_backend(i));
      indices.push_back(i);
    } catch (const Error& error) {
      if (i + 1 == count && backends.empty()) throw;
      warn(fmt::format("cuda:{} is left out: {}", i, error.what()));
    }
  }
  return {make_combined_backend(std::move(backends)),
          fmt::format("cuda:{}", fmt::join(indices, "+"))};
}

}  // namespace

DeviceName parse_device(const std::string& text) {
  if (text == "auto") return {};
  if (text == "cpu") return {DeviceName::Kind::cpu};
  DeviceName device{DeviceName::Kind::cuda};
  if (text == "cuda") return device;
  const char* end = text.data() + text.size();
  if (text.starts_with("cuda:")) {
    const auto [stop, error] = std::from_chars(text.data() + 5, end, device.index);
    if (error == std::errc() && stop == end && device.index >= 0) return device;
  }
  throw Error(ExitCode::usage,
              fmt::format("--device: expected auto, cpu, cuda or cuda:N, got '{}'", text));
}

Device open_device(const DeviceName& name, int threads, const std::string& why_not_automatic) {
  if (name.kind == DeviceName::Kind::cpu) return cpu(threads);
  if (name.kind == DeviceName::Kind::cuda) return cuda(name.index);
  std::string problem = why_not_automatic;
#if TYNDALL_CUDA
  if (problem.empty()) {
    try {
      const CudaDevices devices = known_cuda_devices();
      if (!devices.names.empty()) {
        Device device = cuda(DeviceName::all);
        say(fmt::format("device   {}\n", device.backend->name()));
        return device;
      }
      problem = devices.problem;
    } catch (const Error& error) {
      problem = error.what();
    }
  }
#else
  if (problem.empty()) return cpu(threads);  // the only device
#endif
  Device device = cpu(threads);
  say(fmt::format("device   {}, for want of another: {}\n", device.backend->name(), problem));
  return device;
}

int cuda_device_count() { return static_cast<int>(known_cuda_devices().names.size()); }

std::string list_devices() {
  std::string list = fmt::format("{:<8} {}; {}\n", "cpu", make_cpu_backend()->name(),
                                 fmt::join(instruction_sets(), ", "));
  const CudaDevices devices = known_cuda_devices();
  for (std::size_t i = 0; i < devices.names.size(); ++i)
    list += fmt::format("{:<8} {}\n", fmt::format("cuda:{}", i), devices.names[i]);
  if (devices.names.empty()) list += fmt::format("{:<8} none: {}\n", "cuda", devices.problem);
  return list;
}

}  // namespace tyndall::session
