/// \file
/// Images of the sky: their linear Rec. 709 pixels, upright and finite, in the memory file.
#pragma once

#include "io/json_text.h"

namespace tyndall::io {

/// Reads the image on standard input. \return "image" (see io/helper/protocol.h), or "problem".
/// \throws Failure
Json read_image();

}  // namespace tyndall::io
