#include "tyndall/render/prepare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

#include "render/bricks.h"
#include "render/camera.h"
#include "render/emission.h"
#include "render/field_views.h"
#include "render/lights.h"
#include "render/majorants.h"
#include "scene/cube_root.h"
#include "scene/prepare_phase.h"
#include "scene/values.h"
#include "tyndall/render/bounds.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/render.h"
#include "tyndall/render/volume.h"
#include "tyndall/scene/limits.h"

namespace tyndall {
namespace {

// ---- Box

Box view(const scene::Medium& medium) {
  Box box;
  box.extent = to_vec3f(medium.box_max - medium.box_min);
  box.periodic_x = medium.sides[0] == scene::Side::periodic;
  box.periodic_y = medium.sides[1] == scene::Side::periodic;
  box.periodic_z = medium.sides[2] == scene::Side::periodic;
  for (unsigned face = 0; face < 6; ++face) {
    if (!medium.ground[face]) continue;
    box.grounds |= 1u << face;
    box.ground_albedo[face] = to_vec3f(*medium.ground[face]);
  }
  return box;
}

// ---- Components

/// Transforms the field space of a view to that of the scene's field. \param leader defines the
/// `fit`
glm::dmat4 view_to_field(const scene::Field& field, const scene::Field& leader) {
  const auto *grid = std::get_if<scene::SparseGrid>(&field),
             *first = std::get_if<scene::SparseGrid>(&leader);
  if (!grid) return glm::dmat4(1.0);
  const Volume& volume = *grid->volume;
  glm::dmat4 place = volume.to_world();
  place[3] = place * glm::dvec4(glm::dvec3(volume.low()), 1.0);
  return fitted(first ? *first : *grid) * place;
}

/// The origin of the field space of a view. For a solid far from the scene's origin it is the box's
/// corner, to keep single precision.
glm::dvec3 view_origin(const scene::Component& component, const scene::Field& field,
                       const scene::Medium& medium) {
  const glm::dvec3 low = medium.box_min, high = medium.box_max;
  const glm::dvec3 away = glm::max(glm::abs(low), glm::abs(high));
  const bool is_far = glm::any(glm::lessThan(high - low, nearest_far * away));
  if (!is_far || !std::holds_alternative<scene::Solid>(field)) return glm::dvec3(0.0);
  return glm::dvec3(glm::inverse(component.transform) * glm::dvec4(low, 1.0));
}

/// Transforms local space to the field space of a view of `field`, the component's or its
/// emission's.
Affine local_to_view(const scene::Component& component, const scene::Field& field,
                     const scene::Medium& medium) {
  const glm::dmat4 inverse =
      glm::inverse(component.transform * view_to_field(field, component.field));
  const glm::dvec3 offset =
      glm::dvec3(inverse * glm::dvec4(medium.box_min, 1.0)) - view_origin(component, field, medium);
  return {to_vec3f({inverse[0][0], inverse[1][0], inverse[2][0]}),
          to_vec3f({inverse[0][1], inverse[1][1], inverse[2][1]}),
          to_vec3f({inverse[0][2], inverse[1][2], inverse[2][2]}), to_vec3f(offset)};
}

/// A view of `field`, the component's or its emission's.
AnyField any_view(const scene::Component& component, const scene::Field& field,
                  const scene::Medium& medium) {
  const glm::dvec3 origin = view_origin(component, field, medium);
  return std::visit([&](const auto& f) { return AnyField(tyndall::view(f, origin)); }, field);
}

/// \return nothing if the component has no emission.
std::optional<Emission> view_emission(const scene::Component& component,
                                      const scene::Medium& medium) {
  Emission e;
  const auto place = [&](const scene::Field& field) {
    e.to_field = local_to_view(component, field, medium);
  };
  if (const auto* color = std::get_if<scene::ColorEmission>(&component.emission)) {
    e.factor = to_vec3f(color->radiance);
    place(color->field);
    const auto* grid = std::get_if<scene::SparseGrid>(&color->field);
    if (grid && grid->volume->is_color()) {
      e.kind = Emission::Kind::color;
      e.colors = grid->volume->color_view();
      e.colors.nearest = grid->interpolation == scene::Interpolation::nearest;
    } else {
      e.field = any_view(component, color->field, medium);
    }
    return e;
  }
  if (const auto* body = std::get_if<scene::BlackbodyEmission>(&component.emission)) {
    e.kind = Emission::Kind::blackbody;
    e.factor = to_vec3f(glm::dvec3(body->intensity));
    e.blackbody.rgb = blackbody_table().data();
    place(body->temperature);
    e.field = any_view(component, body->temperature, medium);
    return e;
  }
  return {};
}

Component<AnyField> view(const scene::Component& component, const scene::Medium& medium) {
  Component<AnyField> c;
  c.field = any_view(component, component.field, medium);
  c.to_field = local_to_view(component, component.field, medium);
  c.extinction = static_cast<float>(component.extinction);
  c.albedo = to_vec3f(component.albedo);
  return c;
}

double default_marching_step(const Scene& scene) {
  double step = 1e300;
  const double least = glm::length(scene.medium.box_max - scene.medium.box_min) / most_steps;
  for (const scene::Component& c : scene.medium.components) {
    const glm::dmat3 m(c.transform * view_to_field(c.field, c.field));
    const double scale = std::min({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])});
    step = std::min(step,
                    scale * std::visit([](const auto& f) { return finest_feature(f); }, c.field));
  }
  return std::max(step, least);
}

// ---- Bounds

/// Orders components by ascending majorants: the decision value v = u * sum keeps its resolution
/// near 0, so that thin fog beside a dense body still collides at the right rate.
std::vector<int> ascending(const std::vector<float>& majorants) {
  std::vector<int> order(majorants.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return majorants[static_cast<std::size_t>(a)] < majorants[static_cast<std::size_t>(b)];
  });
  return order;
}

/// An upper bound of a component's extinction.
float largest_sigma_t(const Component<AnyField>& c) {
  return static_cast<float>(c.extinction * largest_density(c.field));
}

// ---- Groups

/// Lists the light groups, if any light has one.
void prepare_groups(PreparedScene& out) {
  const auto named = [](const std::string& name) { return !name.empty(); };
  if (std::none_of(out.light_groups.begin(), out.light_groups.end(), named)) return;
  out.groups = out.light_groups;
  std::replace(out.groups.begin(), out.groups.end(), std::string(), std::string("others"));
  const auto last = static_cast<int>(out.groups.size());
  bool shines = false;
  for (Emitter& emitter : out.emitters) {
    if (!emitter.is_medium()) continue;
    emitter.group = last;
    shines = true;
  }
  if (shines) out.groups.push_back("emission");
  out.groups.push_back("background");
}

// ---- Film

/// An upper bound of the component's emission [W/(area sr)].
double brightest_source(const Component<AnyField>& c, const Box& box) {
  const glm::dvec3 extent = to_dvec3(box.extent);
  const Region whole{0.5 * extent, 0.5 * extent};
  return emission_bound(*c.emission, Vec3f{1, 1, 1} - c.albedo,
                        in_field_space(c.emission->to_field, whole, extent));
}

/// The largest value of a phase function [1/sr].
float peak(const Phase& phase) {
  float most = max(phase.evaluate(1.0f), phase.evaluate(-1.0f));
  for (int i = 0; i < phase.knot_count; ++i) most = max(most, phase.knots[i].density);
  return most;
}

/// A power of two near the largest radiance. The film's integers count 2^-24 of it, and samples are
/// clamped at Film::range times it. The unit is larger if the peak of a phase function, seen
/// towards a light, would be clamped.
/// \param light see prepare_lights()
float film_unit(const Scene& scene, const std::vector<Component<AnyField>>& components,
                const Box& box, double light) {
  double brightest = std::max(largest(scene.background), light);
  float largest_peak = 0;
  for (const Component<AnyField>& c : components) {
    if (c.emission) brightest = std::max(brightest, brightest_source(c, box));
    if (c.scatters()) largest_peak = max(largest_peak, peak(c.phase));
  }
  if (!(brightest > 0)) return 1.0f;
  constexpr double margin = 4;  // for path weights and several scatterings in a sample
  brightest = std::max(brightest, margin * light * double{largest_peak} / double{Film::range});
  int exponent = 0;
  std::frexp(brightest, &exponent);
  return static_cast<float>(std::ldexp(1.0, std::clamp(exponent, -80, 80)));
}

// ---- Detectors

Detectors view(const scene::Detectors& from, const glm::dvec3& extent) {
  Detectors d;
  d.flux_u = from.flux[0], d.flux_v = from.flux[1];
  d.lengths = from.path_length_bins;
  d.scatterings = from.scattering_bins;
  d.angles = from.exit_angle_bins;
  d.nx = from.absorbed[0], d.ny = from.absorbed[1], d.nz = from.absorbed[2];
  if (d.lengths > 0) d.inverse_length = static_cast<float>(d.lengths / from.path_length_max);
  d.inverse_extent = to_vec3f(1.0 / extent);
  d.inverse_voxel_size = to_vec3f(glm::dvec3(d.nx, d.ny, d.nz) / extent);
  return d;
}

bool is_grey(Vec3f color) { return color.x == color.y && color.y == color.z; }

/// Whether only the medium receives light: no ground reflects it, no detector counts it, and light
/// that misses the medium leaves the box.
bool receives_in_matter_alone(const Scene& scene) {
  const scene::Medium& m = scene.medium;
  const auto is_open = [](scene::Side side) { return side == scene::Side::open; };
  return std::all_of(m.sides.begin(), m.sides.end(), is_open)
         && std::none_of(m.ground.begin(), m.ground.end(),
                         [](const auto& albedo) { return albedo.has_value(); })
         && !detects(scene);
}

/// \return 1 if nothing has a colour, for a third of the memory and of the deposits; otherwise 3.
int illumination_channels(const PreparedScene& scene, const Box& box) {
  const bool grey =
      std::all_of(scene.emitters.begin(), scene.emitters.end(),
                  [](const Emitter& e) {
                    return !e.is_medium() && !e.light.is<lights::ImageEnvironment>()
                           && is_grey(e.weight);
                  })
      && std::all_of(scene.components.begin(), scene.components.end(),
                     [](const Component<AnyField>& c) { return is_grey(c.albedo); })
      && std::all_of(std::begin(box.ground_albedo), std::end(box.ground_albedo), is_grey);
  return grey ? 1 : 3;
}

}  // namespace

PreparedScene prepare(const ResolvedScene& resolved, int threads,
                      const std::function<void(double)>& progress, const Stop& stop,
                      double table_points) {
  const Scene& scene = resolved;
  PreparedScene out;
  out.source = resolved.share();
  const Box box = view(scene.medium);
  std::vector<Component<AnyField>> components;
  std::vector<float> majorants;
  const int order = resolved.illumination_order;
  // Counts the scatterings of a camera path before it reads the grid, the one where it reads the
  // grid, and the first one of the photon unless the grid holds all light.
  out.bounces = resolved.bounces;
  const int scatterings =
      out.bounces + (scene.single_scattering == scene::SingleScattering::apart ? 2 : 1);
  out.emissions.reserve(scene.medium.components.size());
  for (const scene::Component& c : scene.medium.components) {
    components.push_back(view(c, scene.medium));
    components.back().phase = prepare_phase(c.phase, order, scatterings, out.phase_tables);
    // A path that continues would miss the light of unsampled lights.
    if (has_unsampled_lights(scene)) components.back().phase.is_split = false;
    if (const auto emission = view_emission(c, scene.medium)) {
      out.emissions.push_back(*emission);
      components.back().emission = &out.emissions.back();
    }
    majorants.push_back(largest_sigma_t(components.back()));
  }
  out.scene_component = ascending(majorants);
  for (const int i : out.scene_component)
    out.components.push_back(components[static_cast<std::size_t>(i)]);

  out.tables = build_majorants(out.components, box, scene.medium.majorant_resolution, threads,
                               progress, stop);
  for (std::size_t c = 0; c < out.components.size(); ++c) {
    const int index = out.scene_component[c];
    if (majorants[static_cast<std::size_t>(index)] > 0
        && !(matter_region(out.tables, c, to_dvec3(box.extent)).half.x > 0))
      out.warnings.push_back(fmt::format(
          "medium.components[{}]: no part of it is within medium.box: move it with its transform, "
          "or enlarge the box",
          index));
  }
  out.noise_tables = tabulate_noise(out.components, box, out.tables, table_points, threads, stop);
  out.bound_tables = tabulate_bounds(out.components, threads, stop);
  const int nx = out.tables.nx, ny = out.tables.ny, nz = out.tables.nz;
  MajorantGrid grid, whole;
  grid.nx = nx, grid.ny = ny, grid.nz = nz;
  grid.components = whole.components = static_cast<int>(components.size());
  grid.box = whole.box = box;
  const glm::dvec3 extent = to_dvec3(box.extent), resolution(nx, ny, nz);
  grid.cell_size = to_vec3f(extent / resolution);
  grid.inverse_cell_size = to_vec3f(resolution / extent);
  grid.total = out.tables.total.data(), grid.upper = out.tables.upper.data(),
  grid.lower = out.tables.lower.data();
  whole.cell_size = box.extent;
  whole.inverse_cell_size = to_vec3f(1.0 / extent);
  whole.total = out.tables.whole_total.data(), whole.upper = out.tables.whole_upper.data();
  whole.lower = out.tables.whole_lower.data();

  if (components.size() == 1) {
    const Component<AnyField>& c = out.components[0];
    c.field.visit([&]<class Field>(const Field& field) {
      out.medium = SingleMedium<Field>{
          grid, whole, {field, c.to_field, c.extinction, c.albedo, c.phase, c.emission}};
    });
  } else {
    out.medium =
        MixedMedium{grid, whole, out.components.data(), static_cast<int>(out.components.size())};
  }
  switch (scene.sampler) {
    case scene::Sampler::super_voxel:
      out.sampler = SuperVoxel{};
      break;
    case scene::Sampler::woodcock:
      out.sampler = Woodcock{};
      break;
    case scene::Sampler::ray_marching:
      out.sampler = RayMarching{static_cast<float>(
          scene.marching_step > 0 ? scene.marching_step : default_marching_step(scene))};
      break;
  }

  out.has_grid = scene.integrator == scene::Integrator::photons;
  out.is_apart = scene.single_scattering == scene::SingleScattering::apart;
  IlluminationPlan plan;
  if (out.has_grid) plan = resolved.illumination;
  if (plan.is_sparse) {
    store_bricks(box, plan.cells, threads, stop, out);
    if (receives_in_matter_alone(scene)) out.clumps = find_clumps(out, box, plan.cells);
  }
  const double brightest_light = prepare_lights(scene, box, threads, stop, out);
  prepare_groups(out);
  out.background = to_vec3f(scene.background);
  prepare_view(resolved, out);
  out.film_unit = film_unit(scene, out.components, box, brightest_light);
  out.seed = scene.seed;

  const auto [cx, cy, cz] = plan.cells;
  out.cells = {{cx, cy, cz},
               order,
               box,
               to_vec3f(glm::dvec3(cx, cy, cz) / extent),
               illumination_channels(out, box),
               std::max(static_cast<int>(out.groups.size()) - 1, 1),
               {}};
  if (plan.is_sparse) {
    out.cells.bricks = {out.brick_table.data(), out.brick_places.data(),
                        static_cast<std::uint32_t>(out.brick_table.size() - 1),
                        static_cast<std::uint32_t>(out.brick_places.size())};
  }
  out.cell_size = to_vec3f(extent / glm::dvec3(cx, cy, cz));
  // As many points as a 256^3 grid has cells. With a million photons their error is 0.02 of the
  // photons' error in a cloud and 0.2 at the edge of a solid; with 8 million, three times that
  // (tests/statistical). At least 3^3 points per cell, and 6^3 where there is little medium:
  // otherwise wisps slip between them.
  const int across = plan.is_sparse ? static_cast<int>(cube_root(double{1} * out.cells.count()))
                                    : std::max({cx, cy, cz});
  out.strata = clamp(256 / across, 3, 8);
  int exponent = 0;
  std::frexp(std::max(double{out.tables.whole_total[0]}, 1e-30), &exponent);
  out.matter_scale = static_cast<float>(std::ldexp(1.0, 40 - exponent));
  if (detects(scene)) out.detectors = view(scene.detectors, extent);
  return out;
}

std::vector<std::string> lights_that_give_nothing(const ResolvedScene& resolved, int threads) {
  const Scene& scene = resolved;
  const bool has_placed = !std::all_of(scene.lights.begin(), scene.lights.end(), is_distant);
  const std::vector<scene::Component>& components = scene.medium.components;
  const bool shines =
      std::any_of(components.begin(), components.end(), [](const scene::Component& c) {
        return !std::holds_alternative<scene::NoEmission>(c.emission);
      });
  constexpr double no_table = 1;  // points
  if (!has_placed && !shines) return {};
  return prepare(resolved, threads, {}, {}, no_table).warnings;
}

void prepare_view(const ResolvedScene& scene, PreparedScene& prepared) {
  PreparedScene& p = prepared;
  p.camera = prepare_camera(scene, p.filter_quantiles);
  p.film_width = p.camera.window.width;
  p.film_height = p.camera.window.height;
  const DirectLights lights{p.direct_lights.data(), static_cast<int>(p.direct_lights.size())};
  const bool is_dark = !(largest(p.background) > 0.0f) && !lights.any_hit();
  p.bright_pixels =
      is_dark ? pixels_that_meet(p.camera, view(scene->medium)) : std::vector<std::uint32_t>();
  p.gather_seed = scene->gather_seed.value_or(scene->seed);
  p.hash = scene_hash(scene);
}

}  // namespace tyndall
