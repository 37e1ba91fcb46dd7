/// \file
/// Checks whether a part of a render lacks photons or samples.
#pragma once

#include <string>

#include "tyndall/render/part.h"

namespace tyndall::app {

enum class Needs { photons, all };

/// Warns of missing photons or samples if gaps are allowed. \throws Error(input_missing) if not
void refuse_gaps(const Partial& part, const std::string& name, bool allowed, Needs needs);

}  // namespace tyndall::app
