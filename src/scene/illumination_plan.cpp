#include "tyndall/render/illumination_plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>

#include "scene/checker.h"
#include "scene/cube_root.h"
#include "scene/prepare_phase.h"
#include "tyndall/render/volume.h"
#include "tyndall/transport/illumination.h"

namespace tyndall {
namespace scene {
namespace {

/// Whether neither medium nor light varies along an axis, so that cells may have any width.
bool is_constant(const Scene& scene, int axis) {
  const Medium& m = scene.medium;
  const auto spans = [&](const Component& c) {
    const auto* solid = std::get_if<Solid>(&c.field);
    if (!solid) return false;
    if (std::holds_alternative<Everywhere>(solid->body)) return true;
    const auto* body = std::get_if<Cuboid>(&solid->body);
    return body && c.transform == glm::dmat4(1.0) && body->min[axis] <= m.box_min[axis]
           && body->max[axis] >= m.box_max[axis];
  };
  const auto is_uniform = [&](const Component& c) {
    return spans(c) && std::holds_alternative<NoEmission>(c.emission);
  };
  const auto is_far = [](const Light& light) {
    return std::holds_alternative<DirectionalLight>(light)
           || std::holds_alternative<EnvironmentLight>(light);
  };
  return m.sides[static_cast<std::size_t>(axis)] == Side::periodic
         && std::all_of(m.components.begin(), m.components.end(), is_uniform)
         && std::all_of(scene.lights.begin(), scene.lights.end(), is_far);
}

/// \return the width of the cells [length] along the axes that vary; the largest counts.
double cell_width(const Scene& scene, const IlluminationPlan& plan) {
  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  double width = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (!is_constant(scene, axis))
      width = std::max(width, extent[axis] / plan.cells[static_cast<std::size_t>(axis)]);
  return width;
}

double mean_cosine(const Phase& phase) {
  std::vector<std::vector<PhaseKnot>> tables;
  return double{prepare_phase(phase, highest_order, 1, tables).moment(1)};
}

/// \return the least relative excess brightness of a thick slab under a sun at the zenith.
/// \param width of cells [transport mean free path]
double expected_error(double width, int bounces) {
  // Measured, in percent: tyndall-bias --slabs --depths 25,50,100,112,200 --g 0 --bounces 0,1,2,3
  constexpr std::array widths{0.0, 0.39, 0.78, 1.56, 1.75, 3.12};
  constexpr double errors[4][widths.size()] = {{0, 0.6, 2.1, 6.2, 7.3, 13.8},
                                               {0, 0.0, 0.5, 2.2, 2.7, 6.9},
                                               {0, 0.0, 0.0, 0.6, 0.8, 3.6},
                                               {0, 0.0, 0.0, 0.0, 0.1, 2.0}};
  const double* const row = errors[std::clamp(bounces, 0, 3)];
  std::size_t i = 1;
  while (i + 1 < widths.size() && width > widths[i]) ++i;
  const double t = (width - widths[i - 1]) / (widths[i] - widths[i - 1]);
  return 0.01 * std::lerp(row[i - 1], row[i], t);
}

/// \return whether `field` has one density and sharp edges.
bool is_solid(const Field& field) {
  const auto* grid = std::get_if<SparseGrid>(&field);
  return std::holds_alternative<Solid>(field)
         || (grid && grid->volume && grid->volume->is_level_set());
}

/// \return the relative excess brightness near the edge of a solid that is lit on its other side.
/// The grid is constant in the outer half of a cell, where the light decreases towards the edge.
/// Fitted to the differences between slabs of optical depth 100 seen from behind, with cells 0.78
/// to 1.56 mean free paths wide and 2 to 10 bounces (docs/light.md); what all of them have in
/// common, 2
/// +- 0.7 %, is left out. \param width of cells [transport mean free path]
double dark_side_error(double width, int bounces) { return 0.067 * width * width / (bounces + 1); }

}  // namespace

void check_cells(Checker& check, const ResolvedScene& resolved) {
  if (check.scene.integrator == Integrator::path) return;
  const double width = cell_width(check.scene, resolved.illumination);
  const int bounces = resolved.bounces;
  for (std::size_t i = 0; i < check.scene.medium.components.size(); ++i) {
    const Component& c = check.scene.medium.components[i];
    if (!(largest(c.albedo) > 0)) continue;
    const double paths = width * c.extinction * resolved.densities[i].typical;
    const double transport_paths = paths * (1 - mean_cosine(c.phase));
    const double error = expected_error(transport_paths, bounces);
    const double dark_error = is_solid(c.field) ? dark_side_error(transport_paths, bounces) : 0;
    if (std::max(error, dark_error) < 0.03) continue;
    check.warning(
        "photons.illumination.resolution",
        fmt::format(
            "cells are {:.3g} mean free paths of medium.components[{}] wide: with {} "
            "bounces its bright sides are expected to be {:.2g} % too bright{}; "
            "raise it, or gather.bounces",
            paths, i, bounces, 100 * error,
            dark_error > error ? fmt::format(", its dark sides {:.2g} %", 100 * dark_error) : ""));
    return;
  }
}

}  // namespace scene

using namespace scene;

int needed_illumination_order(const Scene& scene) {
  int order = 0;
  for (const scene::Component& c : scene.medium.components) {
    if (largest(c.albedo) == 0) continue;
    const auto* hg = std::get_if<HenyeyGreensteinPhase>(&c.phase);
    if (hg && hg->g != 0) order = std::max(order, 1);
    if (!hg && !std::holds_alternative<IsotropicPhase>(c.phase)) order = 2;
  }
  return order;
}

std::array<int, 3> dense_illumination_resolution(const Scene& scene,
                                                 const std::vector<Densities>& densities) {
  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  double longest = 0;
  int varying = 0;  // number of axes
  for (int axis = 0; axis < 3; ++axis) {
    if (is_constant(scene, axis)) continue;
    longest = std::max(longest, extent[axis]);
    ++varying;
  }
  double densest = 0;  // of a single component: overlaps of the densest parts are small
  for (std::size_t i = 0; i < densities.size(); ++i) {
    const scene::Component& c = scene.medium.components[i];
    if (largest(c.albedo) > 0) densest = std::max(densest, c.extinction * densities[i].largest);
  }
  const double width = varying == 1 ? cells_in_free_paths_of_slabs : cells_in_free_paths,
               most = varying == 1 ? 1024 : 128,
               along = std::clamp(std::ceil(longest * densest / width), 64.0, most);
  std::array<int, 3> cells = scene.illumination_resolution;
  for (int axis = 0; axis < 3; ++axis) {
    int& n = cells[static_cast<std::size_t>(axis)];
    if (n > 0) continue;
    n = is_constant(scene, axis)
            ? 1
            : static_cast<int>(std::max(1.0, std::ceil(along * extent[axis] / longest)));
  }
  return cells;
}

IlluminationPlan plan_illumination(const Scene& scene, const std::vector<Densities>& densities) {
  IlluminationPlan plan;
  plan.cells = dense_illumination_resolution(scene, densities);
  plan.stored = 1;
  for (const int n : plan.cells) plan.stored *= static_cast<std::uint64_t>(std::max(n, 0));
  const auto is_given = [](int n) { return n > 0; };
  const std::array<int, 3>& given = scene.illumination_resolution;
  if (std::any_of(given.begin(), given.end(), is_given)) return plan;

  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  double thickest = 0, filled = 0, widest = 0;
  for (std::size_t i = 0; i < densities.size(); ++i) {
    const scene::Component& c = scene.medium.components[i];
    if (largest(c.albedo) > 0) thickest = std::max(thickest, c.extinction * densities[i].typical);
    filled += densities[i].filled;
  }
  for (int axis = 0; axis < 3; ++axis)
    if (!is_constant(scene, axis))
      widest = std::max(widest, extent[axis] / plan.cells[static_cast<std::size_t>(axis)]);
  const double box = extent.x * extent.y * extent.z;
  if (!(thickest > 0) || !(filled > 0) || !(8 * filled < box)) return plan;
  const double finest = cube_root(filled) / 128, coarsest = 2 * finest;
  const double wanted = std::max(cells_in_free_paths / thickest, finest),
               width = std::min(wanted, coarsest);
  const bool is_coarse = 2 * wanted < widest, is_lost = 64 * filled < box && 2 * width < widest;
  if (!is_coarse && !is_lost) return plan;

  // Bricks at the rim of the medium are partly empty. Single precision resolves no more cells.
  constexpr double most_cells = 1 << 20, rim = 8;
  for (int axis = 0; axis < 3; ++axis)
    plan.cells[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::clamp(std::ceil(extent[axis] / width), 1.0, most_cells));
  plan.is_sparse = true;
  plan.stored = static_cast<std::uint64_t>(
      std::min(rim * filled / (width * width * width), static_cast<double>(most_stored_cells)));
  return plan;
}

int choose_bounces(const Scene& scene, const std::vector<Densities>& densities,
                   const IlluminationPlan& plan) {
  if (scene.bounces) return *scene.bounces;
  const double width = cell_width(scene, plan);
  int bounces = 1;
  for (std::size_t i = 0; i < densities.size(); ++i) {
    const scene::Component& c = scene.medium.components[i];
    if (!(largest(c.albedo) > 0)) continue;
    const double paths =  // [transport mean free path]
        width * c.extinction * densities[i].typical * (1 - mean_cosine(c.phase));
    bounces = std::max(bounces, paths <= 0.9 ? 1 : paths <= 1.25 ? 2 : 3);
    constexpr int most = 16;
    while (is_solid(c.field) && bounces < most && dark_side_error(paths, bounces) > 0.01) ++bounces;
  }
  return bounces;
}

}  // namespace tyndall
