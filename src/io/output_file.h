/// \file
/// Atomic output files: a temporary beside the target is written, synced, and renamed over it.
#pragma once

#include <string>
#include <string_view>

namespace tyndall::io {

/// One output. The constructor checks that the target can be written, before an hour of rendering.
/// The target is unchanged until commit(), and stays unchanged without it.
///
/// A symbolic link is followed: the file it points to is replaced, the link stays. A target that is
/// not a regular file (a pipe, /dev/stdout, /dev/null) has no old contents to protect and is
/// written directly.
class OutputFile {
 public:
  /// \throws Error(output_failed): the folder is missing or read-only, the target is a folder or
  /// write-protected.
  explicit OutputFile(std::string path);
  /// Removes the temporary unless commit() succeeded.
  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;

  /// \return false if another process has removed the temporary.
  bool is_there() const;
  /// Appends `bytes`. \throws Error(output_failed): disk full, quota, input/output error.
  void write(std::string_view bytes);
  /// Replaces the target, durable against a power failure. \throws Error(output_failed).
  void commit();

  /// The path as the user gave it.
  const std::string& path() const { return path_; }

 private:
  void open_temporary(const std::string& folder, unsigned mode, bool keep_mode);
  void abandon() noexcept;

  std::string path_;       // as given, for messages
  std::string target_;     // with links followed
  std::string temporary_;  // empty: written directly, or done
  int descriptor_ = -1;
  int slot_ = -1;  // in the list of remove_temporaries()
};

/// Removes the temporaries of all open outputs. Async-signal-safe: for signal handlers that end
/// the process.
void remove_temporaries() noexcept;

}  // namespace tyndall::io
