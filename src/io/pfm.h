/// \file
/// Pictures as portable float maps: no library needed, so every build has them.
#pragma once

#include <string>

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \return the bytes of a PFM file: linear RGB in 32-bit floats; alpha and provenance find no place
/// in it.
std::string encode_pfm(const Picture& picture);

}  // namespace tyndall::io
