/// \file
/// Pictures as portable float maps. They need no library, so every build has them.
#pragma once

#include <string>

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \return the bytes of a PFM file: linear RGB in 32-bit floats. The format stores neither alpha
/// nor provenance.
std::string encode_pfm(const Picture& picture);

}  // namespace tyndall::io
