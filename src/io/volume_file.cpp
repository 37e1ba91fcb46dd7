#include "io/volume_file.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "io/helper/protocol.h"
#include "io/json_text.h"
#include "tyndall/render/check.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { close(); }
  void close() {
    if (number_ >= 0) ::close(std::exchange(number_, -1));
  }
  int number() const { return number_; }

 private:
  int number_;
};

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw Error(ExitCode::input_missing, fmt::format("{}: {}", path, why));
}

// ---- The helper

/// Of the program or shared library that this is part of.
fs::path own_folder() {
  Dl_info self{};
  void* map = nullptr;
  ::dladdr1(reinterpret_cast<const void*>(&own_folder), &self, &map, RTLD_DL_LINKMAP);
  // A program has no name there, and what it was called is no path where a shell looked it up.
  const char* library = map ? static_cast<const struct link_map*>(map)->l_name : "";
  if (*library != '\0') return fs::canonical(library).parent_path();
  // Unlike canonical(), this works also where a new program has taken its place since.
  return fs::read_symlink("/proc/self/exe").parent_path();
}

/// Beside the program (or library), in the folder above it (the tests of a build), or where an
/// installation puts it.
std::string helper_program() {
  const fs::path bin = own_folder();
  std::vector<fs::path> folders{bin, bin.parent_path()};
#ifdef TYNDALL_HELPER_DIR
  folders.push_back((bin / TYNDALL_HELPER_DIR).lexically_normal());
#endif
  std::string looked;
  for (const fs::path& folder : folders) {
    if (::access((folder / helper_name).c_str(), X_OK) == 0) return folder / helper_name;
    looked += (looked.empty() ? "" : ", ") + folder.string();
  }
  throw Error(
      ExitCode::input_missing,
      fmt::format("{}, which reads volumes, was not found in {}: build Tyndall with OpenVDB "
                  "(`scripts/setup` installs it), or install it anew",
                  helper_name, looked));
}

/// What the child may take: far more than any sound file of this size needs, also where others keep
/// the processors busy.
struct Limits {
  std::uint64_t memory;  ///< [byte]
  std::uint64_t cpu;     ///< [s] of processor time
  std::uint64_t clock;   ///< [s]
};

/// \param voxels along the longest side of a mesh: what it takes follows the area of its faces, of
/// which few have more than ten times the square of that. 0: no mesh
Limits limits_for(std::uint64_t file_size, int voxels) {
  const std::uint64_t megabytes = file_size / 1000000;
  const auto square = static_cast<std::uint64_t>(voxels) * static_cast<std::uint64_t>(voxels);
  const std::uint64_t seconds = megabytes + square / 10000;
  return {(std::uint64_t{2} << 30) + 64 * file_size + 4096 * square, 6 + seconds, 8 + 4 * seconds};
}

/// Waits for a child; kills it when nobody waits any longer.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    wait();
  }

  int wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
  }

 private:
  pid_t id_;
};

struct SpawnActions {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;

  SpawnActions() {
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawnattr_init(&attributes);
  }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  ~SpawnActions() {
    ::posix_spawn_file_actions_destroy(&actions);
    ::posix_spawnattr_destroy(&attributes);
  }
};

/// A number above those that the child is given, lest giving one closes another.
Descriptor out_of_the_way(Descriptor d) {
  return Descriptor(::fcntl(d.number(), F_DUPFD_CLOEXEC, grid_descriptor + 1));
}

pid_t spawn(const std::vector<std::string>& words, int file, int report, int grid) {
  const std::string program = helper_program();
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  SpawnActions spawn;
  ::posix_spawn_file_actions_adddup2(&spawn.actions, file, STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&spawn.actions, report, STDOUT_FILENO);
  ::posix_spawn_file_actions_addopen(&spawn.actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_adddup2(&spawn.actions, grid, grid_descriptor);
  // Other libraries of this process may have files open for inheritance.
  ::posix_spawn_file_actions_addclosefrom_np(&spawn.actions, grid_descriptor + 1);
  // No signal that this process blocks or ignores is so in the child.
  sigset_t none, all;
  ::sigemptyset(&none);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&spawn.attributes, &none);
  ::posix_spawnattr_setsigdefault(&spawn.attributes, &all);
  ::posix_spawnattr_setflags(&spawn.attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t id = -1;
  const int error = ::posix_spawn(&id, program.c_str(), &spawn.actions, &spawn.attributes,
                                  arguments.data(), environ);
  if (error != 0)
    throw Error(ExitCode::internal,
                fmt::format("{} cannot be started: {}", program, std::strerror(error)));
  return id;
}

/// All that the child writes, until it ends or `deadline`. \return whether it ended.
bool read_report(int from, Clock::time_point deadline, std::string& text) {
  constexpr std::size_t most = std::size_t{64} << 20;
  char block[1 << 16];
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0 || text.size() > most) return false;
    struct pollfd waiting {
      from, POLLIN, 0
    };
    if (::poll(&waiting, 1, static_cast<int>(std::min<long>(left, 1000))) <= 0) continue;
    const ssize_t n = ::read(from, block, sizeof block);
    if (n == 0) return true;
    if (n > 0) text.append(block, static_cast<std::size_t>(n));
  }
}

std::string signal_name(int signal) {
  const char* name = ::sigabbrev_np(signal);
  return name ? fmt::format("SIG{}", name) : fmt::format("signal {}", signal);
}

/// Calls the helper. \return its object. \throws Error where it fails, with what is known of the
/// reason.
Json call_helper(const std::string& path, const Descriptor& file, const Descriptor& grid,
                 std::vector<std::string> words, int voxels = 0) {
  struct stat status {};
  ::fstat(file.number(), &status);
  const Limits limits = limits_for(static_cast<std::uint64_t>(status.st_size), voxels);
  words.insert(words.begin() + 1, {std::to_string(limits.memory), std::to_string(limits.cpu)});

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw Error(ExitCode::internal, fmt::format("no pipe: {}", std::strerror(errno)));
  const Descriptor output = out_of_the_way(Descriptor(ends[0]));
  Descriptor input = out_of_the_way(Descriptor(ends[1]));
  Child child(spawn(words, file.number(), input.number(), grid.number()));
  input.close();

  std::string text;
  const auto deadline = Clock::now() + std::chrono::seconds(limits.clock);
  const bool ended = read_report(output.number(), deadline, text);
  if (!ended && voxels > 0)
    fail(path, fmt::format("{} voxels took longer than {} s: given up; where the machine is busy, "
                           "try again, or lower \"voxels\"",
                           voxels, limits.clock));
  if (!ended)
    fail(path, fmt::format("damaged, or too slow to read: given up after {} s; where the machine "
                           "is busy, try again",
                           limits.clock));
  const int result = child.wait();
  if (WIFSIGNALED(result)) {
    const int signal = WTERMSIG(result);
    if (voxels > 0 && (signal == SIGXCPU || signal == SIGKILL))
      fail(path, fmt::format("{} voxels took more than {} s of processor time, or more memory than "
                             "there is; lower \"voxels\"",
                             voxels, limits.cpu));
    if (signal == SIGXCPU || signal == SIGKILL)
      fail(path, fmt::format("damaged: reading it took more than {} s of processor time, or more "
                             "memory than there is, and was ended",
                             limits.cpu));
    fail(path, fmt::format("damaged: the library that reads it crashed ({}); nothing else came to "
                           "harm",
                           signal_name(signal)));
  }
  Json report = Json::parse(text, nullptr, false);
  if (WEXITSTATUS(result) != 0 || !report.is_object())
    fail(path, "damaged: the library that reads it failed without a word");
  return report;
}

// ---- What the helper says

std::string cut(const std::string& text, std::size_t most = 60) {
  return text.size() <= most ? text : text.substr(0, most) + "...";
}

std::string quoted_whole(const std::string& name) {
  return Json(name).dump(-1, ' ', false, Json::error_handler_t::replace);
}
std::string quoted(const std::string& name) { return quoted_whole(cut(name)); }

/// "density" (float, fog volume, 4224 voxels), ...
std::string listed(const Json& grids) {
  std::string text;
  std::size_t shown = 0;
  for (const Json& grid : grids) {
    if (++shown > 20) return text + fmt::format(", and {} more", grids.size() - 20);
    text += text.empty() ? "" : ", ";
    text += quoted(grid.value("unique_name", "")) + " (" + cut(grid.value("type", "?"), 30);
    if (const std::string name = grid.value("class", ""); !name.empty() && name != "unknown")
      text += ", " + name;
    if (grid.contains("voxels"))
      text += fmt::format(", {} voxels", grid["voxels"].get<std::uint64_t>());
    text += ")";
  }
  return text;
}

/// What to write, where one of the grids would do.
std::string remedy(const Json& grids) {
  for (const Json& grid : grids) {
    const std::string type = grid.value("type", "");
    const bool good = is_numeric(type);
    const std::string name = grid.value("unique_name", "");
    if (good && name.size() > 200)
      return fmt::format("; write \"grid\" and the whole name, of {} bytes", name.size());
    if (good) return fmt::format("; write \"grid\": {}", quoted_whole(name));
  }
  return "; none of them can be a density (a grid of floats)";
}

[[noreturn]] void fail_as_reported(const std::string& path, const Json& report) {
  const std::string kind = report.value("error", ""), message = report.value("message", "");
  const char* format = fs::path(path).extension() == ".nvdb" ? "NanoVDB" : "VDB";
  if (kind == error_format) {
    if (message.find("version") != message.npos)  // one of the helper's own
      fail(path, message);
    fail(path, fmt::format("not a {} file: {}", format, message));
  }
  if (kind == error_choice) {
    const Json grids = report.value("grids", Json::array());
    if (grids.empty()) fail(path, message);
    fail(path, fmt::format("{}; its grids: {}{}", message, listed(grids), remedy(grids)));
  }
  if (kind == error_memory && fs::path(path).extension() == ".obj")
    fail(path, "too large: " + message);
  if (kind == error_memory) fail(path, "damaged, or too large: " + message);
  fail(path, "damaged: " + cut(message, 300));
}

// ---- Files

Descriptor open_file(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) fail(path, "is a folder");
  Descriptor file = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) {
    const bool is_numbered = path.find("##") != path.npos;
    fail(path, errno != ENOENT ? std::strerror(errno)
               : is_numbered   ? "no such file; ## is a frame's number: name frames with --frames"
                               : "no such file");
  }
  struct stat status {};
  if (::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode))
    fail(path, "is no regular file");
  return out_of_the_way(std::move(file));
}

Descriptor memory_file() {
  Descriptor file(::memfd_create("tyndall-grid", MFD_CLOEXEC));
  if (file.number() < 0)
    throw Error(ExitCode::internal, fmt::format("no memory file: {}", std::strerror(errno)));
  return out_of_the_way(std::move(file));
}

/// The grid that the helper left in the memory file. \throws Error, DamagedVolume
std::shared_ptr<const Volume> adopt(const Descriptor& memory, const Json& loaded) {
  struct stat status {};
  ::fstat(memory.number(), &status);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0 || loaded.value("grid_bytes", std::uint64_t{0}) > size)
    throw DamagedVolume("no grid came back from it");
  void* p = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memory.number(), 0);
  if (p == MAP_FAILED) throw std::bad_alloc();
  const std::shared_ptr<std::byte> bytes(static_cast<std::byte*>(p),
                                         [size](std::byte* b) { ::munmap(b, size); });
  if (loaded.value("checksum", "") != checksum(bytes.get(), size))
    throw DamagedVolume("the grid that came back from it is not the one that was sent");
  return std::make_shared<const Volume>(bytes, size);
}

void add_warnings(const Json& loaded, LoadedVolume& out) {
  const auto warn = [&](const char* key, const std::string& what) {
    if (const auto n = loaded.value(key, std::uint64_t{0}); n > 0)
      out.warnings.push_back(
          fmt::format("{} of {} active voxels {}", n, out.volume->active_voxels(), what));
  };
  warn("not_numbers", "are no numbers (NaN): taken as 0");
  const double most = loaded.value("most", 0.0);
  warn("huge", fmt::format("are infinite or beyond 1e12: taken as {:.4g}{}", most,
                           static_cast<float>(most) < 1e12f ? ", the largest of the others" : ""));
  if (loaded.value("strange_background", false))
    out.warnings.push_back("the background is no number or beyond 1e12: taken as 0");
}

/// A wall that interpolated distances would lose is kept as what it fills of the voxels.
std::string thin_walls(double share, double width, int voxels) {
  const double wanted = std::ceil(1.5 * voxels / width);
  return fmt::format(
      "{:.2g} % of its faces bound walls thinner than a voxel and a half: the density is what is "
      "filled of each voxel, and blurs its faces by one; {}",
      100 * share,
      limits::mesh_voxels.contains(wanted)
          ? fmt::format("\"voxels\": {:.0f} keeps them sharp", wanted)
          : fmt::format("no \"voxels\" up to {:.0f} keeps them sharp", limits::mesh_voxels.high));
}

/// \param voxels see limits_for()
LoadedVolume load(const std::string& path, std::vector<std::string> words,
                  Emptiness emptiness = Emptiness::refused, int voxels = 0) {
  const auto start = Clock::now();
  const Descriptor file = open_file(path), memory = memory_file();
  const Json report = call_helper(path, file, memory, std::move(words), voxels);
  if (report.contains("error")) fail_as_reported(path, report);
  const Json loaded = report.value("loaded", Json::object());
  LoadedVolume out;
  out.path = path;
  out.child_memory = report.value("resident", std::uint64_t{0});
  out.is_open = !loaded.value("closed", true);
  if (out.is_open)
    out.warnings.push_back(
        "an open mesh: a shell two voxels thick along its faces, nothing within");
  if (const double share = loaded.value("thin_walls", 0.0); share > 0)
    out.warnings.push_back(thin_walls(share, loaded.value("thin_width", 1.0), voxels));
  try {
    out.volume = adopt(memory, loaded);
  } catch (const DamagedVolume& damage) {
    fail(path, std::string("damaged: ") + damage.what());
  }
  add_warnings(loaded, out);
  const Volume& v = *out.volume;
  out.is_absent = report.value("absent", false);
  if (v.active_voxels() == 0 && emptiness == Emptiness::refused)
    fail(path, fmt::format("nothing to render: grid {} has no active voxels", quoted(v.name())));
  // Densities are clamped by the remap unless that makes them positive.
  if (const auto n = loaded.value("negative", std::uint64_t{0}); n > 0 && !v.is_level_set())
    out.warnings.push_back(fmt::format(
        "{} of {} active voxels are negative, down to {:.4g}: {}", n, v.active_voxels(),
        v.minimum(), v.is_color() ? "taken as black" : "where a remap leaves them so, taken as 0"));
  out.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return out;
}

std::string format_of(const std::string& path) {
  return fs::path(path).extension() == ".nvdb" ? "nvdb" : "vdb";
}

}  // namespace

LoadedVolume load_volume(const std::string& path, const std::string& fallback,
                         const std::optional<std::string>& grid, Emptiness emptiness) {
  std::vector<std::string> words{emptiness == Emptiness::allowed ? "load-any" : "load",
                                 format_of(path), fallback};
  if (grid) words.push_back(*grid);
  return load(path, std::move(words), emptiness);
}

LoadedVolume load_mesh(const std::string& path, int voxels) {
  return load(path, {"mesh", std::to_string(voxels)}, Emptiness::refused, voxels);
}

VolumeContents list_grids(const std::string& path) {
  const Descriptor file = open_file(path), memory = memory_file();
  const Json report = call_helper(path, file, memory, {"list", format_of(path), ""});
  if (report.contains("error")) fail_as_reported(path, report);
  using Texts = std::map<std::string, std::string>;
  VolumeContents contents;
  contents.metadata = report.value("metadata", Texts());
  for (const Json& grid : report.value("grids", Json::array())) {
    contents.grids.push_back({grid.value("unique_name", ""), grid.value("type", ""),
                              grid.value("class", ""), grid.value("voxels", std::uint64_t{0}),
                              grid.value("transform", std::vector<double>{}),
                              grid.value("metadata", Texts())});
  }
  return contents;
}

std::string encode_grids(const std::string& path, bool nano, const std::vector<GridToWrite>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata,
                         bool half) {
  const auto bytes_of = [](const GridToWrite& grid) {
    if (grid.stored) return grid.stored->size();
    return sizeof(float) * static_cast<std::size_t>(grid.channels)
           * static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1])
           * static_cast<std::size_t>(grid.size[2]);
  };
  Json header{{"half", half}, {"metadata", Json::object()}, {"grids", Json::array()}};
  for (const auto& [key, text] : metadata) header["metadata"][key] = text;
  std::uint64_t at = 0;
  for (const GridToWrite& grid : grids) {
    Json rows = Json::array();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) rows.push_back(grid.to_world[column][row]);
    Json entry{{"name", grid.name}, {"channels", grid.channels}, {"transform", rows}, {"at", at}};
    if (grid.stored)
      entry["bytes"] = bytes_of(grid), entry["scale"] = grid.scale;
    else
      entry["size"] = grid.size;
    header["grids"].push_back(entry);
    at += bytes_of(grid);
  }
  const std::string text = header.dump();
  const std::uint64_t length = text.size();

  const Descriptor parcel = memory_file(), written = memory_file();
  const auto put = [&](const void* from, std::size_t size) {
    const char* bytes = static_cast<const char*>(from);
    while (size > 0) {
      const ssize_t n = ::write(parcel.number(), bytes, size);
      if (n <= 0) throw std::bad_alloc();
      bytes += n;
      size -= static_cast<std::size_t>(n);
    }
  };
  put(&length, sizeof length);
  put(text.data(), text.size());
  for (const GridToWrite& grid : grids)
    put(grid.stored ? static_cast<const void*>(grid.stored->bytes()) : grid.values, bytes_of(grid));

  const auto fail_writing = [&](const std::string& why) {
    throw Error(ExitCode::output_failed,
                fmt::format("{}: {} could not write it: {}", path, helper_name, why));
  };
  Json report;
  try {
    report = call_helper(path, parcel, written, {"write", nano ? "nvdb" : "vdb"});
  } catch (const Error& error) {
    fail_writing(error.what());
  }
  if (report.contains("error")) fail_writing(report.value("message", ""));
  struct stat status {};
  ::fstat(written.number(), &status);
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::pread(written.number(), bytes.data() + done, bytes.size() - done,
                              static_cast<off_t>(done));
    if (n <= 0) fail_writing(std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

bool is_volume_file(const std::string& path) {
  const fs::path extension = fs::path(path).extension();
  return extension == ".vdb" || extension == ".nvdb";
}

}  // namespace tyndall::io
