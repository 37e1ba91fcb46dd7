#include "render/bricks.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include "render/majorants.h"
#include "scene/values.h"
#include "tyndall/render/illumination_plan.h"

namespace tyndall {
namespace {

/// The non-empty bricks in the order of their places. The box is halved as long as a part of it is
/// non-empty, so the cost grows with the medium, not with the box.
std::vector<std::uint64_t> bricks_with_matter(const std::vector<Component<AnyField>>& components,
                                              const Box& box, const std::array<int, 3>& n,
                                              int threads, const Stop& stop) {
  const glm::ivec3 cells(n[0], n[1], n[2]),
      bricks = (cells + CellBricks::edge - 1) / CellBricks::edge;
  const glm::dvec3 extent = to_dvec3(box.extent), cell = extent / glm::dvec3(cells);
  const auto has_matter = [&](glm::ivec3 at, int edge) {  // in units of bricks
    // The cell of a position is rounded and may be a neighbour.
    const glm::dvec3 rounding = 1e-3 + 4e-7 * glm::dvec3(cells);
    const glm::dvec3 low = double{CellBricks::edge} * glm::dvec3(at) - rounding,
                     high = double{CellBricks::edge} * glm::dvec3(at + edge) + rounding;
    const glm::dvec3 first = glm::max(low * cell, 0.0), last = glm::min(high * cell, extent);
    const Region region{0.5 * (first + last), 0.5 * (last - first)};
    return std::any_of(components.begin(), components.end(), [&](const Component<AnyField>& c) {
      return c.extinction > 0
             && density_bounds(c.field, in_field_space(c.to_field, region, extent)).upper > 0;
    });
  };
  int edge = 1;
  while (edge < std::max({bricks.x, bricks.y, bricks.z})) edge *= 2;
  std::vector<glm::ivec3> found{glm::ivec3(0)};
  for (; !found.empty(); edge /= 2) {
    std::vector<char> is_kept(found.size());
    parallel_for(0, found.size(), 16, threads, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) {
        stop_if(stop);
        is_kept[i] = glm::all(glm::lessThan(found[i], bricks)) && has_matter(found[i], edge);
      }
    });
    std::vector<glm::ivec3> kept;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!is_kept[i]) continue;
      for (int part = 0; part < (edge > 1 ? 8 : 1); ++part)
        kept.push_back(found[i] + edge / 2 * glm::ivec3(part & 1, part >> 1 & 1, part >> 2));
    }
    found.swap(kept);
    if (edge == 1) break;
  }
  std::vector<std::uint64_t> places;
  places.reserve(found.size());
  for (const glm::ivec3& at : found) places.push_back(CellBricks::place_of(at.x, at.y, at.z));
  std::sort(places.begin(), places.end());
  return places;
}

glm::ivec3 at(std::uint64_t place) {
  return {CellBricks::coordinate(place, 0), CellBricks::coordinate(place, 1),
          CellBricks::coordinate(place, 2)};
}

/// Bricks and their bounding box.
struct Heap {
  std::vector<glm::ivec3> bricks;
  glm::ivec3 low{1 << 30}, high{0};

  void add(glm::ivec3 brick) {
    low = glm::min(low, brick);
    high = glm::max(high, brick + 1);
  }
  double surface(const glm::dvec3& size) const {
    const glm::dvec3 e = size * glm::dvec3(high - low);
    return e.x * e.y + e.y * e.z + e.z * e.x;
  }
};

/// Cuts a heap in two across the best axis. \return the surface saved
double cut(const Heap& heap, const glm::dvec3& size, Heap& first, Heap& second) {
  double best = heap.surface(size);
  const double whole = best;
  int best_axis = -1;
  std::size_t best_at = 0;
  const auto sorted = [&](int axis) {
    std::vector<glm::ivec3> bricks = heap.bricks;
    std::stable_sort(
        bricks.begin(), bricks.end(),
        [axis](const glm::ivec3& a, const glm::ivec3& b) { return a[axis] < b[axis]; });
    return bricks;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<glm::ivec3> bricks = sorted(axis);
    std::vector<double> after(bricks.size());
    Heap last, before;
    for (std::size_t i = bricks.size(); i-- > 1;) {
      last.add(bricks[i]);
      after[i] = last.surface(size);
    }
    for (std::size_t i = 1; i < bricks.size(); ++i) {
      before.add(bricks[i - 1]);
      if (bricks[i][axis] == bricks[i - 1][axis]) continue;
      const double surface = before.surface(size) + after[i];
      if (surface < best) best = surface, best_axis = axis, best_at = i;
    }
  }
  if (best_axis < 0) return 0;
  const std::vector<glm::ivec3> bricks = sorted(best_axis);
  first = second = Heap{};
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    Heap& heap_of = i < best_at ? first : second;
    heap_of.add(bricks[i]);
    heap_of.bricks.push_back(bricks[i]);
  }
  return whole - best;
}

}  // namespace

void store_bricks(const Box& box, std::array<int, 3>& n, int threads, const Stop& stop,
                  PreparedScene& out) {
  std::vector<std::uint64_t> places = bricks_with_matter(out.components, box, n, threads, stop);
  while (places.size() * CellBricks::cells > most_stored_cells) {
    for (int& cells : n) cells = (cells + 1) / 2;
    places = bricks_with_matter(out.components, box, n, threads, stop);
  }
  places.insert(places.begin(), CellBricks::none);
  std::size_t slots = 4;
  while (slots < 2 * places.size()) slots *= 2;
  out.brick_table.assign(slots, {CellBricks::none, 0});
  const std::size_t mask = slots - 1;
  for (std::size_t brick = 1; brick < places.size(); ++brick) {
    std::size_t slot = CellBricks::slot(places[brick]) & mask;
    while (out.brick_table[slot].place != CellBricks::none) slot = (slot + 1) & mask;
    out.brick_table[slot] = {places[brick], brick};
  }
  out.brick_places = std::move(places);
}

std::vector<Clump> find_clumps(const PreparedScene& scene, const Box& box,
                               const std::array<int, 3>& n) {
  constexpr std::size_t most = 16;
  constexpr double worth = 0.1;  // fraction of a box's surface that a cut has to save
  const glm::dvec3 extent = to_dvec3(box.extent), cell = extent / glm::dvec3(n[0], n[1], n[2]),
                   size = double{CellBricks::edge} * cell;
  std::vector<Heap> heaps(1);
  for (std::size_t brick = 1; brick < scene.brick_places.size(); ++brick) {
    heaps[0].bricks.push_back(at(scene.brick_places[brick]));
    heaps[0].add(heaps[0].bricks.back());
  }
  if (heaps[0].bricks.empty()) return {};
  struct Cut {
    double saved;
    Heap first, second;
  };
  const auto cut_of = [&](const Heap& heap) {
    Cut c{0, {}, {}};
    c.saved = cut(heap, size, c.first, c.second);
    if (c.saved < worth * heap.surface(size)) c.saved = 0;
    return c;
  };
  std::vector<Cut> cuts{cut_of(heaps[0])};
  while (heaps.size() < most) {
    const auto best = std::max_element(
        cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.saved < b.saved; });
    if (!(best->saved > 0)) break;
    const auto i = static_cast<std::size_t>(best - cuts.begin());
    Cut chosen = std::move(*best);
    heaps[i] = std::move(chosen.first);
    heaps.push_back(std::move(chosen.second));
    cuts[i] = cut_of(heaps[i]);
    cuts.push_back(cut_of(heaps.back()));
  }
  std::vector<Clump> clumps;
  for (const Heap& heap : heaps) {
    const glm::dvec3 low = glm::min(size * glm::dvec3(heap.low), extent),
                     high = glm::min(size * glm::dvec3(heap.high), extent);
    clumps.push_back({to_vec3f(low), to_vec3f(high - low)});
  }
  return clumps;
}

}  // namespace tyndall
