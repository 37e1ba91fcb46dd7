/// \file
#pragma once

#include <cstdint>
#include <vector>

#include "tyndall/scene/scene.h"
#include "tyndall/transport/camera.h"

namespace tyndall {

/// The position of a camera and its orientation: three unit vectors.
struct Pose {
  glm::dvec3 position, forward, right, up;
};
Pose pose(const scene::Camera& camera);

/// The tangent of half the horizontal field of view.
double half_tangent(const scene::Camera& camera);
/// The focus distance of a lens [length].
double focus_distance(const scene::Camera& camera);
CropWindow window(const scene::Camera& camera);

/// \return the camera in local space (tyndall/render/prepare.h). \param[out] filter_quantiles must
/// outlive it
Camera prepare_camera(const Scene& scene, std::vector<float>& filter_quantiles);

/// \return the pixels, in order, that may have samples that hit `box` (a superset). Empty means all
/// pixels, as for cameras within the box or with a lens, and for periodic boxes.
std::vector<std::uint32_t> pixels_that_meet(const Camera& camera, const Box& box);

}  // namespace tyndall
