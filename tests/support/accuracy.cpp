#include "support/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include "io/phase_file.h"
#include "support/adding_doubling.h"
#include "support/volumes.h"
#include "tyndall/render/part.h"

namespace tyndall::test {
namespace {

namespace fs = std::filesystem;

constexpr int width = 32, block = 8, blocks_across = width / block;
constexpr double slab_cosine = 0.25;  ///< of sideways views of slabs with the normal
// With four errors added to what is allowed, 3 % in the mean and 3.5 % RMS cannot pass.
constexpr double mean_noise = 0.005, square_noise = 2e-4;
constexpr std::size_t first_pictures = 8, most_pictures = 64;

fs::path source_folder() {
  const fs::path folder = folder_named_by("TYNDALL_SOURCE_DIR");
  return folder.empty() ? fs::current_path() : folder;
}

constexpr scene::TwoLobesPhase two_lobes{0.9, -0.4, 0.85};

scene::Phase phase_of(const Combination& c) {
  if (c.phase == "two lobes") return two_lobes;
  if (c.phase == "droplets")
    return scene::TabulatedPhase{
        io::read_phase_file((source_folder() / "scenes" / "mie_cloud.phase").string())};
  return scene::HenyeyGreensteinPhase{std::stod(c.phase)};
}

std::vector<double> moments_of(const Combination& c) {
  constexpr int count = 400;
  if (c.phase != "two lobes") return henyey_greenstein_moments(std::stod(c.phase), count);
  std::vector<double> first = henyey_greenstein_moments(two_lobes.g1, count);
  const std::vector<double> second = henyey_greenstein_moments(two_lobes.g2, count);
  for (std::size_t l = 0; l < first.size(); ++l)
    first[l] = two_lobes.weight * first[l] + (1 - two_lobes.weight) * second[l];
  return first;
}

/// \return the direction in which the first sun's light travels. Slabs are normal to z.
glm::dvec3 sunlight(const Combination& c) {
  return c.lights == "aslant" || c.lights == "sky" ? glm::dvec3(0.8, 0, 0.6) : glm::dvec3(0, 0, 1);
}

std::vector<scene::Light> lights_of(const Combination& c) {
  scene::DirectionalLight sun{sunlight(c), glm::dvec3(1)};
  if (c.lights == "sky") {
    sun.angle = 5;
    return {sun, scene::EnvironmentLight{glm::dvec3(0.1)}};
  }
  if (c.lights != "many") return {sun};
  std::vector<scene::Light> lights{sun, scene::DirectionalLight{{0.7, -0.3, 0.5}, {0.2, 0.5, 0.8}},
                                   scene::DirectionalLight{{-0.2, 0.9, -0.4}, {0.8, 0.5, 0.2}}};
  if (c.medium != "slab")  // a periodic slab would have infinitely many images of it
    lights.push_back(scene::SphereLight{{1.6, 0.3, 1.4}, 0.3, glm::dvec3(1)});
  return lights;
}

scene::Field field_of(const Combination& c) {
  if (c.medium == "noise") return low_variation(6);
  if (c.medium == "vdb") {
    scene::SparseGrid grid;
    grid.volume = load("ball.vdb").volume;
    grid.fit = scene::SparseGrid::Fit::unit_cube;
    return grid;
  }
  if (c.medium == "ball") return scene::Solid{scene::Sphere{}};
  return scene::Solid{};
}

/// \return the optical depth through the middle, along z.
double optical_depth(const Scene& scene) {
  return OpticalDepth(prepare(scene, 0), Ray{{0.5f, 0.5f, 0}, {0, 0, 1}}, 4000).total();
}

/// \return the exact radiance of slabs lit along their normal; empty for other media.
std::optional<double> exact_radiance(const Combination& c) {
  if (c.medium != "slab" || c.lights != "zenith" || c.phase == "droplets") return {};
  const bool is_sharp = c.phase == "0.95" || c.phase == "two lobes";
  const SlabReference reference(c.optical_depth, c.albedo, moments_of(c), {slab_cosine},
                                is_sharp ? 160 : 64);
  return c.view == "forwards"    ? reference.transmitted(-1)
         : c.view == "backwards" ? reference.reflected(-1)
                                 : reference.reflected(0);
}

/// Renders pictures; each is a replicate of a render, with its own photons and light. The
/// replicates of a render share the measured medium.
class Pictures {
 public:
  Pictures(const Scene& scene, Backend& backend) : scene_(scene), backend_(&backend) {}

  void add_to(Replicates& pictures, std::size_t count) {
    for (; count > 0; --count, ++next_) {
      if (next_ == most_replicates) next_ = 0, ++scene_.seed, measured_.reset();
      const std::uint64_t samples = scene_.samples / most_replicates;
      RenderOptions options;
      options.samples = IndexRange{next_ * samples, (next_ + 1) * samples};
      options.keeps_light = true;
      Renderer renderer(scene_, *backend_, options);
      if (measured_) renderer.resume(*measured_, "what was measured");
      renderer.run();
      pictures.push_back(blocks(renderer.result()));
      measured_ = renderer.part();
      measured_->replicates.assign(most_replicates, {});
      measured_->film = {};
    }
  }

 private:
  Scene scene_;
  Backend* backend_;
  std::uint64_t next_ = 0;
  std::optional<Partial> measured_;
};

Scene by_paths(Scene scene) {
  scene.integrator = scene::Integrator::path;
  scene.seed += 1000;
  return scene;
}

bool is_noisy(const Bias& b, double noise) {
  return b.mean.error > noise * mean_noise || b.square.error > noise * noise * square_noise;
}

fs::path record() { return source_folder() / "tests" / "golden" / "blocks.txt"; }

}  // namespace

std::string Combination::name() const {
  char text[200];
  std::snprintf(text, sizeof text, "%s, optical depth %g, %s, %s, %s, albedo %g", phase.c_str(),
                optical_depth, lights.c_str(), medium.c_str(), view.c_str(), albedo);
  return text;
}

const std::vector<Combination>& combinations() {
  static const std::vector<Combination> all{
      {"-0.9", 0.1, "many", "ball", "sideways", 0.9},
      {"-0.9", 1, "zenith", "slab", "backwards", 1},
      {"-0.9", 10, "aslant", "slab", "forwards", 1},
      {"-0.9", 100, "sky", "noise", "forwards", 0.9},
      {"-0.5", 0.1, "zenith", "noise", "sideways", 1},
      {"-0.5", 1, "aslant", "slab", "forwards", 0.9},
      {"-0.5", 10, "many", "ball", "backwards", 1},
      {"-0.5", 100, "sky", "noise", "backwards", 0.9},
      {"0", 0.1, "sky", "ball", "backwards", 1},
      {"0", 1, "many", "ball", "sideways", 0.9},
      {"0", 10, "aslant", "noise", "sideways", 0.9},
      {"0", 100, "zenith", "slab", "forwards", 1},
      {"0.5", 0.1, "sky", "noise", "backwards", 0.9},
      {"0.5", 1, "zenith", "ball", "forwards", 0.9},
      {"0.5", 10, "aslant", "noise", "backwards", 1},
      {"0.5", 100, "many", "slab", "sideways", 1},
      {"0.7", 0.1, "aslant", "slab", "backwards", 1},
      {"0.7", 1, "sky", "noise", "sideways", 1},
      {"0.7", 10, "many", "ball", "forwards", 0.9},
      {"0.7", 100, "zenith", "slab", "backwards", 0.9},
      {"0.85", 0.1, "sky", "slab", "forwards", 0.9},
      {"0.85", 1, "many", "noise", "backwards", 1},
      {"0.85", 1, "aslant", "ball", "backwards", 1},
      {"0.85", 10, "zenith", "ball", "sideways", 0.9},
      {"0.85", 10, "zenith", "slab", "forwards", 1},
      {"0.85", 10, "many", "noise", "sideways", 1},
      {"0.85", 100, "aslant", "slab", "sideways", 1},
      {"0.95", 0.1, "many", "ball", "forwards", 0.9},
      {"0.95", 1, "sky", "noise", "sideways", 0.9},
      {"0.95", 1, "zenith", "slab", "sideways", 1},
      {"0.95", 10, "zenith", "slab", "backwards", 1},
      {"0.95", 100, "aslant", "slab", "sideways", 1},
      {"two lobes", 0.1, "zenith", "slab", "backwards", 1},
      {"two lobes", 1, "many", "noise", "forwards", 0.9},
      {"two lobes", 10, "sky", "slab", "backwards", 1},
      {"two lobes", 100, "aslant", "ball", "sideways", 0.9},
      {"droplets", 0.1, "many", "noise", "sideways", 1},
      {"droplets", 1, "aslant", "noise", "sideways", 1},
      {"droplets", 10, "sky", "ball", "forwards", 0.9},
      {"droplets", 100, "zenith", "slab", "backwards", 0.9},
  };
  return all;
}

Scene scene_of(const Combination& c) {
  Scene scene;
  scene.medium.components = {component(field_of(c), 1, c.albedo, phase_of(c))};
  if (c.medium == "slab")
    scene.medium.sides = {scene::Side::periodic, scene::Side::periodic, scene::Side::open};
  scene.lights = lights_of(c);
  scene.medium.components[0].extinction = c.optical_depth / optical_depth(scene);
  // The sideways view of a slab is a grazing view of its lit face.
  const glm::dvec3 sun = sunlight(c), middle(0.5);
  const glm::dvec3 across =
      c.medium == "slab" ? glm::dvec3(0, std::sqrt(1 - slab_cosine * slab_cosine), slab_cosine)
                         : glm::dvec3(0, 1, 0);
  const glm::dvec3 look = c.view == "forwards" ? -sun : c.view == "backwards" ? sun : across;
  scene.camera.projection = scene::Projection::orthographic;
  scene.camera.position = middle - 3.0 * look;
  scene.camera.look_at = middle;
  scene.camera.up = c.view == "sideways" ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  scene.camera.width = 1;
  scene.camera.resolution = {width, width};
  scene.photons = most_replicates * 100000;
  // Few samples of a thin medium collide.
  scene.samples = most_replicates * (c.optical_depth < 1 ? 1024 : 256);
  return scene;
}

std::vector<double> blocks(const RenderResult& result) {
  std::vector<double> sums(blocks_across * blocks_across, 0.0);
  for (const char* name : {"single", "multiple"}) {
    const std::vector<float>& values = layer(result, name).values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t x = i / 3 % width, y = i / 3 / width;
      sums[y / block * blocks_across + x / block] += values[i] / (3.0 * block * block);
    }
  }
  return sums;
}

Comparison compare(const Combination& c) {
  const auto backend = make_cpu_backend();
  const Scene scene = scene_of(c);
  if (const std::optional<double> exact = exact_radiance(c))
    return compare(scene, {std::vector<double>(blocks_across * blocks_across, *exact)}, c.noise);
  Pictures photons(scene, *backend), paths(by_paths(scene), *backend);
  Replicates pictures, truth;
  photons.add_to(pictures, first_pictures);
  paths.add_to(truth, first_pictures);
  Bias b = bias(pictures, truth);
  while (is_noisy(b, c.noise)) {
    const bool is_truth = b.from_truth > b.from_pictures;
    Replicates& more = is_truth ? truth : pictures;
    if (more.size() >= most_pictures) break;
    (is_truth ? paths : photons).add_to(more, 4);
    b = bias(pictures, truth);
  }
  return {b, pictures.size(), truth.size()};
}

Comparison compare(const Scene& scene, const Replicates& truth, double noise) {
  const auto backend = make_cpu_backend();
  Pictures photons(scene, *backend);
  Replicates pictures;
  photons.add_to(pictures, first_pictures);
  Bias b = bias(pictures, truth);
  while (is_noisy(b, noise) && pictures.size() < most_pictures) {
    photons.add_to(pictures, 4);
    b = bias(pictures, truth);
  }
  return {b, pictures.size(), truth.size()};
}

void expect_accurate(const Comparison& comparison, const std::string& name, double noise) {
  const Bias& b = comparison.bias;
  std::printf(
      "%s: mean %+.2f +- %.2f %%, RMS^2 %+.4f +- %.4f %% (%zu pictures, %zu of the truth)\n",
      name.c_str(), 100 * b.mean.value, 100 * b.mean.error, 100 * b.square.value,
      100 * b.square.error, comparison.pictures, comparison.truth);
  std::fflush(stdout);
  EXPECT_LE(b.mean.error, noise * mean_noise) << name;
  EXPECT_LE(b.square.error, noise * noise * square_noise) << name;
  EXPECT_LT(std::abs(b.mean.value), 0.01 + 4 * b.mean.error) << name;
  EXPECT_LT(b.square.value, 0.02 * 0.02 + 4 * b.square.error) << name;
}

std::vector<Combination> recorded() {
  return {{"0.85", 10, "aslant", "noise", "sideways", 1},
          {"0.85", 10, "aslant", "vdb", "sideways", 1}};
}

Scene scene_of_recorded(const Combination& c) {
  Scene scene = scene_of(c);
  scene.camera.width = 0.6;  // the medium fills all blocks
  return scene;
}

void print_record() {
  const auto backend = make_cpu_backend();
  for (const Combination& c : recorded()) {
    Scene scene = by_paths(scene_of_recorded(c));
    scene.samples *= 16;
    Replicates truth;
    Pictures(scene, *backend).add_to(truth, most_replicates);
    for (const std::vector<double>& picture : truth) {
      std::printf("%s", c.medium.c_str());
      for (const double radiance : picture) std::printf(" %.6g", radiance);
      std::printf("\n");
      std::fflush(stdout);
    }
  }
}

Replicates read_record(const std::string& medium) {
  Replicates truth;
  std::ifstream file(record());
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    if (name != medium) continue;
    truth.emplace_back();
    for (double radiance; words >> radiance;) truth.back().push_back(radiance);
  }
  return truth;
}

}  // namespace tyndall::test
