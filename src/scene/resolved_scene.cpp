#include "tyndall/render/resolved_scene.h"

#include <algorithm>
#include <array>
#include <string>

#include <fmt/ranges.h>

#include "scene/checker.h"
#include "scene/scene.h"
#include "tyndall/render/error.h"
#include "tyndall/render/image.h"
#include "tyndall/transport/film.h"
#include "tyndall/transport/illumination.h"

namespace tyndall {
namespace scene {
namespace {

void check_marching(Checker& check) {
  if (!check.is_good("marching_step") || !(check.scene.marching_step > 0)) return;
  if (check.scene.sampler != Sampler::ray_marching) {
    return check.warning("marching_step", "only the sampler ray_marching takes steps: not used");
  }
  const double across = glm::length(check.scene.medium.box_max - check.scene.medium.box_min);
  if (across / check.scene.marching_step > most_steps) {
    check.error("marching_step",
                fmt::format("expected at least {} (2^22 steps across the medium), got {}",
                            across / most_steps, check.scene.marching_step));
  }
}

template <class Sizes>
void all_or_none(Checker& check, const std::string& path, const Sizes& sizes) {
  const auto zeros = std::count(sizes.begin(), sizes.end(), 0);
  if (zeros != 0 && zeros != std::ssize(sizes))
    check.error(path, fmt::format("expected sizes above 0, or 0 for all, got [{}]",
                                  fmt::join(sizes, ", ")));
}

void check_detectors(Checker& check) {
  const Detectors& d = check.scene.detectors;
  check.ranges("detectors", d);
  if (check.is_good("detectors.flux")) all_or_none(check, "detectors.flux", d.flux);
  if (check.is_good("detectors.path_length.max") && d.path_length_bins > 0)
    check.number("detectors.path_length.max", d.path_length_max, limits::size);
  if (check.is_good("detectors.absorbed")) all_or_none(check, "detectors.absorbed", d.absorbed);
  if (d.any() && check.scene.integrator == Integrator::path)
    check.warning("detectors", "not used: they count photons, and the integrator path shoots none");
}

}  // namespace
}  // namespace scene

namespace {

template <class Sizes>
std::uint64_t product(const Sizes& sizes) {
  std::uint64_t cells = 1;
  for (const int n : sizes) cells *= static_cast<std::uint64_t>(std::max(n, 0));
  return cells;
}

}  // namespace

ResolvedScene::ResolvedScene(Scene scene, Problems& problems)
    : ResolvedScene(std::make_shared<const Scene>(std::move(scene))) {
  scene::Checker check(*scene_);
  check_medium(check, densities);
  check_lights(check);
  check.ranges("", *scene_);
  check_shines(check);
  check_camera(check);
  if (check.problems.errors.empty()) {
    resolve();
    check_cells(check, *this);
  }
  scene::check_marching(check);
  scene::check_detectors(check);
  problems = std::move(check.problems);
  warnings = problems.warnings;
}

ResolvedScene::ResolvedScene(Scene scene) {
  Problems problems;
  *this = ResolvedScene(std::move(scene), problems);
  std::string text;
  for (const Problem& p : problems.errors)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", p.path, p.message);
  if (!text.empty()) throw Error(ExitCode::scene_invalid, text);
}

ResolvedScene ResolvedScene::unchecked(Scene scene) {
  ResolvedScene out(std::make_shared<const Scene>(std::move(scene)));
  for (const scene::Component& c : out->medium.components)
    out.densities.push_back(measure_densities(c));
  out.resolve();
  return out;
}

void ResolvedScene::resolve() {
  illumination = plan_illumination(*scene_, densities);
  bounces = choose_bounces(*scene_, densities, illumination);
  illumination_order = scene_->illumination_order;
  if (illumination_order < 0)
    illumination_order = needed_illumination_order(*scene_) > 0 ? highest_order : 0;
}

std::uint64_t ResolvedScene::memory(int lights) const {
  const Scene& scene = *scene_;
  // Per pixel: integer tallies of a replicate and of all, the data of their spread, and 20 floats.
  const std::array<int, 4>& crop = scene.camera.crop;
  const std::uint64_t pixels = crop[2] == 0
                                   ? product(scene.camera.resolution)
                                   : product(std::array{crop[2] - crop[0], crop[3] - crop[1]});
  const std::uint64_t film = pixels * (2 * sizeof(PixelTally) + 48 + 80);

  // Per cell: RGB coefficients and the extinction as 64-bit integers for this replicate and the
  // next one, and once more as floats. Other replicates need only the coefficients.
  const auto moments =
      static_cast<std::uint64_t>(3 * (illumination_order + 1) * (illumination_order + 1));
  const std::uint64_t light =
      illumination.stored
      * ((moments + 1) * (2 * 8 + 4) + static_cast<std::uint64_t>(lights - 1) * moments * 8);

  // Per super-voxel: two bounds of each component. Per grid: its values, and a copy for the walks.
  const scene::Medium& medium = scene.medium;
  std::array<int, 3> super_voxels = medium.majorant_resolution;
  for (int& n : super_voxels) n = n == 0 ? 64 : n;  // 0: chosen later, at most 64
  std::uint64_t media = product(super_voxels) * medium.components.size() * 8;
  for (const scene::Component& c : medium.components) {
    if (const auto* grid = std::get_if<scene::DenseGrid>(&c.field))
      media += 2 * 4 * grid->values.size();
    if (std::get_if<scene::NoiseCloud>(&c.field)) media += 2u << 20;  // its table
  }
  for (const scene::Light& any :
       scene.lights) {  // an image's texels, and the table of their weights
    const auto* sky = std::get_if<scene::EnvironmentLight>(&any);
    if (sky && sky->image) media += (12 + 4) * sky->image->texels().size();
  }

  // Per bin: RGB, here and as text in the output.
  const scene::Detectors& d = scene.detectors;
  const std::uint64_t bins =
      6 * product(d.flux) + product(d.absorbed) + product(std::array{d.path_length_bins})
      + product(std::array{d.scattering_bins}) + product(std::array{d.exit_angle_bins});
  return film + light + media + bins * 3 * (2 * 8 + 24);
}

Problems check(const Scene& scene) {
  Problems problems;
  ResolvedScene(scene, problems);
  return problems;
}

}  // namespace tyndall
