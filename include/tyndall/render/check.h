/// \file
/// What is wrong with a scene, in the words of its file.
#pragma once

#include <string>
#include <vector>

#include "tyndall/scene/scene.h"

namespace tyndall {

struct Problem {
  std::string path;     ///< of the offending key, e.g. "medium.components[0].extinction"
  std::string message;  ///< what was expected, what was found, what to write
  std::vector<std::string> depends_on = {};  ///< other keys that could make it none
};

struct Problems {
  std::vector<Problem> errors;
  std::vector<Problem> warnings;
};

/// Every problem of `scene` at once; a scene without errors renders. Needs no files and builds
/// nothing.
Problems check(const Scene& scene);

}  // namespace tyndall
