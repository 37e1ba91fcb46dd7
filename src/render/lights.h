/// \file
/// The lights of a scene, ready for the walks.
#pragma once

#include "tyndall/render/prepare.h"

namespace tyndall {

/// Fills in emitters, direct_lights, what they point to, and the powers. Expects the components.
/// \throws Stopped
void prepare_lights(const Scene& scene, const Box& box, int threads, const Stop& stop,
                    PreparedScene& out);

/// About the largest radiance [W/(area sr)] in a picture of matter lit by it; no less than a
/// 1024th of its own, unless that is thousands of times as much.
double brightness(const scene::Light& light, glm::dvec3 box_min, const Box& box);

/// Whether a light at a place lies between periodic sides: its images have no end, so paths cannot
/// sample it, and the illumination grid holds its light from the first collision on.
bool has_unsampled_lights(const Scene& scene);

/// No less than any density of the field; cheap.
double largest_density(const AnyField& field);

}  // namespace tyndall
