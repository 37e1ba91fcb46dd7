// tyndall-image and tyndall-vdb: see io/helper/protocol.h.
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "io/helper/input.h"
#include "io/helper/protocol.h"
#if TYNDALL_READS_IMAGES
#include "io/helper/images.h"
#else
#include <tbb/global_control.h>

#include "io/helper/nanovdb_grids.h"
#include "io/helper/openvdb_grids.h"
#include "render/startable_threads.h"
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define COUNT_ALLOCATIONS 1
#endif

// ---- Memory. Sanitizers reserve terabytes of address space, so allocations are counted instead.

#if COUNT_ALLOCATIONS
namespace {
std::atomic<std::int64_t> free_bytes{INT64_MAX};

void* counted(std::size_t bytes) {
  if (bytes > INT64_MAX || (free_bytes -= static_cast<std::int64_t>(bytes)) < 0)
    throw std::bad_alloc();
  if (void* p = std::malloc(bytes > 0 ? bytes : 1)) return p;
  throw std::bad_alloc();
}
}  // namespace
// The limit is on the sum of all allocations: freed memory is not subtracted.
void* operator new(std::size_t bytes) { return counted(bytes); }
void* operator new[](std::size_t bytes) { return counted(bytes); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return std::malloc(bytes > 0 ? bytes : 1);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return std::malloc(bytes > 0 ? bytes : 1);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
#endif

namespace tyndall::io {
namespace {

#if TYNDALL_READS_IMAGES

Json run(const std::vector<std::string>&) { return read_image(); }

#else

/// \return the index of the grid `wanted`, or else of the one named `fallback`; nullopt if it is
/// missing and `may_be_absent`. The unique name "density[1]" has priority over the plain name.
/// \throws Failure if the choice is missing or ambiguous
std::optional<std::size_t> choose(const Json& grids, const std::string& fallback,
                                  const std::string* wanted, bool may_be_absent) {
  const auto fail = [&](const std::string& message) {
    throw Failure{error_choice, message, grids};
  };
  const std::string& name = wanted ? *wanted : fallback;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (wanted && grids[i]["unique_name"] == name) return i;
    const std::string type = grids[i]["type"];
    if (grids[i]["name"] == name && (wanted || is_numeric(type) || is_color(type)))
      found.push_back(i);
  }
  if (found.size() == 1) return found[0];
  if (found.empty() && may_be_absent) return std::nullopt;
  const std::string quoted =
      Json(name.substr(0, 100)).dump(-1, ' ', false, Json::error_handler_t::replace);
  if (grids.empty()) fail("nothing to render: it has no grids");
  if (found.empty()) fail(fmt::format("it has no grid {}", quoted));
  fail(fmt::format("{} grids are named {}", found.size(), quoted));
  return std::nullopt;
}

/// \throws Failure that names the format if the file is not a VDB (a NanoVDB if `nano`).
void require_format(bool nano) {
  const std::uint64_t size = input_size();
  std::string head(std::min<std::uint64_t>(size, 512), '\0');
  read_at(0, head.data(), head.size());
  const auto begins = [&](std::string_view magic) {
    return std::string_view(head).substr(0, magic.size()) == magic;
  };
  const bool is_vdb = begins(std::string_view(" BDV\0\0\0\0", 8)), is_nano = begins("NanoVDB");
  if (nano ? is_nano : is_vdb) return;
  const char* what = "of an unknown format";
  if (size == 0)
    what = "an empty file";
  else if (begins("version https://git-lfs"))
    what = "a Git LFS pointer: `git lfs pull` fetches the file itself";
  else if (is_nano)
    what = "a NanoVDB file: name it .nvdb";
  else if (is_vdb)
    what = "an OpenVDB file: name it .vdb";
  else if (begins("\x1f\x8b"))
    what = "packed by gzip: unpack it first";
  else if (begins("PK"))
    what = "a zip archive: unpack it first";
  else if (begins("\x76\x2f\x31\x01"))
    what = "an OpenEXR picture";
  else if (begins("\x89PNG"))
    what = "a PNG picture";
  else if (begins("\x89HDF"))
    what = "an HDF5 file";
  else if (std::string_view("\0\0\0\0 BDV", 8).substr(4) == std::string_view(head).substr(0, 4))
    what = "too short, or its header is damaged";
  else if (std::all_of(head.begin(), head.end(), [](char c) {
             return static_cast<unsigned char>(c) >= ' ' || c == '\n' || c == '\r' || c == '\t';
           }))
    what = "a text file";
  throw Failure{error_format, what};
}

/// \return the memory that this program may use and the machine has free [byte].
std::uint64_t available_memory(const std::string& limit) {
  std::uint64_t available = std::strtoull(limit.c_str(), nullptr, 10);
  struct rlimit space {};
  if (::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
    available = std::min<std::uint64_t>(available, space.rlim_cur);
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  for (std::uint64_t kibibytes = 0; file >> key >> kibibytes; std::getline(file, unit))
    if (key == "MemAvailable:") available = std::min(available, kibibytes * 1024);
  return available;
}

/// Lists a file's grids, or loads one of them.
template <class File>
Json read_grids(File&& file, const std::vector<std::string>& words) {
  Json report{{"grids", file.grids()}, {"metadata", file.metadata()}};
  if (words[0] == "load" || words[0] == "load-any") {
    const std::string* wanted = words.size() > 5 ? &words[5] : nullptr;
    const auto chosen = choose(file.grids(), words.at(4), wanted, words[0] == "load-any");
    if (!chosen) {
      report["loaded"] = grid_without_voxels();
      report["absent"] = true;
      return report;
    }
    const std::string type = file.grids()[*chosen]["type"];
    if (!is_numeric(type) && !is_color(type))
      throw Failure{error_choice, fmt::format("values of type {} are no densities", type),
                    file.grids()};
    report["loaded"] = file.load(*chosen);
  }
  return report;
}

Json run(const std::vector<std::string>& words) {
  // oneTBB hangs or aborts if it cannot start a thread.
  const tbb::global_control few(tbb::global_control::max_allowed_parallelism,
                                static_cast<std::size_t>(startable_threads(8)));
  if (words[0] == "mesh")
    return Json{{"loaded", voxelize(std::atoi(words.at(3).c_str()), available_memory(words[1]))}};
  const bool nano = words.at(3) == "nvdb";
  if (words[0] == "write") return write_grids(nano);
  require_format(nano);
  return nano ? read_grids(NanoFile(), words) : read_grids(VdbFile(), words);
}
#endif

void limit(std::uint64_t memory, std::uint64_t seconds) {
  const auto set = [](int what, std::uint64_t value) {
    const struct rlimit bound { value, value };
    ::setrlimit(static_cast<__rlimit_resource>(what), &bound);
  };
  set(RLIMIT_CPU, seconds);
  set(RLIMIT_CORE, 0);
#if COUNT_ALLOCATIONS
  free_bytes = static_cast<std::int64_t>(memory);
#else
  set(RLIMIT_AS, memory);
#endif
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // do not outlive the parent
}

/// \return the peak resident size of this program [byte]. The parent cannot use ru_maxrss, which
/// includes the parent's own size from before exec.
std::uint64_t peak_resident() {
  std::ifstream file("/proc/self/status");
  std::string key, rest;
  for (std::uint64_t kibibytes = 0; file >> key; std::getline(file, rest))
    if (key == "VmHWM:" && file >> kibibytes) return kibibytes * 1024;
  return 0;
}

int respond(const Json& report) {
  const std::string text = report.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(STDOUT_FILENO, text.data() + done, text.size() - done);
    if (n <= 0) return 1;
    done += static_cast<std::size_t>(n);
  }
  return 0;
}

}  // namespace
}  // namespace tyndall::io

int main(int argc, char** argv) {
  using namespace tyndall::io;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 3) {
    ::dprintf(STDERR_FILENO, "%s: a part of Tyndall, for its own use\n", argv[0]);
    return 2;
  }
  limit(std::strtoull(words[1].c_str(), nullptr, 10), std::strtoull(words[2].c_str(), nullptr, 10));
  Json report;
  const auto failed = [&](const char* kind, const std::string& message) {
    report["error"] = kind;
    report["message"] = message;
  };
  try {
    report = run(words);
    report["resident"] = peak_resident();
  } catch (const Failure& failure) {
    failed(failure.kind, failure.message);
    report["grids"] = failure.grids;
  } catch (const std::bad_alloc&) {
    failed(error_memory, too_much_memory);
  } catch (const std::exception& error) {
    failed(error_damaged, error.what());
  }
  return respond(report);
}
