/// \file
/// The check of a scene. It reports problems in the terms of the scene file.
#pragma once

#include <string>
#include <vector>

#include "tyndall/scene/scene.h"

namespace tyndall {

struct Problem {
  std::string path;     ///< of the offending key, e.g. "medium.components[0].extinction"
  std::string message;  ///< expected and found values, and a remedy
  std::vector<std::string> depends_on = {};  ///< other keys that could resolve it
};

struct Problems {
  std::vector<Problem> errors;
  std::vector<Problem> warnings;
};

/// \return every problem of `scene`; a scene without errors renders. Reads no files and builds
/// nothing.
Problems check(const Scene& scene);

}  // namespace tyndall
