/// \file
/// Previews: 8-bit PNG files, which OpenImageIO writes (io/module.h).
#pragma once

#include <string>

#include "tyndall/render/picture.h"

namespace tyndall::io {

class PngEncoder {
 public:
  /// Loads the module. \throws Error(output_failed) where it or OpenImageIO is missing; says where
  /// it looked.
  PngEncoder();

  /// \return the bytes of an opaque RGB file under the sRGB curve, brighter by `exposure` [EV].
  /// Alpha is not needed: the picture is premultiplied and holds its background. \throws
  /// Error(output_failed).
  std::string encode(const Picture& picture, double exposure) const;

 private:
  void* function_;  // of plugin/oiio.h; the module stays loaded
};

/// \return linear `value` on the sRGB curve, 0 to 255; NaN is black.
unsigned char srgb_byte(double value);

}  // namespace tyndall::io
