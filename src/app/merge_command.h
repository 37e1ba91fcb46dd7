/// \file
/// `tyndall merge`: adds up parts of a render.
#pragma once

#include <string>
#include <vector>

#include "tyndall/render/part.h"

namespace tyndall::app {

struct MergeArguments {
  std::vector<std::string> parts;
  std::vector<std::string> outputs;  ///< parts (.tyn) or pictures
  bool allow_gaps = false;
  bool print_hash = false;
};

/// \throws Error.
void merge_command(const MergeArguments& arguments);

enum class Needs { photons, all };

/// \throws Error(input_missing) where the part lacks some, unless gaps are allowed: then it warns.
void refuse_gaps(const Partial& part, const std::string& name, bool allowed, Needs needs);

}  // namespace tyndall::app
