/// \file
/// The lights of a scene, ready for the walks.
#pragma once

#include "tyndall/render/prepare.h"

namespace tyndall {

/// Fills in emitters and direct_lights, their tables, and the powers. \pre out.components are set
/// \return approximately the largest radiance [W/(area sr)] in an image: that of a medium lit by
/// one light, or 1/1024 of a light's own. \throws Stopped
double prepare_lights(const Scene& scene, const Box& box, int threads, const Stop& stop,
                      PreparedScene& out);

/// Whether a light is infinitely far away, without a position.
bool is_distant(const scene::Light& light);

/// Whether the scene has a placed light between periodic sides. Such a light has infinitely many
/// images, so paths cannot sample it; the illumination grid holds its light from the first
/// collision.
bool has_unsampled_lights(const Scene& scene);

}  // namespace tyndall
