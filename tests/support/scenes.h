/// \file
/// Scenes of several tests, and functions that run single walks and passes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/statistics.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/bake.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"

namespace tyndall::test {

// ---- Fields

/// The presets of the scene files.
scene::NoiseCloud low_variation(int octaves, std::uint32_t seed = 7);
scene::NoiseCloud high_variation(int octaves, std::uint32_t seed = 7);

/// Densities in [0, 1), some voxels empty, some ten times as dense as the others.
scene::DenseGrid random_grid(int nx, int ny, int nz, std::uint64_t seed);

/// \return a grid whose voxel i of n along `axis` has the value (i + 0.5) / n; 2 voxels along the
/// other axes.
scene::DenseGrid ramp(int n, int axis);
/// \return the density of ramp() at x along its axis: linear between the outer voxel centres.
double ramp_density(int n, double x);

// ---- Scenes

scene::Component component(scene::Field field, double extinction, double albedo = 1.0,
                           scene::Phase phase = scene::IsotropicPhase{});

/// \return the unit box in a constant environment of radiance 1, few super-voxels, a small picture.
Scene furnace(std::vector<scene::Component> components);

/// \return coloured and black components, a local light and a sky: photons miss, escape through all
/// faces and are absorbed in all components.
Scene coloured();

/// \return a homogeneous layer of unit thickness, periodic in x and y, lit along +z. Reflected
/// light leaves through face 4, transmitted light through face 5.
Scene slab(double optical_thickness, double albedo, scene::Phase phase = scene::IsotropicPhase{});

/// Without check(): most of these scenes have no light.
inline ResolvedScene resolved(const Scene& scene) { return ResolvedScene::unchecked(scene); }
inline PreparedScene prepare(const Scene& scene, int threads,
                             const std::function<void(double)>& progress = {},
                             const Stop& stop = {}) {
  return tyndall::prepare(resolved(scene), threads, progress, stop);
}

// ---- Flights

struct FreePath {
  bool collided;
  int component;    ///< of the prepared medium
  double distance;  ///< from the start of the flight to its end [length]
};

/// \return first flights of photons 0 to n - 1 along a ray that starts in or on the box of local
/// space.
std::vector<FreePath> fly(const PreparedScene& scene, const AnySampler& sampler, const Ray& ray,
                          std::uint64_t n, std::uint64_t seed);

/// \return the distance at which a ray that starts in or on the box leaves it [length].
double distance_to_exit(const Box& box, const Ray& ray);

/// \return the extinction of all components at a point of local space, as in the walks [1/length].
float sigma_t_at(const PreparedScene& scene, Vec3f p);

/// Tabulated optical depth along a ray: midpoint rule in double over the field in float.
class OpticalDepth {
 public:
  OpticalDepth(const PreparedScene& scene, const Ray& ray, int points);
  double total() const { return table_.back(); }
  double at(double distance) const;

 private:
  double step_;
  std::vector<double> table_;  // at the ends of the steps
};

// ---- Passes

struct Tallies {
  Account account;
  PreparedScene scene;
  std::vector<std::int64_t> illumination, matter;
};

/// Shoots the photons of `scene` on the CPU; no pictures.
Tallies shoot(const Scene& scene);
/// Shoots the photons and measures the medium.
Tallies shoot_and_measure(const Scene& scene);
/// Uses `bounds` instead of the scene's own, for the same number of super-voxels.
Tallies shoot_and_measure(const Scene& scene, const MajorantTables& bounds);

/// \return the light that `tyndall bake` writes.
BakedLight baked(const Scene& scene, bool with_directions = true, bool per_light = false,
                 bool multiple_only = false);

/// Renders `scene` on the CPU with `count` successive seeds from its own on.
std::vector<RenderResult> replicates(Scene scene, int count);

/// \return measure(result) of every replicate.
template <class Measure>
Series series(const std::vector<RenderResult>& results, Measure&& measure) {
  Series s;
  for (const RenderResult& result : results) s.add(measure(result));
  return s;
}

/// \return a layer of the picture; fails the test if there is none.
const PictureLayer& layer(const RenderResult& result, const std::string& name);

/// \return the mean of a channel over the picture: 0 to 2 red, green and blue, 3 alpha.
double mean_of_picture(const RenderResult& result, int channel = 0);

// ---- Statistics of few replicates

/// Two-sided p of Student's t.
double student_p(double t, int degrees_of_freedom);
/// p of a mean of few numbers (replicates) if the true mean is `expected`.
double replicates_p(const Series& replicates, double expected);
/// p of two means of few numbers of similar spread if the true means are equal.
double replicates_p(const Series& a, const Series& b);

/// \return a scene that is fast to render and has every kind of tally.
Scene quick();
/// Expects equal bits of tallies, picture, detectors, depth and ledger.
void expect_same(const RenderResult& a, const RenderResult& b);

}  // namespace tyndall::test
