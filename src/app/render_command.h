/// \file
/// `tyndall render`: reads a scene, renders it, writes what was asked for.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tyndall::app {

struct RenderArguments {
  std::string scene;
  std::vector<std::string>
      outputs;  ///< empty: one picture named like the scene, in the current folder
  std::vector<std::string> overrides;  ///< "path=value"
  std::string report;                  ///< file, empty: none
  std::string detectors;               ///< file, empty: none
  std::string device = "cpu";          ///< "cpu", "cuda", "cuda:1"
  std::string progress = "auto";       ///< auto, bar, plain, none
  int threads = 0;                     ///< 0: one per hardware thread
  std::uint64_t batch = 0;             ///< 0: the backend's choice
  bool print_hash = false;
};

/// \throws Error, Stopped.
void render_command(const RenderArguments& arguments);

/// \return the formats of this build, e.g. ".exr, .png, .pfm".
std::string known_formats();

/// No output may replace what the scene is made of. \throws Error(usage)
void refuse_inputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

}  // namespace tyndall::app
