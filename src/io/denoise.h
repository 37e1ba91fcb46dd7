/// \file
/// Denoising with Open Image Denoise, if the build has it.
#pragma once

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \throws Error(usage) if this build cannot denoise()
void require_denoiser();

/// Denoises the colours, guided by the layer "albedo", and keeps the original ones in a new layer
/// "noisy". A picture without pixels is not changed. \throws Error(internal) if the library fails
void denoise(Picture& picture);

}  // namespace tyndall::io
