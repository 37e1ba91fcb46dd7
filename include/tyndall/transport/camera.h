/// \file
#pragma once

#include "tyndall/transport/walk.h"

namespace tyndall {

/// Pinhole. A point (u, v) of the picture, from the top left, looks along
/// forward + (2u - 1) right + (1 - 2v) up; `right` and `up` carry the tangents of half the angles
/// of view.
struct PinholeCamera {
  Vec3f position{0, 0, 0};
  Vec3f forward{0, 0, 1}, right{1, 0, 0}, up{0, 1, 0};

  TYN_HD Ray ray(float u, float v) const {
    return {position, normalize(forward + (2.0f * u - 1.0f) * right + (1.0f - 2.0f * v) * up)};
  }
};

}  // namespace tyndall
