/// \file
/// Files that are either whole or not there: a temporary beside the target, synced, renamed over
/// it.
#pragma once

#include <string>
#include <string_view>

namespace tyndall::io {

/// One output. The constructor finds out whether it can be written at all, so that nobody renders
/// for an hour first; until commit() the target is untouched, and without commit() it stays so.
///
/// A symbolic link is followed: the file it points to is replaced, the link stays. What is no
/// regular file (a pipe, /dev/stdout, /dev/null) has no old contents to protect and is written
/// directly.
class OutputFile {
 public:
  /// \throws Error(output_failed): the folder is missing or read-only, the target is a folder or
  /// write-protected.
  explicit OutputFile(std::string path);
  /// Removes the temporary where commit() did not succeed.
  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;

  /// \return false where somebody has removed the temporary since.
  bool is_there() const;
  /// Appends `bytes`. \throws Error(output_failed): disk full, quota, input/output error.
  void write(std::string_view bytes);
  /// Makes what was written the target, safe against a power failure. \throws Error(output_failed).
  void commit();

  /// As the person gave it.
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

/// Removes the temporaries of all open outputs; async-signal-safe, for a handler that ends the
/// process.
void remove_temporaries() noexcept;

}  // namespace tyndall::io
