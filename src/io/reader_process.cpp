#include "io/reader_process.h"

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
#include <csignal>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "io/helper/protocol.h"
#include "render/startable_threads.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

[[noreturn]] void fail_for_memory(const std::string& path, const std::string& why) {
  throw Error(ExitCode::out_of_memory, fmt::format("{}: {}", path, why));
}

/// \return the limit of file descriptors; empty for unlimited.
std::string descriptor_limit() {
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "";
  return std::to_string(limit.rlim_cur);
}

/// \param error EMFILE, ENFILE or, from fcntl, EINVAL
[[noreturn]] void fail_for_descriptors(const std::string& path, int error) {
  if (error == ENFILE)
    fail_for_memory(path, "not read: too many files are open on this machine (sysctl fs.file-max)");
  fail_for_memory(path, fmt::format("not read: too few file descriptors: this process may have {} "
                                    "of them (ulimit -n): raise the limit",
                                    descriptor_limit()));
}

bool lacks_descriptors(int error) { return error == EMFILE || error == ENFILE; }

/// \return the folder of the program or shared library that contains this function.
fs::path own_folder() {
  Dl_info self{};
  void* map = nullptr;
  ::dladdr1(reinterpret_cast<const void*>(&own_folder), &self, &map, RTLD_DL_LINKMAP);
  // A program has no name there, and argv[0] is not a path if a shell looked it up.
  const char* library = map ? static_cast<const struct link_map*>(map)->l_name : "";
  if (*library != '\0') return fs::canonical(library).parent_path();
  // Unlike canonical(), this works even if the program's file has been replaced.
  return fs::read_symlink("/proc/self/exe").parent_path();
}

/// \return the path of a helper: beside the program or library, in the folder above it (for tests
/// of a build), or in an installation.
std::string helper_program(const char* name) {
  const fs::path bin = own_folder();
  std::vector<fs::path> folders{bin, bin.parent_path()};
#ifdef TYNDALL_HELPER_DIR
  folders.push_back((bin / TYNDALL_HELPER_DIR).lexically_normal());
#endif
  std::string looked;
  for (const fs::path& folder : folders) {
    if (::access((folder / name).c_str(), X_OK) == 0) return folder / name;
    looked += (looked.empty() ? "" : ", ") + folder.string();
  }
  throw Error(
      ExitCode::input_missing,
      fmt::format("{}, which reads {}, was not found in {}: build Tyndall with {} (`scripts/setup` "
                  "installs it), or install it anew",
                  name, name == image_helper ? "images" : "volumes", looked,
                  name == image_helper ? "OpenEXR" : "OpenVDB"));
}

/// Limits of the child: far more than any sound file of this size needs, even on a busy machine.
struct Limits {
  std::uint64_t memory;  ///< [byte]
  std::uint64_t cpu;     ///< processor time [s]
  std::uint64_t clock;   ///< wall-clock time [s]
};

/// \param voxels along the longest side of a mesh, 0 for other files. The cost of a mesh is
/// proportional to the area of its faces, which rarely exceeds 10 voxels^2.
Limits limits_for(std::uint64_t file_size, int voxels) {
  const std::uint64_t megabytes = file_size / 1000000;
  const auto square = static_cast<std::uint64_t>(voxels) * static_cast<std::uint64_t>(voxels);
  const std::uint64_t seconds = megabytes + square / 10000;
  return {(std::uint64_t{2} << 30) + 64 * file_size + 4096 * square, 6 + seconds, 8 + 4 * seconds};
}

/// Owns a child process: kills it unless wait() was called.
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
    struct rusage used {};
    while (::wait4(id_, &status, 0, &used) < 0 && errno == EINTR) {
    }
    id_ = -1;
    cpu_seconds_ = static_cast<std::uint64_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
    return status;
  }
  std::uint64_t cpu_seconds() const { return cpu_seconds_; }  ///< after wait()

 private:
  pid_t id_;
  std::uint64_t cpu_seconds_ = 0;
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

/// Moves a descriptor above the numbers that the child receives, so that dup2() to these numbers
/// does not close it.
Descriptor out_of_the_way(const std::string& path, Descriptor d) {
  if (d.number() > memory_descriptor) return d;
  Descriptor above(::fcntl(d.number(), F_DUPFD_CLOEXEC, memory_descriptor + 1));
  if (above.number() < 0) fail_for_descriptors(path, errno);
  return above;
}

pid_t spawn(const std::string& path, const std::vector<std::string>& words, int file, int report,
            int memory) {
  const std::string program = helper_program(words[0] == "image" ? image_helper : volume_helper);
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  SpawnActions spawn;
  ::posix_spawn_file_actions_adddup2(&spawn.actions, file, STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&spawn.actions, report, STDOUT_FILENO);
  ::posix_spawn_file_actions_addopen(&spawn.actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_adddup2(&spawn.actions, memory, memory_descriptor);
  // Other libraries of this process may have open files without close-on-exec.
  ::posix_spawn_file_actions_addclosefrom_np(&spawn.actions, memory_descriptor + 1);
  // The child starts with no signals blocked or ignored.
  sigset_t none, all;
  ::sigemptyset(&none);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&spawn.attributes, &none);
  ::posix_spawnattr_setsigdefault(&spawn.attributes, &all);
  ::posix_spawnattr_setflags(&spawn.attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t id = -1;
  const int error = ::posix_spawn(&id, program.c_str(), &spawn.actions, &spawn.attributes,
                                  arguments.data(), environ);
  if (error == EAGAIN || error == ENOMEM)
    fail_for_memory(path, fmt::format("its reader cannot be started: {}: too many processes are "
                                      "running (ulimit -u), or too little memory is free",
                                      std::strerror(error)));
  if (lacks_descriptors(error)) fail_for_descriptors(path, error);
  if (error != 0)
    throw Error(ExitCode::internal,
                fmt::format("{} cannot be started: {}", program, std::strerror(error)));
  return id;
}

/// Reads all output of the child, until it ends or `deadline`. \return whether it ended.
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

/// Replaces the descriptor path in a message: libraries name the file by the path that the helper
/// opens.
std::string with_name(std::string message, const std::string& path) {
  const std::string_view own = input_path;
  for (std::size_t at = 0; (at = message.find(own, at)) != message.npos; at += path.size())
    message.replace(at, own.size(), path);
  return message;
}

/// \return why the helper may fail for a sound file: inherited limits that are too low; empty if
/// they suffice.
std::string helper_shortage(std::uint64_t memory) {
  constexpr rlim_t of_helper = 16;  // descriptors, including those that libraries open
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < of_helper)
    return fmt::format(
        "its reader may have {} file descriptors (ulimit -n), which may be too few: raise the "
        "limit",
        limit.rlim_cur);
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY
      || limit.rlim_cur >= memory)
    return "";
  return fmt::format(
      "its reader may use {} MB (ulimit -v), which may be too little: raise the "
      "limit",
      limit.rlim_cur / 1000000);
}

}  // namespace

void fail_reading(const std::string& path, const std::string& why) {
  throw Error(ExitCode::input_missing, fmt::format("{}: {}", path, why));
}

void Descriptor::close() {
  if (number_ >= 0) ::close(std::exchange(number_, -1));
}

std::uint64_t Descriptor::size() const {
  struct stat status {};
  ::fstat(number_, &status);
  return static_cast<std::uint64_t>(status.st_size);
}

Descriptor open_input(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) fail_reading(path, "is a folder");
  Descriptor file = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) {
    if (lacks_descriptors(errno)) fail_for_descriptors(path, errno);
    const bool is_numbered = path.find("##") != path.npos;
    fail_reading(path, errno != ENOENT ? std::strerror(errno)
                       : is_numbered
                           ? "no such file; ## is a frame's number: name frames with --frames"
                           : "no such file");
  }
  struct stat status {};
  if (::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode))
    fail_reading(path, "is no regular file");
  return out_of_the_way(path, std::move(file));
}

Descriptor memory_file(const std::string& path) {
  Descriptor file(::memfd_create("tyndall-memory", MFD_CLOEXEC));
  if (file.number() < 0) {
    if (lacks_descriptors(errno)) fail_for_descriptors(path, errno);
    fail_for_memory(path, fmt::format("no memory file for it: {}", std::strerror(errno)));
  }
  return out_of_the_way(path, std::move(file));
}

std::string cut(const std::string& text, std::size_t most) {
  return text.size() <= most ? text : text.substr(0, most) + "...";
}

Json call_helper(const std::string& path, const Descriptor& file, const Descriptor& memory,
                 std::vector<std::string> words, int voxels) {
  const Limits limits = limits_for(file.size(), voxels);
  words.insert(words.begin() + 1, {std::to_string(limits.memory), std::to_string(limits.cpu)});

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail_for_descriptors(path, errno);
  Descriptor ends_of_pipe[] = {Descriptor(ends[0]), Descriptor(ends[1])};
  const Descriptor output = out_of_the_way(path, std::move(ends_of_pipe[0]));
  Descriptor input = out_of_the_way(path, std::move(ends_of_pipe[1]));
  Child child(spawn(path, words, file.number(), input.number(), memory.number()));
  input.close();

  // If resources are short, that is reported as the cause, whatever the error of the reader.
  const std::string shortage = helper_shortage(limits.memory);
  const auto refuse = [&](const std::string& why) {
    if (!shortage.empty()) fail_for_memory(path, fmt::format("not read: {}", shortage));
    constexpr int of_helper = 8;  // threads, including those that libraries start
    if (startable_threads(of_helper) < of_helper)
      fail_for_memory(path,
                      "not read: the system starts too few threads: raise the limit of "
                      "processes (ulimit -u)");
    fail_reading(path, why);
  };
  std::string text;
  const auto deadline = Clock::now() + std::chrono::seconds(limits.clock);
  const bool ended = read_report(output.number(), deadline, text);
  if (!ended && voxels > 0)
    refuse(
        fmt::format("{} voxels took longer than {} s: given up; if the machine is busy, try "
                    "again, or lower \"voxels\"",
                    voxels, limits.clock));
  if (!ended)
    refuse(
        fmt::format("damaged, or too slow to read: given up after {} s; if the machine is "
                    "busy, try again",
                    limits.clock));
  const int result = child.wait();
  if (WIFSIGNALED(result)) {
    const int signal = WTERMSIG(result);
    if (signal == SIGXFSZ)
      throw Error(ExitCode::output_failed,
                  fmt::format("{}: its contents exceed the size limit of files, which applies to "
                              "memory files too (ulimit -f)",
                              path));
    if (signal == SIGKILL && child.cpu_seconds() + 1 < limits.cpu)
      fail_for_memory(path, "its reader was killed; the system does this when memory runs out");
    if (voxels > 0 && (signal == SIGXCPU || signal == SIGKILL))
      refuse(fmt::format("{} voxels took more than {} s of processor time; lower \"voxels\"",
                         voxels, limits.cpu));
    if (signal == SIGXCPU || signal == SIGKILL)
      refuse(fmt::format(
          "damaged: reading it took more than {} s of processor time and was stopped", limits.cpu));
    refuse(
        fmt::format("damaged: the library that reads it crashed ({}); the renderer itself is "
                    "unaffected",
                    signal_name(signal)));
  }
  Json report = Json::parse(text, nullptr, false);
  if (WEXITSTATUS(result) != 0 || !report.is_object())
    refuse("damaged: the library that reads it failed without a message");
  if (report.contains("message")) report["message"] = with_name(report.value("message", ""), path);
  const std::string kind = report.value("error", "");
  if (!shortage.empty() && (kind == error_memory || kind == error_damaged))
    fail_for_memory(
        path, fmt::format("not read ({}): {}", cut(report.value("message", ""), 200), shortage));
  return report;
}

}  // namespace tyndall::io
