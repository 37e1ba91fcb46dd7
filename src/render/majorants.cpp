#include "render/majorants.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "render/noise_table.h"
#include "scene/cube_root.h"
#include "scene/values.h"
#include "tyndall/render/bounds.h"

namespace tyndall {
namespace {

float round_up(double x) {
  const float f = static_cast<float>(x * (1 + 4e-7));
  return f < x ? std::nextafter(f, largest_float) : f;
}
float round_down(double x) {
  const float f = static_cast<float>(x * (1 - 4e-7));
  return f > x ? std::nextafter(f, 0.0f) : f;
}

/// Builds the bounds at one resolution.
MajorantTables build(const std::vector<Component<AnyField>>& components, const Box& box,
                     glm::ivec3 resolution, int threads,
                     const std::function<void(double)>& progress, const Stop& stop) {
  MajorantTables t;
  t.nx = resolution.x, t.ny = resolution.y, t.nz = resolution.z;
  const std::size_t cells = t.count(), count = components.size();
  t.total.assign(cells, 0.0f);
  t.upper.assign(cells * count, 0.0f);
  t.lower.assign(cells * count, 0.0f);
  const glm::dvec3 extent = to_dvec3(box.extent);
  const glm::dvec3 size = extent / glm::dvec3(resolution);
  const auto bound = [&](std::size_t cell) {
    const Region region{(glm::dvec3(to_ivec3(t.place(cell))) + 0.5) * size, 0.5 * size};
    for (std::size_t c = 0; c < count; ++c) {
      const Bounds density = density_bounds(components[c].field,
                                            in_field_space(components[c].to_field, region, extent));
      const double extinction = components[c].extinction;
      t.upper[c * cells + cell] = round_up(extinction * density.upper);
      t.lower[c * cells + cell] = round_down(extinction * density.lower);
      t.total[cell] += t.upper[c * cells + cell];
    }
  };
  const std::size_t slab = std::max<std::size_t>(t.index(0, 0, 1), 256);
  for (std::size_t begin = 0; begin < cells; begin += slab) {
    if (progress) progress(static_cast<double>(begin) / static_cast<double>(cells));
    parallel_for(begin, std::min(begin + slab, cells), 8, threads,
                 [&](std::uint64_t first, std::uint64_t last) {
                   for (std::uint64_t cell = first; cell < last; ++cell) {
                     stop_if(stop);
                     bound(cell);
                   }
                 });
  }
  t.whole_total.assign(1, 0.0f);
  for (std::size_t c = 0; c < count; ++c) {
    const auto row = [&](std::vector<float>& v) {
      return v.begin() + static_cast<std::ptrdiff_t>(c * cells);
    };
    const auto width = static_cast<std::ptrdiff_t>(cells);
    t.whole_upper.push_back(*std::max_element(row(t.upper), row(t.upper) + width));
    t.whole_lower.push_back(*std::min_element(row(t.lower), row(t.lower) + width));
    t.whole_total[0] += t.whole_upper[c];
  }
  return t;
}

// ---- Number of super-voxels: docs/resolution.md

/// Measured costs of a tentative collision and of a look-up, in steps across a super-voxel.
constexpr double collision_cost = 2, lookup_cost = 3;

/// Limits of the chosen resolution, along each axis.
constexpr int fewest = 4, most = 64;

/// A resolution with cubical super-voxels, `scale` times as fine as 32^3 along each axis.
glm::ivec3 cubical(glm::dvec3 extent, double scale) {
  const double edge = cube_root(extent.x * extent.y * extent.z) / (32 * scale);
  return glm::clamp(glm::ivec3(glm::round(extent / edge)), fewest, most);
}

/// \return the factor by which the optimal grid is finer than `probe`.
double best_refinement(const MajorantTables& probe, glm::dvec3 extent) {
  const std::size_t cells = probe.total.size();
  std::vector<float> lower(cells, 0.0f);
  for (std::size_t at = 0; at < probe.lower.size(); ++at) lower[at % cells] += probe.lower[at];
  // Merge 2^3 super-voxels into one.
  const Cells coarse{(probe.nx + 1) / 2, (probe.ny + 1) / 2, (probe.nz + 1) / 2};
  const auto parent = [&](std::size_t cell) {
    const Cells::Place at = probe.place(cell);
    return coarse.index(at.i / 2, at.j / 2, at.k / 2);
  };
  std::vector<float> coarse_total(coarse.count(), 0.0f),
      coarse_lower(coarse.count(), largest_float);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    float &high = coarse_total[parent(cell)], &low = coarse_lower[parent(cell)];
    high = std::max(high, probe.total[cell]);
    low = std::min(low, lower[cell]);
  }
  // The cost saved per unit of length by halving the edges, in uniform light.
  double saved = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const double collisions = double{coarse_total[parent(cell)]} - double{probe.total[cell]};
    const double certain = double{lower[cell]} - double{coarse_lower[parent(cell)]};
    saved += collision_cost * collisions + lookup_cost * (collisions + certain);
  }
  saved /= static_cast<double>(cells);
  // The number of steps per unit of length, averaged over directions.
  const double crossings = 0.5 * (probe.nx / extent.x + probe.ny / extent.y + probe.nz / extent.z);
  return std::sqrt(saved / crossings);
}

}  // namespace

Region in_field_space(const Affine& to_field, const Region& region, glm::dvec3 extent) {
  const double ulp = std::ldexp(1.0, -23);
  const glm::dvec3 half = region.half + 4.0 * ulp * extent;
  const Vec3f rows[3] = {to_field.row_x, to_field.row_y, to_field.row_z};
  const glm::dvec3 offset = to_dvec3(to_field.offset);
  Region out;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row = to_dvec3(rows[i]), size = glm::abs(row);
    out.center[i] = glm::dot(row, region.center) + offset[i];
    const bool moves = size != glm::dvec3(i == 0, i == 1, i == 2) || offset[i] != 0.0;
    const double rounding =
        moves ? 4.0 * ulp * (glm::dot(size, extent) + std::abs(offset[i])) : 0.0;
    out.half[i] = glm::dot(size, half) + rounding;
  }
  return out;
}

CellRange filled_cells(const Cells& cells, const float* majorants) {
  CellRange range{{cells.nx, cells.ny, cells.nz}, glm::ivec3(0)};
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    if (majorants[cell] == 0.0f) continue;
    const glm::ivec3 at = to_ivec3(cells.place(cell));
    range = {glm::min(range.begin, at), glm::max(range.end, at + 1)};
  }
  return range;
}

Region matter_region(const MajorantTables& t, std::size_t c, glm::dvec3 extent) {
  const auto [begin, end] = filled_cells(t, &t.upper[c * t.count()]);
  const glm::dvec3 size = extent / glm::dvec3(t.nx, t.ny, t.nz);
  return {0.5 * size * glm::dvec3(begin + end), 0.5 * size * glm::dvec3(end - begin)};
}

MajorantTables build_majorants(const std::vector<Component<AnyField>>& components, const Box& box,
                               std::array<int, 3> resolution, int threads,
                               const std::function<void(double)>& progress, const Stop& stop) {
  const glm::ivec3 wanted(resolution[0], resolution[1], resolution[2]);
  const auto given = glm::greaterThan(wanted, glm::ivec3(0));
  if (glm::all(given)) return build(components, box, wanted, threads, progress, stop);
  const glm::dvec3 extent = to_dvec3(box.extent);
  const glm::ivec3 first = cubical(extent, 1);
  const auto half_done = [&](double share) {
    if (progress) progress(0.5 * share);
  };
  MajorantTables probe = build(components, box, first, threads, half_done, stop);
  const glm::ivec3 chosen =
      glm::mix(cubical(extent, best_refinement(probe, extent)), wanted, given);
  if (chosen == first) return probe;
  return build(
      components, box, chosen, threads,
      [&](double share) {
        if (progress) progress(0.5 + 0.5 * share);
      },
      stop);
}

std::vector<std::vector<std::int8_t>> tabulate_noise(std::vector<Component<AnyField>>& components,
                                                     const Box& box, const MajorantTables& bounds,
                                                     double points, int threads, const Stop& stop) {
  const glm::dvec3 extent = to_dvec3(box.extent);
  std::vector<std::vector<std::int8_t>> tables;
  for (std::size_t c = 0; c < components.size(); ++c) {
    AnyField& field = components[c].field;
    if (field.kind != AnyField::Kind::noise_cloud) continue;
    const Region matter = matter_region(bounds, c, extent);
    if (!(matter.half.x > 0)) continue;
    tables.push_back(tabulate(field.noise_cloud,
                              in_field_space(components[c].to_field, matter, extent), points,
                              threads, stop));
  }
  return tables;
}

std::vector<std::vector<std::uint8_t>> tabulate_bounds(std::vector<Component<AnyField>>& components,
                                                       int threads, const Stop& stop) {
  constexpr double most_bricks = 1 << 19;  // 1 MB: about the size of a core's second-level cache
  constexpr double finest = 1;             // voxels per edge
  std::vector<std::vector<std::uint8_t>> tables;
  for (Component<AnyField>& component : components) {
    if (component.field.kind != AnyField::Kind::sparse_grid) continue;
    SparseGrid& grid = component.field.sparse_grid;
    const double densest = density_bounds(grid, {glm::dvec3(0.0), glm::dvec3(1e30)}).upper;
    if (!(densest > 0)) continue;
    const glm::dvec3 extent(grid.extent[0] + 2, grid.extent[1] + 2, grid.extent[2] + 2);
    const double edge = std::max(finest, cube_root(extent.x * extent.y * extent.z / most_bricks));
    const glm::ivec3 n = glm::max(glm::ivec3(glm::ceil(extent / edge)), 1);
    BoundTable table;
    table.low = {-1, -1, -1};
    const auto inverse = static_cast<float>(1 / edge);
    table.inverse_brick_size = {inverse, inverse, inverse};
    table.nx = n.x, table.ny = n.y, table.nz = n.z;
    table.unit = round_up(densest / 255);
    std::vector<std::uint8_t> codes(table.size());
    // The brick of a position is rounded and may be a neighbour.
    const double half = 0.5 * edge * (1 + 1e-3) + 4e-7 * std::max({extent.x, extent.y, extent.z});
    parallel_for(0, codes.size() / 2, 256, threads, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t brick = begin; brick < end; ++brick) {
        stop_if(stop);
        const glm::dvec3 place(to_ivec3(table.place(brick)));
        const Bounds density = density_bounds(grid, {edge * (place + 0.5) - 1.0, glm::dvec3(half)});
        const auto code = [&](double x) { return std::clamp(x / double{table.unit}, 0.0, 255.0); };
        codes[2 * brick] = static_cast<std::uint8_t>(std::floor(code(density.lower) * (1 - 1e-6)));
        codes[2 * brick + 1] =
            static_cast<std::uint8_t>(std::ceil(std::min(code(density.upper) * (1 + 1e-6), 255.0)));
      }
    });
    tables.push_back(std::move(codes));
    table.codes = tables.back().data();
    grid.bounds = table;
  }
  return tables;
}

}  // namespace tyndall
