/// \file
/// Whether two sets of pictures show the same, pixel by pixel.
#pragma once

#include <string>
#include <vector>

#include "tyndall/render/render.h"

namespace tyndall::test {

/// p of two sets of replicates whose true pictures are equal, by Welch's test of every pixel and
/// channel and Sidak's rule for their number. Where it is below `level`, the mean pictures and
/// their difference are written to the build folder and standard output says where.
double pictures_p(const std::vector<RenderResult>& first, const std::vector<RenderResult>& second,
                  const std::string& name, double level);

}  // namespace tyndall::test
