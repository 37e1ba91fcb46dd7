/// \file
#pragma once

#include <cstdint>
#include <vector>

#include "tyndall/scene/scene.h"
#include "tyndall/transport/camera.h"

namespace tyndall {

/// Where a camera stands and how it is turned: three unit vectors.
struct Pose {
  glm::dvec3 position, forward, right, up;
};
Pose pose(const scene::Camera& camera);

/// Tangent of half the angle across the width.
double half_tangent(const scene::Camera& camera);
/// [length] of an open lens.
double focus_distance(const scene::Camera& camera);
CropWindow window(const scene::Camera& camera);

/// \return the camera in local space (tyndall/render/prepare.h). It points to `filter_quantiles`,
/// which is written.
Camera prepare_camera(const Scene& scene, std::vector<float>& filter_quantiles);

/// \return the pixels, in order, of which a sample may meet `box`: at least those; empty for all,
/// as for cameras within it or with a lens, and for boxes without end.
std::vector<std::uint32_t> pixels_that_meet(const Camera& camera, const Box& box);

}  // namespace tyndall
