/// \file
/// The rendered picture.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tyndall {

/// Further values of each pixel, beside its colour.
struct PictureLayer {
  std::string name;           ///< of the layer in the file
  std::string channels;       ///< a letter each, such as "RGB"
  std::vector<float> values;  ///< [height][width][channels]
};

/// Linear scene-referred RGBA (Rec. 709 primaries, D65), row by row from the top left. RGB is
/// radiance [W/(area sr)]. Alpha is the fraction of the pixel's samples that hit the medium or a
/// ground (premultiplied: a black background adds nothing).
struct Picture {
  int width = 0, height = 0;
  std::vector<float> rgba;  ///< 4 width height values
  std::vector<PictureLayer> layers;
  std::vector<std::pair<std::string, std::string>> provenance;  ///< for the file's header, in order
  int left = 0, top = 0;                  ///< position of a crop in the whole picture
  int whole_width = 0, whole_height = 0;  ///< size of the whole picture; 0: this is not a crop
};

}  // namespace tyndall
