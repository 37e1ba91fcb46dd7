/// \file
/// tyndall-bias: the bias of the photons' pictures against the path tracer's, with the noise
/// averaged out, per scene, grid and bounces; or of slabs against a deterministic reference, per
/// phase function, optical depth and bounces. Prints tables in Markdown.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "io/scene_json.h"
#include "support/adding_doubling.h"
#include "support/bias.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall::bench {
namespace {

struct Options {
  std::vector<std::string> scenes;
  std::vector<int> grids{64, 128, 256};
  std::vector<int> bounces{0, 1, 2};
  int seeds = 8, width = 48;
  std::uint64_t photons = 4000000, samples = 64, path_samples = 1024;
  bool slabs = false, behind = false;
  std::vector<double> depths{0.1, 2, 10, 100}, gs{0, 0.5, 0.85, 0.95};
};

/// One picture per seed.
using Replicates = std::vector<Picture>;

Replicates replicates(Scene scene, int seeds, Backend& backend) {
  Replicates out;
  for (int i = 0; i < seeds; ++i, ++scene.seed) out.push_back(render(scene, backend).picture);
  return out;
}

double grey(const Picture& picture, std::size_t pixel) {
  const float* rgba = picture.rgba.data() + 4 * pixel;
  return (double{rgba[0]} + double{rgba[1]} + double{rgba[2]}) / 3;
}

/// \return the mean of value(picture, pixel) over the replicates.
template <class Value>
double mean(const Replicates& pictures, std::size_t pixel, const Value& value) {
  double sum = 0;
  for (const Picture& picture : pictures) sum += value(picture, pixel);
  return sum / static_cast<double>(pictures.size());
}

/// \return the grey values of `pixels` in each picture.
test::Replicates greys(const Replicates& pictures, const std::vector<std::size_t>& pixels) {
  test::Replicates out;
  for (const Picture& picture : pictures) {
    out.emplace_back();
    for (const std::size_t p : pixels) out.back().push_back(grey(picture, p));
  }
  return out;
}

using test::Bias;

Bias bias(const Replicates& photons, const Replicates& paths,
          const std::vector<std::size_t>& pixels) {
  return test::bias(greys(photons, pixels), greys(paths, pixels));
}

/// Prints the RMS, or an upper limit (two standard deviations) if the RMS is below its noise.
void print_rms(const Bias& b) {
  if (b.square.value > 2 * b.square.error) {
    const double rms = std::sqrt(b.square.value);
    std::printf(" %.2f ± %.2f %% |", 100 * rms, 100 * b.square.error / (2 * rms));
  } else {
    std::printf(" < %.2f %% |",
                100 * std::sqrt(std::max(0.0, b.square.value) + 2 * b.square.error));
  }
}

/// Prints the bias of all pixels, of the covered ones, and of the brighter and the darker half of
/// the covered ones.
void print_row(const std::string& name, const Replicates& photons, const Replicates& paths) {
  const auto alpha = [](const Picture& picture, std::size_t p) {
    return double{picture.rgba[4 * p + 3]};
  };
  std::vector<std::pair<double, std::size_t>> covered;
  std::vector<std::size_t> all, cloud;
  for (std::size_t p = 0; p < paths[0].rgba.size() / 4; ++p) {
    all.push_back(p);
    if (mean(paths, p, alpha) > 0.5) covered.emplace_back(-mean(paths, p, grey), p);
  }
  if (covered.size() < 2) throw Error(ExitCode::usage, name + ": no pixels with cloud");
  std::sort(covered.begin(), covered.end());
  std::vector<std::size_t> halves[2];
  for (std::size_t i = 0; i < covered.size(); ++i) {
    cloud.push_back(covered[i].second);
    halves[2 * i < covered.size() ? 0 : 1].push_back(covered[i].second);
  }
  std::printf("| %s |", name.c_str());
  print_rms(bias(photons, paths, all));
  print_rms(bias(photons, paths, cloud));
  for (const std::vector<std::size_t>& half : halves) {
    const Bias b = bias(photons, paths, half);
    print_rms(b);
    std::printf(" %+.2f ± %.2f %% |", 100 * b.mean.value, 100 * b.mean.error);
  }
  std::printf("\n");
  std::fflush(stdout);
}

/// \return the size of a grid of cubical cells, `resolution` along the longest edge of the box.
std::array<int, 3> grid_of(const Scene& scene, int resolution) {
  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  const double longest = std::max({extent.x, extent.y, extent.z});
  const auto along = [&](double edge) {
    return std::max(1, static_cast<int>(std::lround(resolution * edge / longest)));
  };
  return {along(extent.x), along(extent.y), along(extent.z)};
}

/// A slab of albedo 1 under a directional light, seen along the light's direction. \param cells
/// across it, 0: the default \param behind seen from its dark side
Scene slab(double depth, double g, int cells, bool behind) {
  Scene scene;
  scene.medium.sides = {scene::Side::periodic, scene::Side::periodic, scene::Side::open};
  scene::Component c;
  c.extinction = depth;
  c.phase = scene::HenyeyGreensteinPhase{g};
  scene.medium.components = {c};
  scene.lights = {scene::DirectionalLight{{0, 0, 1}, glm::dvec3(1)}};
  scene.camera.projection = scene::Projection::orthographic;
  scene.camera.position = {0.5, 0.5, behind ? 4 : -3};
  scene.camera.look_at = {0.5, 0.5, 0.5};
  scene.camera.width = 0.9;
  scene.illumination_resolution = {0, 0, cells};
  return scene;
}

/// Prints the bias of the mean radiance, and error^2 x CPU-s of a pixel of one picture [1e-3 s].
void print_slab(const Scene& scene, double exact, int seeds, Backend& backend) {
  const std::clock_t begin = std::clock();
  const Replicates pictures = replicates(scene, seeds, backend);
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / seeds;
  std::vector<double> means;
  double mean = 0, spread = 0, square = 0;
  for (const Picture& picture : pictures) {
    means.push_back(0);
    const std::size_t pixels = picture.rgba.size() / 4;
    for (std::size_t p = 0; p < pixels; ++p) {
      const double error = grey(picture, p) / exact - 1;
      means.back() += error / static_cast<double>(pixels);
      square += error * error / static_cast<double>(pixels * pictures.size());
    }
  }
  const auto n = static_cast<double>(seeds);
  for (const double m : means) mean += m / n;
  for (const double m : means) spread += (m - mean) * (m - mean);
  std::printf(" %+.2f ± %.2f %% (%.3g) |", 100 * mean, 100 * std::sqrt(spread / (n * (n - 1))),
              1e3 * square * seconds);
  std::fflush(stdout);
}

/// Compares slabs with the adding-doubling method.
void print_slabs(const Options& options, Backend& backend) {
  std::printf("| optical depth, g |");
  for (const int bounces : options.bounces) std::printf(" %d bounces |", bounces);
  std::printf(" paths | exact [1/sr] |\n|---|");
  for (std::size_t i = 0; i < options.bounces.size(); ++i) std::printf("---|");
  std::printf("---|---|\n");
  for (const double depth : options.depths) {
    for (const double g : options.gs) {
      const test::SlabReference reference(depth, 1, test::henyey_greenstein_moments(g, 400), {},
                                          g > 0.9 ? 160 : 64);
      const double exact = options.behind ? reference.transmitted(-1) : reference.reflected(-1);
      std::printf("| %g, %g |", depth, g);
      Scene scene = slab(depth, g, options.grids.front(), options.behind);
      scene.camera.resolution = {options.width, options.width};
      scene.photons = options.photons;
      scene.samples = options.samples;
      for (const int bounces : options.bounces) {
        scene.bounces = bounces;
        print_slab(scene, exact, options.seeds, backend);
      }
      scene.integrator = scene::Integrator::path;
      scene.samples = options.path_samples;
      print_slab(scene, exact, options.seeds, backend);
      std::printf(" %.5g |\n", exact);
    }
  }
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Bias of the photons' pictures against the path tracer's, as a table in Markdown.",
               "tyndall-bias");
  auto* scenes = app.add_option("scenes", options.scenes, "scene files");
  auto* slabs =
      app.add_flag("--slabs", options.slabs, "Henyey-Greenstein slabs against a reference");
  scenes->excludes(slabs);
  app.add_flag("--behind", options.behind, "slabs seen from their dark side")->needs(slabs);
  app.add_option("--depths", options.depths, "optical depths of the slabs")
      ->delimiter(',')
      ->check(CLI::Range(0.01, 1000.0));
  app.add_option("--g", options.gs, "mean cosines of the slabs' phase functions")
      ->delimiter(',')
      ->check(CLI::Range(-0.98, 0.98));
  app.add_option("--grids", options.grids,
                 "cells along the longest edge, 0: the scene's own; the first counts for slabs")
      ->delimiter(',');
  app.add_option("--bounces", options.bounces, "camera bounces before the grid is read")
      ->delimiter(',');
  app.add_option("--seeds", options.seeds, "pictures of each kind")->check(CLI::Range(3, 1000));
  app.add_option("--width", options.width, "width of the pictures [pixel]")
      ->check(CLI::Range(4, 4096));
  app.add_option("--photons", options.photons, "photons per seed");
  app.add_option("--samples", options.samples,
                 "samples per pixel and seed of the photons' pictures");
  app.add_option("--path-samples", options.path_samples,
                 "samples per pixel and seed of the paths' pictures");
  CLI11_PARSE(app, argc, argv);
  if (options.scenes.empty() && !options.slabs)
    throw Error(ExitCode::usage, "expected scene files, or --slabs");

  const auto backend = make_cpu_backend();
  std::printf("%d seeds, %llu photons, %llu samples (%llu of paths), %d pixels wide.\n\n",
              options.seeds, static_cast<unsigned long long>(options.photons),
              static_cast<unsigned long long>(options.samples),
              static_cast<unsigned long long>(options.path_samples), options.width);
  if (options.slabs) {
    print_slabs(options, *backend);
    return 0;
  }
  std::printf(
      "| scene, grid, bounces | picture: RMS | cloud: RMS | lit: RMS | lit: mean | dark: RMS "
      "| dark: mean |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const std::string& file : options.scenes) {
    Scene scene = io::read_scene(file, {}).scene;
    scene.camera.resolution = {options.width, std::max(1, options.width * scene.camera.resolution[1]
                                                              / scene.camera.resolution[0])};
    scene.integrator = scene::Integrator::path;
    scene.samples = options.path_samples;
    const Replicates paths = replicates(scene, options.seeds, *backend);
    scene.integrator = scene::Integrator::photons;
    scene.samples = options.samples;
    scene.photons = options.photons;
    scene.seed += static_cast<std::uint64_t>(options.seeds);
    const std::array<int, 3> own = ResolvedScene(scene).illumination.cells;
    for (const int grid : options.grids) {
      scene.illumination_resolution = grid > 0 ? grid_of(scene, grid) : own;
      for (const int bounces : options.bounces) {
        scene.bounces = bounces;
        char name[200];
        std::snprintf(name, sizeof name, "%s, %s, %d", std::filesystem::path(file).stem().c_str(),
                      grid > 0 ? (std::to_string(grid) + "^3").c_str() : "its own", bounces);
        print_row(name, replicates(scene, options.seeds, *backend), paths);
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace tyndall::bench

int main(int argc, char** argv) {
  try {
    return tyndall::bench::run(argc, argv);
  } catch (const tyndall::Error& error) {
    std::fprintf(stderr, "tyndall-bias: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tyndall-bias: %s\n", error.what());
    return 1;
  }
}
