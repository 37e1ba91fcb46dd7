#include "io/output_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view temporary_prefix = ".tyndall-", temporary_suffix = ".tmp";

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw Error(ExitCode::output_failed, fmt::format("{}: cannot be written: {}", path, reason));
}

[[noreturn]] void fail(const std::string& path, const char* step, int error) {
  fail(path, fmt::format("{}: {}", step, std::generic_category().message(error)));
}

// ---- Temporaries that a signal handler can find: no allocation, no locks. ----

struct Slot {
  std::atomic<int> state{0};  // 0 free, 1 being filled, 2 filled
  std::array<char, PATH_MAX> path{};
};
static_assert(std::atomic<int>::is_always_lock_free);

std::array<Slot, 16> slots;

/// \return a slot, or -1 if none is free. Without a slot, the only harm is that a second signal
/// leaves the temporary behind.
int remember(const std::string& temporary) {
  if (temporary.size() >= PATH_MAX) return -1;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    int expected = 0;
    if (!slots[i].state.compare_exchange_strong(expected, 1)) continue;
    std::memcpy(slots[i].path.data(), temporary.c_str(), temporary.size() + 1);
    slots[i].state = 2;
    return static_cast<int>(i);
  }
  return -1;
}

void forget(int slot) {
  if (slot >= 0) slots[static_cast<std::size_t>(slot)].state = 0;
}

// ---- Targets. ----

/// \return the descriptor of /dev/stdout, /dev/stderr or /dev/fd/N. If standard output is a file,
/// opening it by name would overwrite it from its beginning.
std::optional<int> named_descriptor(std::string_view path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  constexpr std::string_view prefix = "/dev/fd/";
  if (path.substr(0, prefix.size()) != prefix) return std::nullopt;
  int descriptor = -1;
  const char* end = path.data() + path.size();
  const auto [stop, error] = std::from_chars(path.data() + prefix.size(), end, descriptor);
  if (error != std::errc() || stop != end) return std::nullopt;
  return descriptor;
}

/// Follows links to the last target, which need not exist.
std::string follow_links(const std::string& path) {
  fs::path place = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(place, error)); ++links) {
    if (links == 40) fail(path, "too many symbolic links");
    const fs::path next = fs::read_symlink(place, error);
    if (error) fail(path, "reading the symbolic link", error.value());
    place = place.parent_path() / next;  // an absolute `next` stands alone
  }
  return place.string();
}

std::string folder_of(const std::string& target) {
  const std::string folder = fs::path(target).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// Removes temporaries of killed processes from `folder`. A writer holds a lock on its temporary; a
/// new one may not be locked yet, so recent files stay.
void remove_leftovers(const std::string& folder) {
  // std::filesystem::directory_iterator would end the program if memory runs out.
  struct Close {
    void operator()(DIR* folder) const { ::closedir(folder); }
  };
  const std::unique_ptr<DIR, Close> list(::opendir(folder.c_str()));
  if (!list) return;
  while (const dirent* entry = ::readdir(list.get())) {
    const std::string_view name = entry->d_name;
    if (!name.starts_with(temporary_prefix) || !name.ends_with(temporary_suffix)) continue;
    int file = ::openat(::dirfd(list.get()), entry->d_name,
                        O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    struct stat status {};
    if (file < 0) continue;
    if (::fstat(file, &status) == 0 && S_ISREG(status.st_mode)
        && std::time(nullptr) - status.st_mtime > 60 && ::flock(file, LOCK_EX | LOCK_NB) == 0)
      ::unlinkat(::dirfd(list.get()), entry->d_name, 0);
    ::close(file);
  }
}

/// Closes and clears the descriptor: close() releases it even if it reports an error.
int close_once(int& descriptor) { return ::close(std::exchange(descriptor, -1)); }

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  if (path_.empty()) fail("''", "the name is empty");
  if (const auto descriptor = named_descriptor(path_)) {
    descriptor_ = ::fcntl(*descriptor, F_DUPFD_CLOEXEC, 3);
    if (descriptor_ < 0) fail(path_, "opening", errno);
    return;
  }
  target_ = follow_links(path_);
  struct stat old {};
  const bool exists = ::stat(target_.c_str(), &old) == 0;
  if (!exists && errno == ENOENT && target_.back() == '/')
    fail(path_, "this names a folder, not a file");
  if (!exists && errno != ENOENT) fail(path_, "looking at it", errno);
  if (exists && S_ISDIR(old.st_mode)) fail(path_, "it is a folder");
  if (exists && !S_ISREG(old.st_mode)) {
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0) fail(path_, "opening", errno);
    return;
  }
  // A rename would replace even a write-protected file, against the intent of the protection.
  if (exists && ::access(target_.c_str(), W_OK) != 0) fail(path_, "the existing file", errno);
  remove_leftovers(folder_of(target_));
  open_temporary(folder_of(target_), exists ? old.st_mode & 07777u : 0666u, exists);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      slot_(std::exchange(other.slot_, -1)) {}

OutputFile::~OutputFile() { abandon(); }

void OutputFile::open_temporary(const std::string& folder, unsigned mode, bool keep_mode) {
  static std::atomic<unsigned> count{0};
  std::string name;
  do {  // The name is short, to fit wherever the target's name fits. Another machine may use the
        // same process id, so the loop tries again if the file exists.
    name = fmt::format("{}/{}{}-{}{}", folder, temporary_prefix, ::getpid(), count++,
                       temporary_suffix);
    descriptor_ = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  } while (descriptor_ < 0 && (errno == EEXIST || errno == EINTR));
  if (descriptor_ < 0) {
    const int error = errno;
    const std::string step = fmt::format("creating a file in '{}'", folder);
    std::error_code ignored;
    if (error != ENOENT) fail(path_, step.c_str(), error);
    if (fs::is_directory(folder, ignored))
      fail(path_, step + ": the folder does not accept files");  // such as /proc
    fail(path_, fmt::format("the folder '{}' does not exist", folder));
  }
  static_cast<void>(::flock(descriptor_, LOCK_EX | LOCK_NB));  // see remove_leftovers()
  temporary_ = std::move(name);
  slot_ = remember(temporary_);
  // Restores the bits of the old file's mode that the umask removed. File systems without modes
  // fail here, which is harmless.
  if (keep_mode) static_cast<void>(::fchmod(descriptor_, mode));
}

bool OutputFile::is_there() const {
  struct stat status {};
  return temporary_.empty() || (::fstat(descriptor_, &status) == 0 && status.st_nlink > 0);
}

void OutputFile::write(std::string_view bytes) {
  constexpr std::size_t most = std::size_t{1} << 30;  // Linux writes less than 2 GiB at once
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), std::min(bytes.size(), most));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(path_, "writing", written < 0 ? errno : EIO);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void OutputFile::commit() {
  if (temporary_.empty()) {
    if (close_once(descriptor_) != 0) fail(path_, "closing", errno);
    return;
  }
  if (::fsync(descriptor_) != 0) fail(path_, "syncing", errno);
  if (close_once(descriptor_) != 0) fail(path_, "closing", errno);  // NFS reports a full disk here
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(path_, "renaming", errno);
  temporary_.clear();
  forget(std::exchange(slot_, -1));

  // Until the folder is synced, a power failure may bring the old file back.
  int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0)
    return;  // a folder that is writable but not readable (mode 0300) cannot be synced
  const int error = ::fsync(folder) == 0 ? 0 : errno;
  close_once(folder);
  if (error != 0 && error != EINVAL) fail(path_, "syncing its folder", error);
}

void OutputFile::abandon() noexcept {
  if (descriptor_ >= 0) close_once(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
  forget(std::exchange(slot_, -1));
}

void remove_temporaries() noexcept {
  for (const Slot& slot : slots)
    if (slot.state == 2) ::unlink(slot.path.data());
}

}  // namespace tyndall::io
