#include "tyndall/render/bake.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "render/read_out.h"
#include "scene/values.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/transport/illumination.h"

namespace tyndall {
namespace {

/// Luminance of N of order 0, summed over the groups, for one replicate or for the sum of all.
double luminance_of(const std::int64_t* words, const IlluminationCells& cells) {
  double sum = 0;
  for (int group = 0; group < cells.groups; ++group) {
    const std::int64_t* rgb = words + group * cells.group_moments();
    const int g = cells.channels == 1 ? 0 : 1, b = 2 * g;
    sum += luminance(rgb[0], rgb[g], rgb[b]);
  }
  return sum;
}

/// Averages over the neighbours of each cell as gathering does, which interpolates numerator and
/// denominator separately: averaged over a cell, each neighbour along an axis has weight 1/8.
/// A single cell at the rim of the medium has too few samples of both.
template <class T>
std::vector<T> smoothed(const IlluminationCells& cells, std::vector<T> values) {
  const std::array<int, 3> size{cells.nx, cells.ny, cells.nz};
  const bool periodic[] = {cells.box.periodic_x, cells.box.periodic_y, cells.box.periodic_z};
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(size[axis]);
    std::vector<T> line(n);
    for (std::size_t first = 0; first < values.size(); ++first) {
      if (first / stride % n != 0) continue;
      for (std::size_t i = 0; i < n; ++i) line[i] = values[first + i * stride];
      for (std::size_t i = 0; i < n; ++i) {
        T& value = values[first + i * stride];
        value = 0.75f * line[i];
        if (i > 0 || periodic[axis]) value = value + 0.125f * line[i > 0 ? i - 1 : n - 1];
        if (i + 1 < n || periodic[axis]) value = value + 0.125f * line[i + 1 < n ? i + 1 : 0];
      }
    }
    stride *= n;
  }
  return values;
}

std::vector<float> relative_error(const Partial& part, const IlluminationCells& cells,
                                  const std::vector<char>& known) {
  std::vector<double> sum(cells.count()), squares(cells.count());
  double n = 0;
  for (const Replicate& r : part.replicates) {
    if (r.photons.empty() || r.light.empty()) continue;
    std::vector<double> light(cells.count());
    for (std::size_t cell = 0; cell < cells.count(); ++cell)
      light[cell] = luminance_of(&r.light[cell * static_cast<std::size_t>(cells.moments())], cells)
                    / static_cast<double>(r.photons.count());
    light = smoothed(cells, std::move(light));
    for (std::size_t cell = 0; cell < cells.count(); ++cell)
      sum[cell] += light[cell], squares[cell] += light[cell] * light[cell];
    ++n;
  }
  if (n < 2) return {};
  std::vector<float> errors(cells.count());
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    if (!known[cell]) continue;
    const double mean = sum[cell] / n,
                 variance = std::max(squares[cell] / n - mean * mean, 0.0) / (n - 1);
    errors[cell] = mean > 0 ? static_cast<float>(std::min(std::sqrt(variance) / mean, 1e6)) : 1e6f;
  }
  return errors;
}

/// Sets each unknown cell to the mean of its known neighbours.
void spread(std::vector<Vec3f>& values, std::vector<char> known, const std::array<int, 3>& size,
            int layers) {
  const auto [nx, ny, nz] = size;
  for (; layers > 0; --layers) {
    std::vector<char> next = known;
    std::size_t cell = 0;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i, ++cell) {
          if (known[cell]) continue;
          Vec3f sum{0, 0, 0};
          int count = 0;
          for (int z = std::max(k - 1, 0); z <= std::min(k + 1, nz - 1); ++z)
            for (int y = std::max(j - 1, 0); y <= std::min(j + 1, ny - 1); ++y)
              for (int x = std::max(i - 1, 0); x <= std::min(i + 1, nx - 1); ++x) {
                const std::size_t at = Cells{nx, ny, nz}.index(x, y, z);
                if (!known[at]) continue;
                sum = sum + values[at];
                ++count;
              }
          if (count == 0) continue;
          values[cell] = (1.0f / static_cast<float>(count)) * sum;
          next[cell] = 1;
        }
    known.swap(next);
  }
}

/// The mean albedo of each cell: the components' albedos, weighted by their extinctions at points
/// of the cell. \param[out] known whether one of the points lies in the medium
std::vector<Vec3f> mean_albedo(const PreparedScene& scene, std::vector<char>& known) {
  constexpr int points = 3;  // along each axis
  const IlluminationCells& cells = scene.cells;
  std::vector<Vec3f> albedo(cells.count(), Vec3f{0, 0, 0});
  const auto rows = static_cast<std::uint64_t>(cells.ny) * static_cast<std::uint64_t>(cells.nz);
  parallel_for(0, rows, 4, 0, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t row = begin; row < end; ++row) {
      for (int i = 0; i < cells.nx; ++i) {
        const auto j = static_cast<int>(row % static_cast<std::uint64_t>(cells.ny)),
                   k = static_cast<int>(row / static_cast<std::uint64_t>(cells.ny));
        const std::size_t cell = cells.index(i, j, k);
        Extinction sum;
        for (int n = 0; n < points * points * points; ++n) {
          const auto at = [&](int index, int step, float size) {
            return (static_cast<float>(index) + (static_cast<float>(step) + 0.5f) / points) * size;
          };
          const Vec3f p{at(i, n % points, scene.cell_size.x),
                        at(j, n / points % points, scene.cell_size.y),
                        at(k, n / (points * points), scene.cell_size.z)};
          const Extinction here = extinction_at(scene, p);
          sum.all += here.all;
          sum.scattering = sum.scattering + here.scattering;
        }
        known[cell] = sum.all > 0;
        albedo[cell] = sum.albedo();
      }
    }
  });
  return albedo;
}

template <class Light>
const char* kind_of(const Light&) {
  using namespace scene;
  if constexpr (std::is_same_v<Light, PointLight>) return "point";
  if constexpr (std::is_same_v<Light, DirectionalLight>) return "directional";
  if constexpr (std::is_same_v<Light, EnvironmentLight>) return "environment";
  if constexpr (std::is_same_v<Light, SpotLight>) return "spot";
  if constexpr (std::is_same_v<Light, RectangleLight>) return "rectangle";
  if constexpr (std::is_same_v<Light, SphereLight>) return "sphere";
}

}  // namespace

float in_scattered(float mean, Vec3f slope, Vec3f w, float g) {
  const float steepness = length(slope);
  if (!(mean > 0.0f) || !(steepness > 0.0f)) return std::max(mean, 0.0f);
  // Light is at most as parallel as a beam; only rounding exceeds that.
  const float m = std::abs(g) * std::min(steepness / (3.0f * mean), 1.0f);
  const float cosine = (g < 0.0f ? -1.0f : 1.0f) * dot(w, slope) / steepness;
  const float narrow = 1.0f - m;
  const float spread = narrow * narrow + 2.0f * m * std::max(1.0f - cosine, 0.0f);
  return mean * (1.0f - m * m) / (spread * std::sqrt(spread));
}

Extinction extinction_at(const PreparedScene& scene, Vec3f p) {
  Extinction sum;
  for (const Component<AnyField>& c : scene.components) {
    const float sigma_t = c.sigma_t(p);
    sum.all += sigma_t;
    sum.scattering = sum.scattering + sigma_t * c.albedo;
    if (c.emission) sum.emission = sum.emission + sigma_t * c.emitted(p);
  }
  return sum;
}

ResolvedScene scene_to_bake(const ResolvedScene& resolved, bool with_directions, bool per_light,
                            bool multiple_only) {
  Scene scene = resolved;
  scene.integrator = scene::Integrator::photons;
  scene.single_scattering =
      multiple_only ? scene::SingleScattering::apart : scene::SingleScattering::grid;
  scene.illumination_order = with_directions ? 1 : 0;
  scene.illumination_resolution =
      dense_illumination_resolution(scene, resolved.densities);  // of the whole box
  scene.detectors = {};
  scene.samples = most_replicates;  // the error is their spread
  scene.camera.resolution = {1, 1};
  scene.camera.crop = {0, 0, 0, 0};
  std::set<std::string> groups;  // named by the scene
  for (const scene::Light& any : scene.lights)
    std::visit([&](const auto& light) { groups.insert(light.group); }, any);
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    std::visit(
        [&](auto& light) {
          if (!per_light) return light.group.clear();
          if (!light.group.empty()) return;
          light.group = fmt::format("{}_{}", kind_of(light), i);
          if (groups.contains(light.group)) {
            throw Error(ExitCode::scene_invalid,
                        fmt::format("lights[{}]: without a group it would be baked as \"{}\", "
                                    "which is another light's group: name it otherwise",
                                    i, light.group));
          }
        },
        scene.lights[i]);
  return ResolvedScene(std::move(scene));
}

BakedLight bake(Renderer& renderer, const Scene& whole) {
  const Partial& part = renderer.part();
  const PreparedScene& scene = renderer.scene();
  const IlluminationCells& cells = scene.cells;
  const auto moments = static_cast<std::size_t>(cells.moments());

  std::vector<std::int64_t> sums(part.frame.light_words);
  std::uint64_t photons = 0;
  for (const Replicate& r : part.replicates) {
    if (r.light.empty()) continue;
    add_words(sums.data(), r.light.data(), sums.size());
    photons += r.photons.count();
  }
  std::vector<float> numerator;
  read_out_light(sums, scene.shot_power / static_cast<double>(photons), numerator);
  const std::vector<float> denominator =
      smoothed(cells, read_out_matter(scene, part.measured[measurement::scattering].words));

  BakedLight out;
  out.size = {cells.nx, cells.ny, cells.nz};
  out.low = whole.medium.box_min;
  out.high = whole.medium.box_max;
  out.is_multiple_only = scene.is_apart;
  std::vector<char> known(cells.count());
  for (std::size_t cell = 0; cell < cells.count(); ++cell) known[cell] = denominator[cell] > 0;
  out.relative_error = relative_error(part, cells, known);

  std::vector<char> has_matter(cells.count());
  out.albedo = mean_albedo(scene, has_matter);
  spread(out.albedo, has_matter, out.size, 2);

  for (int g = 0; g < cells.groups; ++g) {
    BakedGroup group;
    if (!scene.groups.empty()) group.name = scene.groups[static_cast<std::size_t>(g)];
    // N of harmonic `index`, divided by D, times `scale`.
    const auto moment = [&](int index, float scale) {
      std::vector<Vec3f> values(cells.count(), Vec3f{0, 0, 0});
      for (std::size_t cell = 0; cell < cells.count(); ++cell) {
        const float* n = &numerator[cell * moments
                                    + static_cast<std::size_t>(g * cells.group_moments()
                                                               + index * cells.channels)];
        values[cell] = cells.channels == 1 ? Vec3f{n[0], n[0], n[0]} : Vec3f{n[0], n[1], n[2]};
      }
      values = smoothed(cells, std::move(values));
      for (std::size_t cell = 0; cell < cells.count(); ++cell)
        values[cell] = (known[cell] ? scale / denominator[cell] : 0.0f) * values[cell];
      spread(values, known, out.size, 1);
      return values;
    };
    const float y00 = harmonic(0, {0, 0, 1}), y1 = harmonic(2, {0, 0, 1});
    group.fluence = moment(0, 1.0f / y00);
    if (cells.order > 0) {
      constexpr int harmonic_of_axis[3] = {3, 1, 2};
      for (std::size_t axis = 0; axis < 3; ++axis)
        group.slope[axis] = moment(harmonic_of_axis[axis], y1);
    }
    out.groups.push_back(std::move(group));
  }
  return out;
}

}  // namespace tyndall
