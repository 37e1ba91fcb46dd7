/// \file
/// Denoising, with Open Image Denoise where the build found it.
#pragma once

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \throws Error(usage) where this build cannot denoise()
void require_denoiser();

/// Takes the noise out of the colours, guided by the layer "albedo"; what they were becomes the
/// layer "noisy". A picture without pixels stays as it is. \throws Error(internal) where the
/// library fails
void denoise(Picture& picture);

}  // namespace tyndall::io
