/// \file
/// The report of a run: for people, for programs, and for the header of the picture.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "io/volume_file.h"
#include "tyndall/render/render.h"

namespace tyndall::io {

struct Run {
  const Partial& part;
  const RenderResult& result;
  std::string scene_path;
  std::string device;  ///< "cpu", "cuda:0"
  std::vector<LoadedVolume> volumes;
};

/// \return the facts of the run that are the same on every machine, as keys
/// ("tyndall.ledger.count.shot") and values (text, or JSON) for Picture::provenance. Times are
/// left out, so that equal runs give equal files.
std::vector<std::pair<std::string, std::string>> provenance(const RenderResult& result);

/// \return a JSON object with the keys of provenance() (without "tyndall."), the scene file, the
/// device and the times.
std::string report_json(const Run& run);

/// \return a summary in a few lines for people.
std::string report_lines(const Run& run);

}  // namespace tyndall::io
