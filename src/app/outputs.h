/// \file
/// The output files of a command: pictures, parts, reports.
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
  /// Adds a file; the ending of its name selects the format. \throws Error(usage)
  void add(const std::string& path);
  void add(const std::string& path, Writer writer);
  /// Adds the report of the run and the detectors' counts. Empty names add no file.
  void add_reports(const std::string& report, const std::string& detectors);
  /// \return the names of the outputs and the non-empty ones of `others`. \throws Error(usage) if
  /// one would replace another
  std::vector<std::string> distinct_paths(const std::vector<std::string>& others = {}) const;
  /// Opens all outputs, to find early which cannot be written. \throws Error(output_failed)
  void open();
  /// Writes every output that can be written, then fails if one could not: the others may hold
  /// hours of work. May be called again. \throws Error(output_failed)
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
/// \return the ending of pictures if no output is named.
std::string default_extension();
/// \return the ending of a name in lower case: ".exr".
std::string extension_of(const std::string& path);
bool is_part(const std::string& path);

/// Checks `detectors`, the file for the detectors' counts (empty: none). Warns if the scene has
/// detectors and no file is given. \throws Error(usage) if a file is given without detectors
void require_detectors(const Scene& scene, const std::string& detectors);

/// Prints the hashes of a result on a line that begins with `prefix`. \throws Error(output_failed)
void print_hashes(const RenderResult& result, const std::string& prefix = "");

}  // namespace tyndall::app
