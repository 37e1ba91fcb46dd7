/// \file
/// What a command writes: pictures, parts, reports.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/output_file.h"
#include "io/report.h"

namespace tyndall::app {

using Writer = std::function<void(const io::Run&, io::OutputFile&)>;

class Outputs {
 public:
  /// A file whose name's ending tells its format. \throws Error(usage)
  void add(const std::string& path);
  void add(const std::string& path, Writer writer);
  /// The account of the run, and what the detectors counted; empty: none.
  void add_reports(const std::string& report, const std::string& detectors);
  /// \return their names, and those of what else is written (empty: nothing). \throws Error(usage)
  /// where one would replace another
  std::vector<std::string> distinct_paths(const std::vector<std::string>& others = {}) const;
  /// Finds out whether all of them can be written. \throws Error(output_failed)
  void open();
  /// Writes every output that can be written, and fails afterwards where one could not: the others
  /// may hold hours of work. May be called again. \throws Error(output_failed)
  void write(const io::Run& run, bool says = true);

 private:
  struct Output {
    std::string path;
    Writer writer;
    std::optional<io::OutputFile> file;
  };
  std::vector<Output> outputs_;
};

/// \return the formats of this build, e.g. ".exr, .png, .pfm".
std::string known_formats();
/// \return the ending of pictures where nobody asks for one.
std::string default_extension();
/// \return the ending of a name, in small letters: ".exr".
std::string extension_of(const std::string& path);
bool is_part(const std::string& path);

/// What detectors count is asked for where there are some, and only there.
/// \param detectors file; empty: none \throws Error(usage)
void require_detectors(const Scene& scene, const std::string& detectors);

/// Prints the hashes of a result on a line that begins with `prefix`. \throws Error(output_failed)
void print_hashes(const RenderResult& result, const std::string& prefix = "");

}  // namespace tyndall::app
