#include <cstring>
#include <type_traits>

#include "tyndall/base/hash.h"
#include "tyndall/render/check.h"
#include "tyndall/render/image.h"
#include "tyndall/render/render.h"
#include "tyndall/render/volume.h"

namespace tyndall {
namespace {

/// Feeds every value of a scene to the hash, in the order of declaration; variants add their index.
class SceneHasher {
 public:
  std::uint64_t value() const { return hasher_.value(); }

  template <class... T>
  void operator()(const T&... values) {
    (add(values), ...);
  }

 private:
  void add(double v) {
    std::uint64_t bits;
    const double normal = v + 0.0;  // -0 is 0
    std::memcpy(&bits, &normal, sizeof bits);
    hasher_.add(bits);
  }
  void add(float v) { add(double{v}); }
  template <class T>
  requires(std::is_integral_v<T> || std::is_enum_v<T>) void add(T v) {
    hasher_.add(static_cast<std::uint64_t>(v));
  }
  void add(glm::dvec2 v) { (*this)(v.x, v.y); }
  void add(glm::dvec3 v) { (*this)(v.x, v.y, v.z); }
  void add(const glm::dmat4& m) {
    for (int c = 0; c < 4; ++c) (*this)(m[c][0], m[c][1], m[c][2], m[c][3]);
  }
  template <class T, std::size_t n>
  void add(const std::array<T, n>& values) {
    for (const T& v : values) add(v);
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    for (const T& v : values) add(v);
  }
  template <class... T>
  void add(const std::variant<T...>& v) {
    add(v.index());
    std::visit([&](const auto& x) { add(x); }, v);
  }
  void add(const scene::Sphere& s) { (*this)(s.center, s.radius); }
  void add(const scene::Ellipsoid& s) { (*this)(s.center, s.radii); }
  void add(const scene::Layer& s) { (*this)(s.height, s.thickness); }
  void add(const scene::Everywhere&) {}
  void add(const scene::Plume& s) {
    (*this)(s.base, s.height, s.radius_base, s.radius_top, s.lean);
  }
  void add(const scene::Cuboid& s) { (*this)(s.min, s.max); }
  void add(const scene::Torus& s) { (*this)(s.center, s.ring_radius, s.tube_radius); }
  void add(const scene::Capsule& s) { (*this)(s.a, s.b, s.radius); }
  void add(const scene::NoiseCloud& f) {
    (*this)(f.octaves, f.gain, f.seed, f.contrast, f.coverage, f.falloff, f.body);
  }
  void add(const scene::Remap& r) { (*this)(r.scale, r.offset, r.low, r.high, r.gamma); }
  void add(const scene::DenseGrid& f) { (*this)(f.size, f.values, f.interpolation, f.remap); }
  void add(const scene::SparseGrid& f) {
    (*this)(f.volume->hash(), f.interpolation, f.remap, f.fit);
    if (f.fit_box) (*this)(f.fit_box->low, f.fit_box->high);
  }
  void add(const scene::Solid& f) { add(f.body); }
  void add(const scene::IsotropicPhase&) {}
  void add(const scene::HenyeyGreensteinPhase& p) { add(p.g); }
  void add(const scene::RayleighPhase&) {}
  void add(const scene::TwoLobesPhase& p) { (*this)(p.g1, p.g2, p.weight); }
  void add(const scene::TabulatedPhase& p) { (*this)(p.table->cosines, p.table->values); }
  void add(const scene::NoEmission&) {}
  void add(const scene::ColorEmission& e) { (*this)(e.radiance, e.field); }
  void add(const scene::BlackbodyEmission& e) { (*this)(e.temperature, e.intensity); }
  void add(const scene::Component& c) {
    (*this)(c.field, c.extinction, c.albedo, c.phase, c.emission, c.transform);
  }
  void add(const std::string& text) {
    add(text.size());
    for (const char c : text) add(c);
  }
  void add(const scene::PointLight& l) { (*this)(l.position, l.power, l.group); }
  void add(const scene::DirectionalLight& l) {
    (*this)(l.direction, l.irradiance, l.angle, l.group);
  }
  void add(const scene::EnvironmentLight& l) {
    if (l.image)
      (*this)(true, l.image->hash(), l.rotation);
    else
      (*this)(false, l.radiance);
    (*this)(l.scale, l.group);
  }
  void add(const scene::SpotLight& l) {
    (*this)(l.position, l.direction, l.angle, l.edge, l.intensity, l.group);
  }
  void add(const scene::RectangleLight& l) {
    (*this)(l.center, l.edge_u, l.edge_v, l.radiance, l.group);
  }
  void add(const scene::SphereLight& l) { (*this)(l.center, l.radius, l.radiance, l.group); }
  void add(const scene::Camera& c) {
    (*this)(c.projection, c.position, c.look_at, c.up, c.matrix.has_value(),
            c.matrix.value_or(glm::dmat4(1)), c.fov, c.focal_length, c.film_width,
            c.aperture_radius, c.focus_distance, c.width, c.resolution, c.crop);
  }

  void add(const scene::Detectors& d) {
    (*this)(d.flux, d.path_length_bins, d.path_length_max, d.scattering_bins, d.exit_angle_bins,
            d.absorbed);
  }

  Hasher hasher_;
};

}  // namespace

std::uint64_t scene_hash(const Scene& s) {
  SceneHasher hash;
  const scene::Medium& m = s.medium;
  hash(arithmetic_version, m.box_min, m.box_max, m.sides, m.majorant_resolution, m.components,
       s.lights, s.camera, s.filter, s.filter_radius, s.background, s.sampler, s.marching_step,
       s.photons, stored_illumination_resolution(s), s.illumination_order, s.samples, s.seed,
       s.integrator, gather_bounces(s), s.single_scattering, s.detectors);
  // Scenes of before there were grounds keep their hash.
  for (unsigned face = 0; face < 6; ++face)
    if (m.ground[face]) hash(face, *m.ground[face]);
  // So do those whose camera paths draw from the scene's own seed; 6 is no face.
  if (s.gather_seed.value_or(s.seed) != s.seed) hash(6u, *s.gather_seed);
  return hash.value();
}

}  // namespace tyndall
