#include "session/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

#include <fmt/format.h>

namespace tyndall::session {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

std::uint64_t machine() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  for (std::uint64_t kibibytes = 0; file >> key >> kibibytes; std::getline(file, unit))
    if (key == "MemAvailable:") return kibibytes * 1024;
  return unlimited;
}

/// Control groups, version 2. Beyond their limit the kernel kills the process without a message.
std::uint64_t control_group() {
  std::string path;
  std::getline(std::ifstream("/proc/self/cgroup"), path);
  if (path.rfind("0::", 0) != 0) return unlimited;
  const std::string folder = "/sys/fs/cgroup" + path.substr(3);
  std::uint64_t limit = 0;
  if (!(std::ifstream(folder + "/memory.max") >> limit)) return unlimited;  // "max" is no number
  // Not memory.current: it counts cached files, too, which the kernel can drop.
  std::ifstream file(folder + "/memory.stat");
  std::string key;
  for (std::uint64_t bytes = 0; file >> key >> bytes;)
    if (key == "anon") return limit - std::min(limit, bytes);
  return unlimited;
}

std::uint64_t address_space() {
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const std::uint64_t used = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used);
}

}  // namespace

std::uint64_t available_memory() { return std::min({machine(), control_group(), address_space()}); }

std::string memory_shortage(const ResolvedScene& scene, int lights) {
  const std::uint64_t needed = scene.memory(lights), available = available_memory();
  if (needed <= available) return "";
  constexpr double gibibyte = 1024.0 * 1024.0 * 1024.0;
  return fmt::format(
      "the render needs {:.3g} GiB of memory, {:.3g} GiB are available; lower camera.resolution or "
      "the resolutions of the grids",
      static_cast<double>(needed) / gibibyte, static_cast<double>(available) / gibibyte);
}

}  // namespace tyndall::session
