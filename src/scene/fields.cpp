#include "scene/fields.h"

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "scene/checker.h"
#include "tyndall/render/volume.h"

namespace tyndall::scene {
namespace {

void order_of_corners(Checker& check, const std::string& path, const Cuboid& s) {
  if (!check.is_good(path + ".min") || !check.is_good(path + ".max")) return;
  for (int a = 0; a < 3; ++a) {
    if (s.max[a] <= s.min[a]) {
      check.error(path + ".max", fmt::format("expected max above min, got {} from {} to {}",
                                             axis_names[a], s.min[a], s.max[a]));
    }
  }
}

template <class Body>
void body(Checker& check, const std::string& path, const Body& shape) {
  std::visit(
      [&](const auto& s) {
        check.ranges(path, s);
        if constexpr (std::is_same_v<std::decay_t<decltype(s)>, Cuboid>)
          order_of_corners(check, path, s);
      },
      shape);
}

void noise(Checker& check, const std::string& path, const NoiseCloud& cloud) {
  check.ranges(path, cloud);
  body(check, path + ".body", cloud.body);
}

void remap(Checker& check, const std::string& path, const Remap& r) {
  check.ranges(path, r);
  if (check.is_good(path + ".clamp") && r.low > r.high)
    check.error(path + ".clamp", fmt::format("expected low, high, got {} above {}", r.low, r.high));
}

void dense_grid(Checker& check, const std::string& path, const DenseGrid& grid) {
  check.ranges(path, grid);
  remap(check, path + ".remap", grid.remap);
  if (!check.is_good(path + ".size")) return;
  if (const std::string problem = grid_problem(grid); !problem.empty())
    check.error(path + ".values", problem);
}

void sparse_grid(Checker& check, const std::string& path, const Component& c, const Field& of) {
  const auto& grid = std::get<SparseGrid>(of);
  remap(check, path + ".remap", grid.remap);
  if (!grid.volume) return check.error(path, "no volume");
  const Volume& volume = *grid.volume;
  if (volume.is_color()) {
    const auto* color = std::get_if<ColorEmission>(&c.emission);
    if (color && &color->field == &of) return;
    return check.error(path, "a grid of colours is neither a density nor a temperature");
  }
  if (volume.active_voxels() == 0 || &of != &c.field) return;
  const ActiveBounds box = active_box(volume, c.transform * fitted(grid) * volume.to_world());
  for (int a = 0; a < 3; ++a) {
    if (box.high[a] > check.scene.medium.box_min[a] && box.low[a] < check.scene.medium.box_max[a])
      continue;
    return check.warning(
        path, fmt::format("outside of medium.box: its voxels are in [{:.6g}, {:.6g}, {:.6g}] "
                          "to [{:.6g}, {:.6g}, {:.6g}]; move it, or the box",
                          box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z));
  }
  const double slack = 1e-6 * glm::length(box.high - box.low);
  for (int a = 0; grid.fit_box && a < 3; ++a) {
    if (box.high[a] <= check.scene.medium.box_max[a] + slack
        && box.low[a] >= check.scene.medium.box_min[a] - slack)
      continue;
    return check.warning(
        path,
        "fitted as another frame is, it reaches beyond medium.box, which cuts it: leave "
        "the box out, make it larger, or scale by the component's transform");
  }
}

}  // namespace

void check_field(Checker& check, const std::string& path, const Component& c, const Field& of) {
  std::visit(Overloaded{[&](const Solid& solid) { body(check, path, solid.body); },
                        [&](const NoiseCloud& cloud) { noise(check, path, cloud); },
                        [&](const DenseGrid& grid) { dense_grid(check, path, grid); },
                        [&](const SparseGrid&) { sparse_grid(check, path, c, of); }},
             of);
}

std::string grid_problem(const DenseGrid& grid) {
  std::uint64_t voxels = 1;
  for (const int n : grid.size) voxels *= static_cast<std::uint64_t>(std::max(n, 0));
  if (grid.values.size() != voxels) {
    return fmt::format("expected {} x {} x {} = {} values, got {}", grid.size[0], grid.size[1],
                       grid.size[2], voxels, grid.values.size());
  }
  const auto bad = [](float v) { return !limits::density.contains(v); };
  const auto first = std::find_if(grid.values.begin(), grid.values.end(), bad);
  if (first == grid.values.end()) return {};
  return fmt::format(
      "expected densities in [0, 1e12], got {} others of {}, the first {} at index {}",
      std::count_if(first, grid.values.end(), bad), voxels, *first, first - grid.values.begin());
}

}  // namespace tyndall::scene
