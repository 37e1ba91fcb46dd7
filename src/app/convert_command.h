/// \file
/// `tyndall convert`: writes a scene for another renderer.
#pragma once

#include <string>
#include <vector>

namespace tyndall::app {

struct ConvertArguments {
  std::string scene, output;
  std::vector<std::string> overrides;  ///< "path=value"
  int voxels = 0;                      ///< along the longest side of what is sampled
};

/// \throws Error.
void convert_command(const ConvertArguments& arguments);

}  // namespace tyndall::app
