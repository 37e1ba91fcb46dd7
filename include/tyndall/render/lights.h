/// \file
/// The ratios of the powers of lights to their intensities and radiances.
#pragma once

#include "tyndall/scene/scene.h"

namespace tyndall {

/// 1 - cosine of an angle in [0, 180], in degrees.
double cap_height(double degrees);

/// [sr] The power of a spot light over its intensity.
double solid_angle(const scene::SpotLight& light);

/// [area sr] The power of an area light over its radiance.
double etendue(const scene::RectangleLight& light);
double etendue(const scene::SphereLight& light);

}  // namespace tyndall
