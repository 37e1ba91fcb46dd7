/// \file
/// Tabulated phase functions: text with a row "cosine value" per line; '#' begins a comment.
#pragma once

#include <memory>
#include <string>

#include "tyndall/scene/scene.h"

namespace tyndall::io {

/// \throws Error(input_missing) with the line of the error.
std::shared_ptr<const scene::PhaseTable> read_phase_file(const std::string& path);

}  // namespace tyndall::io
