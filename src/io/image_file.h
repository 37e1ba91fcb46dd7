/// \file
/// Images that light a scene. A child process reads them (io/helper/protocol.h); its results are
/// checked here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/json_text.h"
#include "tyndall/render/image.h"

namespace tyndall::io {

/// An image that was read, with its metadata.
struct LoadedImage {
  std::shared_ptr<const Image> image;  ///< null if there is a problem
  std::vector<std::string> warnings;   ///< about replaced values and metadata that is not applied
  std::string problem;                 ///< why a sound image cannot be an environment
  Json told;                           ///< metadata for people
};

/// Reads an image as linear Rec. 709, upright. \throws Error(input_missing): file and reason.
LoadedImage read_image_file(const std::string& path);

/// Reads an image as read_image_file() does. \throws Error(input_missing) for a problem as well.
LoadedImage load_image(const std::string& path);

}  // namespace tyndall::io
