/// \file
/// `tyndall bake`: shoots the photons of a scene and writes their light for other programs.
#pragma once

#include <string>
#include <vector>

#include "tyndall/render/error.h"

namespace tyndall::app {

struct BakeArguments {
  std::string scene;
  std::vector<std::string> overrides;  ///< "path=value"
  std::vector<std::string> outputs;
  std::string device = "auto";
  std::string progress = "auto";
  int threads = 0;
  int order = 1;   ///< 0: without directions
  int voxels = 0;  ///< of the density, along the longest side
  bool per_light = false, half = false, multiple_only = false;
};

/// \return done, or 128 and the signal that ended it. \throws Error, Stopped
ExitCode bake_command(const BakeArguments& arguments);

}  // namespace tyndall::app
