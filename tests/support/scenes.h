/// \file
/// Scenes that several tests use, and what it takes to run their walks and passes by hand.
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

/// Voxel i of n along `axis` holds its middle, (i + 0.5) / n; 2 voxels across.
scene::DenseGrid ramp(int n, int axis);
/// The density of ramp() at x along its axis: linear between the first and the last middle.
double ramp_density(int n, double x);

// ---- Scenes

scene::Component component(scene::Field field, double extinction, double albedo = 1.0,
                           scene::Phase phase = scene::IsotropicPhase{});

/// The unit box, lit from everywhere with radiance 1, few super-voxels, a small picture.
Scene furnace(std::vector<scene::Component> components);

/// Coloured and black matter, a lamp and a sky: light misses, escapes everywhere, is absorbed in
/// all components.
Scene coloured();

/// A homogeneous layer of unit thickness, periodic in x and y, lit along +z: what is reflected
/// leaves through face 4, what is transmitted through face 5.
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
  double distance;  ///< from where the flight began to where it ended [length]
};

/// First flights of photons 0 to n - 1 along one ray, which starts in or on the box of local space.
std::vector<FreePath> fly(const PreparedScene& scene, const AnySampler& sampler, const Ray& ray,
                          std::uint64_t n, std::uint64_t seed);

/// Where a ray that starts in or on the box leaves it [length].
double distance_to_exit(const Box& box, const Ray& ray);

/// Extinction of all components at a point of local space, as the walks would see it [1/length].
float sigma_t_at(const PreparedScene& scene, Vec3f p);

/// Optical depth along a ray, tabulated: middle rule in double over the field as it is in float.
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
/// The same, and measures the matter.
Tallies shoot_and_measure(const Scene& scene);
/// With other bounds than its own, for as many super-voxels.
Tallies shoot_and_measure(const Scene& scene, const MajorantTables& bounds);

/// What `tyndall bake` writes.
BakedLight baked(const Scene& scene, bool with_directions = true, bool per_light = false,
                 bool multiple_only = false);

/// Renders `scene` on the CPU with `count` seeds from its own one on: replicates of its picture.
std::vector<RenderResult> replicates(Scene scene, int count);

/// measure(result) of every replicate.
template <class Measure>
Series series(const std::vector<RenderResult>& results, Measure&& measure) {
  Series s;
  for (const RenderResult& result : results) s.add(measure(result));
  return s;
}

/// A layer of the picture; a failure of the test where there is none.
const PictureLayer& layer(const RenderResult& result, const std::string& name);

/// Mean of a channel over the picture: 0 to 2 red, green and blue, 3 alpha.
double mean_of_picture(const RenderResult& result, int channel = 0);

// ---- Statistics of few replicates

/// Two-sided p of Student's t.
double student_p(double t, int degrees_of_freedom);
/// p of a mean of few numbers (replicates) if the true one is `expected`.
double replicates_p(const Series& replicates, double expected);
/// p of two means of few numbers of like spread if the true ones are equal.
double replicates_p(const Series& a, const Series& b);

/// Small enough to be rendered many times, with every kind of tally.
Scene quick();
/// In every bit: tallies, picture, detectors, depth, ledger.
void expect_same(const RenderResult& a, const RenderResult& b);

}  // namespace tyndall::test
