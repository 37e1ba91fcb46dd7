#include "render/field_views.h"

#include <algorithm>
#include <cmath>

#include "scene/values.h"
#include "tyndall/render/volume.h"

namespace tyndall {
namespace {

Remap view(const scene::Remap& remap) {
  return {static_cast<float>(remap.scale), static_cast<float>(remap.offset),
          static_cast<float>(remap.low), static_cast<float>(remap.high),
          static_cast<float>(remap.gamma)};
}

}  // namespace

Solid view(const scene::Solid& solid, const glm::dvec3& origin) {
  Solid s;
  std::visit(Overloaded{[&](const scene::Everywhere&) { s.body = Solid::Body::everywhere; },
                        [&](const scene::Sphere& b) {
                          s.body = Solid::Body::sphere;
                          s.center = to_vec3f(b.center - origin);
                          s.radius = static_cast<float>(b.radius);
                        },
                        [&](const scene::Cuboid& b) {
                          s.body = Solid::Body::cuboid;
                          s.center = to_vec3f(0.5 * (b.min + b.max) - origin);
                          s.half = to_vec3f(0.5 * (b.max - b.min));
                        },
                        [&](const scene::Torus& b) {
                          s.body = Solid::Body::torus;
                          s.center = to_vec3f(b.center - origin);
                          s.ring = static_cast<float>(b.ring_radius);
                          s.radius = static_cast<float>(b.tube_radius);
                        },
                        [&](const scene::Capsule& b) {
                          s.body = Solid::Body::capsule;
                          s.center = to_vec3f(0.5 * (b.a + b.b) - origin);
                          s.half = to_vec3f(0.5 * (b.b - b.a));
                          s.radius = static_cast<float>(b.radius);
                        }},
             solid.body);
  return s;
}
double finest_feature(const scene::Solid&) { return 1.0 / 256; }

NoiseCloud view(const scene::NoiseCloud& cloud, const glm::dvec3&) {
  NoiseCloud c;
  c.octaves = cloud.octaves;
  c.gain = static_cast<float>(cloud.gain);
  c.seed = cloud.seed;
  c.contrast = static_cast<float>(cloud.contrast);
  c.coverage = static_cast<float>(cloud.coverage);
  c.falloff = static_cast<float>(cloud.falloff);
  std::visit(
      Overloaded{[&](const scene::Sphere& b) {
                   c.center = to_vec3f(b.center);
                   c.inverse_radii = to_vec3f(glm::dvec3(1.0 / b.radius));
                 },
                 [&](const scene::Ellipsoid& b) {
                   c.center = to_vec3f(b.center);
                   c.inverse_radii = to_vec3f(1.0 / b.radii);
                 },
                 [&](const scene::Layer& b) {
                   c.center = to_vec3f({0, b.height, 0});
                   c.inverse_radii = to_vec3f({0, 2.0 / b.thickness, 0});
                 },
                 [&](const scene::Everywhere&) {},
                 [&](const scene::Plume& b) {
                   c.center = to_vec3f(b.base);
                   c.inverse_radii = to_vec3f({1 / b.radius_base, 1 / b.height, 1 / b.radius_base});
                   c.growth = static_cast<float>((b.radius_top / b.radius_base - 1) / b.height);
                   c.lean_x = static_cast<float>(b.lean.x / b.height);
                   c.lean_z = static_cast<float>(b.lean.y / b.height);
                 }},
      cloud.body);
  return c;
}
double finest_feature(const scene::NoiseCloud& cloud) { return std::ldexp(1.0, -cloud.octaves); }

DenseGrid view(const scene::DenseGrid& grid, const glm::dvec3&) {
  return {{grid.size[0], grid.size[1], grid.size[2]},
          grid.values.data(),
          grid.interpolation == scene::Interpolation::nearest,
          view(grid.remap)};
}
double finest_feature(const scene::DenseGrid& grid) {
  return 1.0 / std::max({grid.size[0], grid.size[1], grid.size[2]});
}

SparseGrid view(const scene::SparseGrid& grid, const glm::dvec3&) {
  SparseGrid g = grid.volume->view();
  g.nearest = grid.interpolation == scene::Interpolation::nearest;
  g.remap = view(grid.remap);
  return g;
}
double finest_feature(const scene::SparseGrid&) { return 1.0; }

}  // namespace tyndall
