/// \file
#pragma once

#include <vector>

#include "tyndall/render/scene.h"
#include "tyndall/transport/camera.h"

namespace tyndall {

/// \return the camera in local space (tyndall/render/prepare.h). It points to `filter_quantiles`,
/// which is written.
Camera prepare_camera(const Scene& scene, std::vector<float>& filter_quantiles);

}  // namespace tyndall
