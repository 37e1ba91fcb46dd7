/// \file
/// The vector type of the walks. (GLM serves the host API; its functions reject SIMD packs.)
#pragma once

#include "tyndall/base/math.h"

namespace tyndall {

template <class R>
struct Vec3 {
  R x, y, z;
};

using Vec3f = Vec3<float>;

template <class R>
TYN_HD Vec3<R> operator+(Vec3<R> a, Vec3<R> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class R>
TYN_HD Vec3<R> operator-(Vec3<R> a, Vec3<R> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class R>
TYN_HD Vec3<R> operator*(Vec3<R> a, Vec3<R> b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <class R>
TYN_HD Vec3<R> operator*(R s, Vec3<R> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class R>
TYN_HD R dot(Vec3<R> a, Vec3<R> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class R>
TYN_HD Vec3<R> cross(Vec3<R> a, Vec3<R> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

TYN_HD float length(Vec3f a) { return sqrt(dot(a, a)); }
TYN_HD Vec3f normalize(Vec3f a) { return inverse(root(dot(a, a))) * a; }
TYN_HD float largest(Vec3f a) { return max(a.x, max(a.y, a.z)); }

/// \return `local`, given with z along the unit vector `axis`, in the outer frame. No branches
/// [Duff2017].
TYN_HD Vec3f to_frame_of(Vec3f axis, Vec3f local) {
  const float sign = axis.z >= 0.0f ? 1.0f : -1.0f;
  const float a = -inverse(sign + axis.z);
  const float b = axis.x * axis.y * a;
  const Vec3f s{1.0f + sign * axis.x * axis.x * a, sign * b, -sign * axis.x};
  const Vec3f t{b, sign + axis.y * axis.y * a, -axis.y};
  return local.x * s + local.y * t + local.z * axis;
}

/// The direction at `cosine` from `axis`, turned about it by `turn` in [0, 1] of a full circle.
TYN_HD Vec3f direction_around(Vec3f axis, float cosine, float turn) {
  const float sine = root(max(0.0f, (1.0f - cosine) * (1.0f + cosine)));
  const SinCos phi = sin_cos_turn(turn);
  return normalize(to_frame_of(axis, {sine * phi.cos, sine * phi.sin, cosine}));
}

/// 1 - cosine of the angle between unit vectors, accurate for small angles, too.
TYN_HD float cap_height(Vec3f a, Vec3f b) { return 0.5f * dot(a - b, a - b); }

/// A uniform direction in the cone about `axis`. `height` is that of the cone's cap on the unit
/// sphere, 1 - cosine of the half angle; u and v are in [0, 1].
TYN_HD Vec3f direction_in_cone(Vec3f axis, float height, float u, float v) {
  const float h = u * height, sine = sqrt(max(0.0f, h * (2.0f - h)));
  const SinCos phi = sin_cos_turn(v);
  return normalize(to_frame_of(axis, {sine * phi.cos, sine * phi.sin, 1.0f - h}));
}

/// p -> A p + b, where A has the rows `row_x`, `row_y`, `row_z`, and b is `offset`.
struct Affine {
  Vec3f row_x{1, 0, 0}, row_y{0, 1, 0}, row_z{0, 0, 1};
  Vec3f offset{0, 0, 0};

  TYN_HD Vec3f operator()(Vec3f p) const {
    return Vec3f{dot(row_x, p), dot(row_y, p), dot(row_z, p)} + offset;
  }
};

}  // namespace tyndall
