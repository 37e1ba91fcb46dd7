/// \file
/// Images that light a scene. A child process reads them (io/helper/protocol.h); what it hands back
/// is checked here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/json_text.h"
#include "tyndall/render/image.h"

namespace tyndall::io {

/// An image that was read, and what its file says of it.
struct LoadedImage {
  std::shared_ptr<const Image> image;  ///< null where there is a problem
  std::vector<std::string> warnings;   ///< of what was mended, or is not honoured
  std::string problem;                 ///< why it can be no sky although the file is sound
  Json told;                           ///< for people
};

/// Linear Rec. 709, upright, as the file means it. \throws Error(input_missing): file and reason.
LoadedImage read_image_file(const std::string& path);

/// As read_image_file(), but a problem is an error, too.
LoadedImage load_image(const std::string& path);

}  // namespace tyndall::io
