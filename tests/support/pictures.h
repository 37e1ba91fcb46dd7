/// \file
/// Tests whether two sets of pictures have equal means, pixel by pixel.
#pragma once

#include <string>
#include <vector>

#include "tyndall/render/render.h"

namespace tyndall::test {

/// \return the p of two sets of replicates if their true pictures are equal, by Welch's test of
/// every pixel and channel and Sidak's rule for their number. If p is below `level`, writes the
/// mean pictures and their difference to the build folder and prints their paths.
double pictures_p(const std::vector<RenderResult>& first, const std::vector<RenderResult>& second,
                  const std::string& name, double level);

}  // namespace tyndall::test
