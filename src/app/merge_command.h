/// \file
/// Parts of a render that lack photons or samples.
#pragma once

#include <string>

#include "tyndall/render/part.h"

namespace tyndall::app {

enum class Needs { photons, all };

/// \throws Error(input_missing) where the part lacks some, unless gaps are allowed: then it warns.
void refuse_gaps(const Partial& part, const std::string& name, bool allowed, Needs needs);

}  // namespace tyndall::app
