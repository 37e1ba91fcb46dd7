/// \file
/// An image as a file stores it, with its metadata. The readers of the formats fill it in, and
/// io/helper/images.cpp converts it to an upright picture.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "io/helper/input.h"
#include "io/json_text.h"

namespace tyndall::io {

/// CIE 1931 chromaticities x, y of red, green, blue and white.
struct Primaries {
  std::array<double, 8> xy;
};

struct DecodedImage {
  Json told = Json::object();         ///< metadata for `tyndall info`
  std::vector<std::string> warnings;  ///< about metadata that is not applied
  /// Why a sound image cannot be an environment; it has no pixels then.
  std::string problem;

  int width = 0, height = 0;               ///< of the stored pixels
  int left = 0, top = 0;                   ///< position of the stored pixels in the whole
  int whole_width = 0, whole_height = 0;   ///< 0: as large as the stored pixels
  std::vector<float> rgb;                  ///< [height][width][3]
  int orientation = 1;                     ///< position of the first row and column, as in TIFF
  std::optional<Primaries> primaries;      ///< none: those of Rec. 709
  std::array<double, 3> divisor{1, 1, 1};  ///< of the values, such as Radiance's EXPOSURE
  /// 0: linear. 1: the sRGB curve. Otherwise linear values are the stored ones to this power.
  double curve = 0;

  /// Allocates the pixels. \throws Failure if the file is too short to hold as many
  void resize(long long columns, long long rows);
};

/// The reason why pixel aspect ratios are not applied.
inline constexpr const char* whole_sphere =
    "the picture covers the whole sphere, whatever the shape of its pixels";

DecodedImage decode_exr();
DecodedImage decode_radiance();

}  // namespace tyndall::io
