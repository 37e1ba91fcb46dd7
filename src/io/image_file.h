/// \file
/// Images that light a scene: all that OpenImageIO reads.
#pragma once

#include <memory>
#include <string>

#include "tyndall/render/image.h"

namespace tyndall::io {

/// Linear RGB; integers on the sRGB curve are taken off it, and grey is made three channels.
/// \throws Error(input_missing): file and reason.
std::shared_ptr<const Image> load_image(const std::string& path);

}  // namespace tyndall::io
