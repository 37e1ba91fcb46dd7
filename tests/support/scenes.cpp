#include "support/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "tyndall/render/parallel.h"

namespace tyndall::test {
namespace {

double length_between(Vec3f a, Vec3f b) {
  const double x = double{b.x} - a.x, y = double{b.y} - a.y, z = double{b.z} - a.z;
  return std::sqrt(x * x + y * y + z * z);
}

/// Copies the tables in place: views point to them.
void replace(MajorantTables& tables, const MajorantTables& others) {
  std::copy(others.total.begin(), others.total.end(), tables.total.begin());
  std::copy(others.upper.begin(), others.upper.end(), tables.upper.begin());
  std::copy(others.lower.begin(), others.lower.end(), tables.lower.begin());
}

Tallies run(const Scene& scene, bool measure, const MajorantTables* bounds = nullptr) {
  Tallies out;
  const auto backend = make_cpu_backend();
  out.scene = prepare(scene, backend->threads());
  if (bounds) replace(out.scene.tables, *bounds);
  backend->load(out.scene, {});
  backend->shoot({0, scene.photons});
  if (measure) backend->measure(measurement::scattering, {0, out.scene.cells.count()});
  out.account = backend->take_account();
  out.illumination = backend->take_illumination();
  out.matter = backend->take(measurement::scattering);
  return out;
}

}  // namespace

scene::NoiseCloud low_variation(int octaves, std::uint32_t seed) {
  scene::NoiseCloud cloud;
  cloud.octaves = octaves;
  cloud.seed = seed;
  return cloud;
}

scene::NoiseCloud high_variation(int octaves, std::uint32_t seed) {
  scene::NoiseCloud cloud = low_variation(octaves, seed);
  cloud.contrast = 3.0;
  cloud.coverage = 0.0;
  cloud.falloff = 0.45;
  return cloud;
}

scene::DenseGrid random_grid(int nx, int ny, int nz, std::uint64_t seed) {
  scene::DenseGrid grid;
  grid.size = {nx, ny, nz};
  std::mt19937_64 engine(seed);
  for (int n = nx * ny * nz; n > 0; --n) {
    const std::uint64_t word = engine();
    const float value = static_cast<float>(word >> 40) * 0x1p-24f;
    const int kind = static_cast<int>(word & 7);
    grid.values.push_back(kind < 2 ? 0.0f : kind == 2 ? 10.0f * value : value);
  }
  return grid;
}

scene::DenseGrid ramp(int n, int axis) {
  scene::DenseGrid grid;
  grid.size = {2, 2, 2};
  grid.size[static_cast<std::size_t>(axis)] = n;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const int at = axis == 0 ? i : axis == 1 ? j : k;
        grid.values.push_back((static_cast<float>(at) + 0.5f) / static_cast<float>(n));
      }
    }
  }
  return grid;
}

double ramp_density(int n, double x) { return std::clamp(x, 0.5 / n, 1.0 - 0.5 / n); }

scene::Component component(scene::Field field, double extinction, double albedo,
                           scene::Phase phase) {
  scene::Component c;
  c.field = std::move(field);
  c.extinction = extinction;
  c.albedo = glm::dvec3(albedo);
  c.phase = phase;
  return c;
}

Scene furnace(std::vector<scene::Component> components) {
  Scene scene;
  scene.medium.majorant_resolution = {16, 16, 16};
  scene.medium.components = std::move(components);
  scene.lights = {scene::EnvironmentLight{}};
  scene.camera.resolution = {16, 16};
  scene.camera.fov = 30;
  scene.illumination_resolution = {16, 16, 16};
  scene.photons = 100000;
  return scene;
}

Scene coloured() {
  Scene scene = furnace({component(low_variation(4), 20, 1, scene::HenyeyGreensteinPhase{0.3}),
                         component(scene::Solid{scene::Sphere{{0.3, 0.4, 0.5}, 0.2}}, 10),
                         component(scene::Solid{scene::Sphere{{0.6, 0.5, 0.7}, 0.1}}, 50, 0)});
  scene.medium.components[0].albedo = {0.99, 0.7, 0.4};
  scene.medium.components[1].albedo = {0.3, 0.8, 0.6};
  scene.lights = {scene::PointLight{{2, 2, 2}, {3, 5, 4}}, scene::EnvironmentLight{{0.1, 0.2, 1}}};
  scene.photons = 20000;
  scene.samples = 1;
  scene.camera.resolution = {2, 2};
  return scene;
}

Scene slab(double optical_thickness, double albedo, scene::Phase phase) {
  Scene scene;
  scene.medium.sides = {scene::Side::periodic, scene::Side::periodic, scene::Side::open};
  scene.medium.majorant_resolution = {1, 1, 4};
  scene.medium.components = {component(scene::Solid{}, optical_thickness, albedo, phase)};
  scene.lights = {scene::DirectionalLight{{0, 0, 1}, glm::dvec3(1)}};
  scene.camera.resolution = {16, 16};
  scene.illumination_resolution = {1, 1, 64};
  return scene;
}

std::vector<FreePath> fly(const PreparedScene& scene, const AnySampler& sampler, const Ray& ray,
                          std::uint64_t n, std::uint64_t seed) {
  std::vector<FreePath> paths(n);
  std::visit(
      [&](const auto& medium, const auto& flying) {
        parallel_for(0, n, 256, 0, [&](std::uint64_t begin, std::uint64_t end) {
          for (std::uint64_t i = begin; i < end; ++i) {
            const RandomStream random{seed, i, Domain::photon};
            Path path{ray, exponential(random.block(0, Purpose::emission).d), 0, {}};
            Audit audit;
            const Flight flight = flying.fly(medium, path, random, audit);
            paths[i] = {flight.end == Flight::End::collided, flight.component,
                        length_between(ray.origin, path.ray.origin)};
          }
        });
      },
      scene.medium, sampler);
  return paths;
}

double distance_to_exit(const Box& box, const Ray& ray) {
  const auto along = [](double origin, double direction, double extent) {
    if (direction == 0) return 1e300;
    return ((direction > 0 ? extent : 0.0) - origin) / direction;
  };
  return std::min({along(ray.origin.x, ray.direction.x, box.extent.x),
                   along(ray.origin.y, ray.direction.y, box.extent.y),
                   along(ray.origin.z, ray.direction.z, box.extent.z)});
}

float sigma_t_at(const PreparedScene& scene, Vec3f p) {
  return std::visit([&](const auto& medium) { return total_sigma_t(medium, p); }, scene.medium);
}

OpticalDepth::OpticalDepth(const PreparedScene& scene, const Ray& ray, int points) {
  const Box box = std::visit([](const auto& medium) { return medium.whole.box; }, scene.medium);
  step_ = distance_to_exit(box, ray) / points;
  table_.assign(static_cast<std::size_t>(points) + 1, 0.0);
  parallel_for(0, static_cast<std::uint64_t>(points), 1024, 0,
               [&](std::uint64_t begin, std::uint64_t end) {
                 for (std::uint64_t i = begin; i < end; ++i) {
                   const double t = (static_cast<double>(i) + 0.5) * step_;
                   const Vec3f p{static_cast<float>(ray.origin.x + t * ray.direction.x),
                                 static_cast<float>(ray.origin.y + t * ray.direction.y),
                                 static_cast<float>(ray.origin.z + t * ray.direction.z)};
                   table_[i + 1] = sigma_t_at(scene, p) * step_;
                 }
               });
  for (std::size_t i = 1; i < table_.size(); ++i) table_[i] += table_[i - 1];
}

double OpticalDepth::at(double distance) const {
  const double x = std::clamp(distance / step_, 0.0, static_cast<double>(table_.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(x), table_.size() - 2);
  return table_[i] + (x - static_cast<double>(i)) * (table_[i + 1] - table_[i]);
}

Tallies shoot(const Scene& scene) { return run(scene, false); }
Tallies shoot_and_measure(const Scene& scene) { return run(scene, true); }
Tallies shoot_and_measure(const Scene& scene, const MajorantTables& bounds) {
  return run(scene, true, &bounds);
}

BakedLight baked(const Scene& scene, bool with_directions, bool per_light, bool multiple_only) {
  const ResolvedScene whole = scene_to_bake(scene, with_directions, per_light, multiple_only);
  RenderOptions options;
  options.photons = IndexRange{0, whole->photons};
  options.measures_matter = true;
  const auto backend = make_cpu_backend();
  Renderer renderer(whole, *backend, options);
  EXPECT_TRUE(renderer.run());
  return bake(renderer, whole);
}

std::vector<RenderResult> replicates(Scene scene, int count) {
  const auto backend = make_cpu_backend();
  std::vector<RenderResult> results;
  for (int i = 0; i < count; ++i, ++scene.seed) results.push_back(render(scene, *backend));
  return results;
}

const PictureLayer& layer(const RenderResult& result, const std::string& name) {
  for (const PictureLayer& l : result.picture.layers)
    if (l.name == name) return l;
  static const PictureLayer none;
  ADD_FAILURE() << "no layer " << name;
  return none;
}

double mean_of_picture(const RenderResult& result, int channel) {
  const std::vector<float>& rgba = result.picture.rgba;
  double sum = 0;
  for (std::size_t i = static_cast<std::size_t>(channel); i < rgba.size(); i += 4) sum += rgba[i];
  return 4 * sum / static_cast<double>(rgba.size());
}

double student_p(double t, int degrees_of_freedom) {
  if (std::isnan(t)) return 0;
  const int n = degrees_of_freedom;
  const double angle = std::atan(std::abs(t) / std::sqrt(static_cast<double>(n)));
  const double s = std::sin(angle), c = std::cos(angle);
  double term = n % 2 == 0 ? 1.0 : c, sum = n == 1 ? 0.0 : term;
  for (int k = n % 2 == 0 ? 2 : 3; k < n; k += 2) {
    term *= c * c * (k - 1) / k;
    sum += term;
  }
  const double within = n % 2 == 0 ? s * sum : 2 / 3.14159265358979323846 * (angle + s * sum);
  return std::max(0.0, 1 - within);
}

double replicates_p(const Series& replicates, double expected) {
  const double difference = replicates.mean() - expected;
  if (difference == 0) return 1;
  return student_p(difference / replicates.standard_error(),
                   static_cast<int>(replicates.count()) - 1);
}

double replicates_p(const Series& a, const Series& b) {
  if (a.mean() == b.mean()) return 1;
  const double na = static_cast<double>(a.count()), nb = static_cast<double>(b.count());
  const double pooled = ((na - 1) * a.variance() + (nb - 1) * b.variance()) / (na + nb - 2);
  return student_p((a.mean() - b.mean()) / std::sqrt(pooled * (1 / na + 1 / nb)),
                   static_cast<int>(na + nb) - 2);
}

Scene quick() {
  Scene scene = coloured();
  scene.photons = 2000;
  scene.samples = 9;
  scene.illumination_resolution = {5, 5, 5};
  scene.camera.resolution = {12, 7};
  scene.detectors.flux = {2, 2};
  return scene;
}

void expect_same(const RenderResult& a, const RenderResult& b) {
  EXPECT_EQ(a.hashes.tallies, b.hashes.tallies);
  EXPECT_EQ(a.hashes.pixels, b.hashes.pixels);
  EXPECT_EQ(a.detected, b.detected);
  EXPECT_EQ(layer(a, "depth").values, layer(b, "depth").values);
  EXPECT_EQ(std::memcmp(&a.ledger, &b.ledger, sizeof a.ledger), 0);
}

}  // namespace tyndall::test
