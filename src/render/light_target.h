/// \file
/// The medium as lights see it: what their photons are aimed at.
#pragma once

#include <vector>

#include <glm/geometric.hpp>

#include "scene/values.h"
#include "tyndall/render/prepare.h"

namespace tyndall {

constexpr double margin = 1 + 1e-5;  // of bounds, against the rounding of floats

/// Of the half angle of a cone.
inline double squared_sine(double height) { return height * (2 - height); }

/// Directions about `axis`.
struct Cone {
  glm::dvec3 axis{0, 0, 1};
  double height = 2;  ///< 1 - cosine of the half angle

  double solid_angle() const { return 2 * double{pi} * height; }
  /// The largest cosine between any of its directions and `other`.
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
/// No less than the area that the open faces show to any direction of the cone.
double largest_open_area(const Box& box, const Cone& cone);

/// What receives light, in local space: super-voxels that are not empty, and grounds. All of the
/// box where it is empty or periodic, and where detectors count what leaves it.
class Target {
 public:
  /// \param prepared with its majorants and clumps
  Target(const Scene& scene, const Box& box, const Stop& stop, const PreparedScene& prepared);

  /// \return a point of world space in local space.
  glm::dvec3 local(const glm::dvec3& p) const { return p - box_min_; }
  const Box& box() const { return box_; }
  const Stop& stop() const { return stop_; }

  glm::dvec3 center() const { return 0.5 * (low_ + high_); }
  double radius() const { return margin * 0.5 * glm::length(high_ - low_); }
  /// Whether it is periodic. A placed light then has infinitely many images, which nothing samples.
  bool is_endless() const { return is_endless_; }

  /// Whether f(corner) is true for all corners of its box.
  template <class F>
  bool all_corners(const F& f) const {
    for (int i = 0; i < 8; ++i)
      if (!f(glm::dvec3{i & 1 ? high_.x : low_.x, i & 2 ? high_.y : low_.y,
                        i & 4 ? high_.z : low_.z}))
        return false;
    return true;
  }

  /// The cone of directions to it from `position`, or from any point within `radius` of that. All
  /// directions from within, and where it is endless.
  Cone cone_from(const glm::dvec3& position, double radius) const;
  /// `cone`, aimed from a light about `position`.
  AimedCone aim(const glm::dvec3& position, const Cone& cone) const;

  /// No less than the area that its box shows to any direction of the cone.
  double largest_area(const Cone& cone) const;

  /// What happens to the photons of an emitter, by some that are tried.
  struct Yield {
    double weight = 0;    ///< their mean weight: 1 but for rejection sampling
    double arriving = 0;  ///< fraction that hits the target
  };
  Yield try_out(const Emitter& emitter) const;

  /// A box onto whose faces a distant light falls.
  struct LitBox {
    Box box;
    int clump = -1;  ///< see Emitter
  };
  /// The clumps, or the whole box where there are none.
  std::vector<LitBox> lit_boxes() const;
  /// \param power (box) -> [W] that enters it \return what enters the whole box and no lit one.
  /// That of lines through several is entered several times.
  template <class Power>
  glm::dvec3 unlit_power(const Power& power) const {
    glm::dvec3 rest = power(box_);
    for (const LitBox& lit : lit_boxes()) rest -= power(lit.box);
    return glm::max(rest, glm::dvec3(0));
  }

  /// Of the distance from a place to what it lights: about that to the box, and no less than a
  /// tenth of the box's size.
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
