/// \file
/// An image as a file holds it, and what the file says of it: what the readers of the formats fill
/// in, and io/helper/images.cpp makes one upright picture of.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "io/helper/input.h"
#include "io/json_text.h"

namespace tyndall::io {

/// Places of red, green, blue and white in the CIE 1931 diagram.
struct Primaries {
  std::array<double, 8> xy;
};

struct DecodedImage {
  Json told = Json::object();         ///< what the file says, for `tyndall info`
  std::vector<std::string> warnings;  ///< of what is not honoured
  /// Why it can be no sky although it is sound: then there are no pixels.
  std::string problem;

  int width = 0, height = 0;               ///< of the stored pixels
  int left = 0, top = 0;                   ///< their place in the whole
  int whole_width = 0, whole_height = 0;   ///< 0: as large as the stored pixels
  std::vector<float> rgb;                  ///< [height][width][3]
  int orientation = 1;                     ///< TIFF's number: where the first row and column are
  std::optional<Primaries> primaries;      ///< none: those of Rec. 709
  std::array<double, 3> divisor{1, 1, 1};  ///< of the values, as Radiance's EXPOSURE
  /// 0: linear. 1: the sRGB curve. Else linear values are the stored ones to this power.
  double curve = 0;

  /// Makes room for the pixels. \throws Failure where the file cannot hold as many
  void resize(long long columns, long long rows);
};

/// Why the aspect ratio of pixels is not applied.
inline constexpr const char* whole_sphere =
    "the picture covers the whole sphere, whatever the shape of its pixels";

DecodedImage decode_exr();
DecodedImage decode_radiance();

}  // namespace tyndall::io
