/// \file
/// Environment images: writes their pixels, upright and finite linear Rec. 709, to the memory file.
#pragma once

#include "io/json_text.h"

namespace tyndall::io {

/// Reads the image on standard input. \return "image" (see io/helper/protocol.h), or "problem".
/// \throws Failure
Json read_image();

}  // namespace tyndall::io
