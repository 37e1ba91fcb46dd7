/// \file
/// Previews: 8-bit PNG files.
#pragma once

#include <string>

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \return the bytes of an opaque RGB file with the sRGB curve, brighter by `exposure` [EV]. Alpha
/// is dropped: the picture is premultiplied and includes its background.
std::string encode_png(const Picture& picture, double exposure);

/// \return linear `value` on the sRGB curve, 0 to 255; NaN is black.
unsigned char srgb_byte(double value);

}  // namespace tyndall::io
