/// \file
/// The target of a light's photons.
#pragma once

#include <vector>

#include <glm/geometric.hpp>

#include "scene/values.h"
#include "tyndall/render/prepare.h"

namespace tyndall {

constexpr double margin = 1 + 1e-5;  // factor on bounds, for the rounding of floats

/// The squared sine of a cone's half angle.
inline double squared_sine(double height) { return height * (2 - height); }

/// Directions about `axis`.
struct Cone {
  glm::dvec3 axis{0, 0, 1};
  double height = 2;  ///< 1 - cosine of the half angle

  double solid_angle() const { return 2 * double{pi} * height; }
  /// The largest cosine between a direction of the cone and `other`.
  double nearest_cosine(const glm::dvec3& other) const;
  /// The mean of f(direction), by the midpoint rule.
  template <class F>
  double mean(const F& f) const {
    constexpr int n = 64;
    double sum = 0;
    for (int i = 0; i < n * n; ++i) {
      sum += f(direction_in_cone(to_vec3f(axis), static_cast<float>(height),
                                 (static_cast<float>(i % n) + 0.5f) / n,
                                 (static_cast<float>(i / n) + 0.5f) / n));
    }
    return sum / (n * n);
  }
};

double face_area(const Box& box, Face face);
/// An upper bound of the projected area of the open faces, over the directions of the cone.
double largest_open_area(const Box& box, const Cone& cone);

/// The bounding box, in local space, of everything that receives light: non-empty super-voxels and
/// grounds. It is the whole box if that is empty or periodic, or if detectors count escaping light.
class Target {
 public:
  /// \param prepared has its majorants and clumps
  Target(const Scene& scene, const Box& box, const Stop& stop, const PreparedScene& prepared);

  /// \return a point of world space in local space.
  glm::dvec3 local(const glm::dvec3& p) const { return p - box_min_; }
  const Box& box() const { return box_; }
  const Stop& stop() const { return stop_; }

  glm::dvec3 center() const { return 0.5 * (low_ + high_); }
  double radius() const { return margin * 0.5 * glm::length(high_ - low_); }
  /// Whether the box is periodic. A placed light then has infinitely many images, which no
  /// technique samples.
  bool is_endless() const { return is_endless_; }

  /// Whether f(corner) is true for all corners of the target.
  template <class F>
  bool all_corners(const F& f) const {
    for (int i = 0; i < 8; ++i)
      if (!f(glm::dvec3{i & 1 ? high_.x : low_.x, i & 2 ? high_.y : low_.y,
                        i & 4 ? high_.z : low_.z}))
        return false;
    return true;
  }

  /// The cone of directions to the target from any point within `radius` of `position`. It has all
  /// directions if the point may lie within the target, or if the target is endless.
  Cone cone_from(const glm::dvec3& position, double radius) const;
  /// `cone`, aimed from a light about `position`.
  AimedCone aim(const glm::dvec3& position, const Cone& cone) const;

  /// An upper bound of the target's projected area, over the directions of the cone.
  double largest_area(const Cone& cone) const;

  /// Statistics of an emitter's photons, estimated from samples.
  struct Yield {
    double weight = 0;    ///< mean weight: 1 except for rejection sampling
    double arriving = 0;  ///< fraction that hits the target
  };
  Yield try_out(const Emitter& emitter) const;

  /// A box whose faces a distant light illuminates.
  struct LitBox {
    Box box;
    int clump = -1;  ///< see Emitter
  };
  /// The clumps, or the whole box if there are none.
  std::vector<LitBox> lit_boxes() const;
  /// \param power (box) -> [W] that enters it \return the power that enters the whole box but no
  /// lit box. A line through several lit boxes counts once for each of them.
  template <class Power>
  glm::dvec3 unlit_power(const Power& power) const {
    glm::dvec3 rest = power(box_);
    for (const LitBox& lit : lit_boxes()) rest -= power(lit.box);
    return glm::max(rest, glm::dvec3(0));
  }

  /// The squared distance from a light to the medium: about that to the box, and at least a tenth
  /// of the box's size, squared.
  double lit_distance_squared(const glm::dvec3& place) const;

 private:
  bool is_hit_by(const Ray& ray) const;

  glm::dvec3 box_min_;
  Box box_;
  glm::dvec3 low_, high_;
  bool is_endless_;
  const Stop& stop_;
  const PreparedScene& prepared_;
};

}  // namespace tyndall
