#include <cstring>
#include <type_traits>

#include "scene/scene.h"
#include "tyndall/base/hash.h"
#include "tyndall/render/image.h"
#include "tyndall/render/render.h"
#include "tyndall/render/volume.h"

namespace tyndall {
namespace {

template <class T>
class MemberHasher;

/// Adds every value of a scene to the hash, in the order of the keys. Variants add their index.
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
  void add(const std::optional<glm::dmat4>& m) {
    (*this)(m.has_value(), m.value_or(glm::dmat4(1)));
  }
  void add(const std::optional<scene::SparseGrid::Bounds>& box) {
    if (box) (*this)(box->low, box->high);
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
  void add(const std::string& text) {
    add(text.size());
    for (const char c : text) add(c);
  }
  template <class... T>
  void add(const std::variant<T...>& v) {
    add(v.index());
    std::visit([&](const auto& x) { add(x); }, v);
  }
  void add(const std::shared_ptr<const Volume>& volume) { add(volume->hash()); }
  void add(const std::shared_ptr<const scene::PhaseTable>& table) {
    (*this)(table->cosines, table->values);
  }
  void add(const scene::EnvironmentLight& l) {  // an image replaces the radiance
    if (l.image)
      (*this)(true, l.image->hash(), l.rotation);
    else
      (*this)(false, l.radiance);
    (*this)(l.scale, l.group);
  }
  /// Adds a thing that has keys.
  template <class T>
  requires(std::is_aggregate_v<T>) void add(const T& thing) {
    MemberHasher<T> members(*this, thing);
    scene::visit_keys<T>(members);
  }

  Hasher hasher_;
};

template <class T>
class MemberHasher : public scene::Visitor<MemberHasher<T>> {
 public:
  MemberHasher(SceneHasher& hash, const T& thing) : hash_(hash), thing_(thing) {}

  template <class M, class Form>
  void operator()(scene::Name, M T::*member, const Form&, const char*, const char*) {
    hash_(thing_.*member);
  }
  template <class M>
  void unwritten(M T::*member) {
    hash_(thing_.*member);
  }

 private:
  SceneHasher& hash_;
  const T& thing_;
};

/// \param seen by this camera \param gather_seed of the camera paths; unset: the scene's seed
std::uint64_t hash_of(const ResolvedScene& resolved, const scene::Camera& seen,
                      const std::optional<std::uint64_t>& gather_seed) {
  SceneHasher hash;
  // Lists all members, so that a new one does not compile until it is considered here. Only
  // previews use the exposure.
  const auto& [medium, lights, unused_camera, background, sampler, marching_step, integrator,
               photons, illumination_resolution, illumination_order, samples, bounces,
               single_scattering, seed, unused_seed, filter, filter_radius, exposure, detectors] =
      *resolved;
  const auto& [box_min, box_max, sides, ground, majorant_resolution, components] = medium;
  hash(arithmetic_version, box_min, box_max, sides, majorant_resolution, components, lights, seen,
       filter, filter_radius, background, sampler, marching_step, photons,
       resolved.illumination.cells, illumination_order, samples, seed, integrator, resolved.bounces,
       single_scattering, detectors);
  // Scenes without grounds keep the hash of versions that had none.
  for (unsigned face = 0; face < 6; ++face)
    if (ground[face]) hash(face, *ground[face]);
  // Scenes whose camera paths use the scene's seed also keep their hash. 6 is not a face.
  if (gather_seed.value_or(seed) != seed) hash(6u, *gather_seed);
  return hash.value();
}

}  // namespace

std::uint64_t scene_hash(const ResolvedScene& scene) {
  return hash_of(scene, scene->camera, scene->gather_seed);
}
std::uint64_t light_hash(const ResolvedScene& scene) { return hash_of(scene, {}, {}); }

}  // namespace tyndall
