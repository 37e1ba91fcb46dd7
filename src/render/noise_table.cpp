#include "render/noise_table.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "render/noise_samples.h"
#include "scene/cube_root.h"

namespace tyndall {

std::vector<std::int8_t> tabulate(NoiseCloud& cloud, const Region& region, double points,
                                  int threads, const Stop& stop) {
  constexpr int block = 32, most = 1024;  // boxes along an axis
  const glm::dvec3 extent = 2.0 * region.half, far = glm::abs(region.center) + region.half;
  if (glm::any(glm::greaterThan(far, glm::dvec3(NoiseCloud::reach)))) return {};
  const double size = cube_root(extent.x * extent.y * extent.z / points);
  const auto boxes = [&](double length) {
    return static_cast<int>(std::clamp(std::ceil(length / size), 1.0, double{most}));
  };
  const int nx = boxes(extent.x), ny = boxes(extent.y), nz = boxes(extent.z);
  const glm::dvec3 step = extent / glm::dvec3(nx, ny, nz);

  NoiseTable table;
  table.nx = nx + 1, table.ny = ny + 1, table.nz = nz + 1;
  table.low = {static_cast<float>(region.center.x - region.half.x),
               static_cast<float>(region.center.y - region.half.y),
               static_cast<float>(region.center.z - region.half.z)};
  table.inverse_cell_size = {static_cast<float>(1 / step.x), static_cast<float>(1 / step.y),
                             static_cast<float>(1 / step.z)};
  const double unit = double{fractal_noise_bound(cloud.octaves, cloud.gain)} / 127;
  const glm::dvec3 low(table.low.x, table.low.y, table.low.z), edge = step + 0x1p-47 * far;

  std::vector<std::int8_t> values(table.size());
  double slack = 0;
  const auto fill = [&](int i0, int j0, int k0) {
    NoiseSamples samples(low + step * glm::dvec3(i0, j0, k0), step, block - 1);
    const double between = samples.add_octaves(cloud, edge);
    const double* sum = samples.sums().data();
    for (int k = k0; k < k0 + block; ++k) {
      for (int j = j0; j < j0 + block; ++j, sum += block) {
        if (k > nz || j > ny) continue;
        std::int8_t* row = &values[table.index(0, j, k)];
        for (int i = i0; i < std::min(i0 + block, nx + 1); ++i)
          row[i] = static_cast<std::int8_t>(std::lrint(sum[i - i0] / unit));
      }
    }
    if (i0 + j0 + k0 == 0) slack = between;
  };
  const Cells blocks{nx / block + 1, ny / block + 1, nz / block + 1};
  parallel_for(0, blocks.count(), 1, threads, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t b = begin; b < end; ++b) {
      stop_if(stop);
      const Cells::Place at = blocks.place(b);
      fill(block * at.i, block * at.j, block * at.k);
    }
  });

  // Half a unit for the rounding of values, the rest for the rounding of positions between them.
  const double rounding = 0.501 + std::max({nx, ny, nz}) / 1024.0;
  table.unit = static_cast<float>(unit);
  table.half = static_cast<float>(1.000001 * (slack + rounding * unit));
  if (table.half > 0.5f * fractal_noise_bound(cloud.octaves, cloud.gain)) return {};
  table.values = values.data();
  cloud.table = table;
  return values;
}

}  // namespace tyndall
