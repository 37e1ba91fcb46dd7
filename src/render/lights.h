/// \file
/// The lights of a scene, ready for the walks.
#pragma once

#include "tyndall/render/prepare.h"

namespace tyndall {

/// Fills in emitters, direct_lights, what they point to, and the powers. Expects the components.
/// \return about the largest radiance [W/(area sr)] in a picture: of a medium lit by one light, or
/// a 1024th of a light's own. \throws Stopped
double prepare_lights(const Scene& scene, const Box& box, int threads, const Stop& stop,
                      PreparedScene& out);

/// Whether a light is beyond everything: it has no place.
bool is_distant(const scene::Light& light);

/// Whether a placed light lies between periodic sides: it has infinitely many images, so paths
/// cannot sample it, and the illumination grid holds its light from the first collision on.
bool has_unsampled_lights(const Scene& scene);

}  // namespace tyndall
