/// \file
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tyndall {

/// More about each pixel than its colour.
struct PictureLayer {
  std::string name;           ///< of the layer in the file
  std::string channels;       ///< a letter each, such as "RGB"
  std::vector<float> values;  ///< [height][width][channels]
};

/// Linear scene-referred RGBA (Rec. 709 primaries, D65), row by row from the top left; radiance
/// [W/(area sr)], alpha the share of the pixel's samples that met matter (premultiplied: a black
/// background adds nothing).
struct Picture {
  int width = 0, height = 0;
  std::vector<float> rgba;  ///< 4 width height values
  std::vector<PictureLayer> layers;
  std::vector<std::pair<std::string, std::string>> provenance;  ///< for the file's header, in order
  int left = 0, top = 0;                  ///< of a part of a picture: where it lies in the whole
  int whole_width = 0, whole_height = 0;  ///< and the size of that; 0: this is no part
};

}  // namespace tyndall
