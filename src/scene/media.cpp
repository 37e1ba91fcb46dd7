#include "scene/media.h"

#include <algorithm>
#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/checker.h"
#include "tyndall/render/volume.h"
#include "tyndall/transport/ledger.h"

namespace tyndall::scene {
namespace {

/// Whether a field is noise. Noise keeps its own origin, with single precision; other fields are
/// moved to the box in double precision.
bool has_noise(const Medium& medium) {
  const auto is_noise = [](const Field& field) {
    return std::holds_alternative<NoiseCloud>(field);
  };
  const std::vector<Component>& all = medium.components;
  return std::any_of(all.begin(), all.end(), [&](const Component& c) {
    const auto* color = std::get_if<ColorEmission>(&c.emission);
    const auto* body = std::get_if<BlackbodyEmission>(&c.emission);
    return is_noise(c.field) || (color && is_noise(color->field))
           || (body && is_noise(body->temperature));
  });
}

void box(Checker& check) {
  const bool is_noisy = has_noise(check.scene.medium);
  const double thinnest = is_noisy ? nearest_far : 1e-8;  // over the distance from the origin
  const glm::dvec3 low = check.scene.medium.box_min, high = check.scene.medium.box_max;
  for (int a = 0; a < 3; ++a) {
    const double extent = high[a] - low[a];
    if (extent <= 0) {
      check.error("medium.box", fmt::format("expected max above min, got {} from {} to {}",
                                            axis_names[a], low[a], high[a]));
    } else if (extent < thinnest * std::max(std::abs(low[a]), std::abs(high[a]))
               || extent < limits::size.low) {
      check.error(
          "medium.box",
          fmt::format("too thin for single precision: {} from {} to {}; move it nearer to the "
                      "origin or make it thicker than {} of its distance from there{}",
                      axis_names[a], low[a], high[a], is_noisy ? "a thousandth" : "1e-8",
                      is_noisy ? " (noise is what it is at its place)" : ""));
    }
  }
}

void ground(Checker& check) {
  for (int face = 0; face < 6; ++face) {
    const auto f = static_cast<unsigned>(face);
    const std::optional<glm::dvec3>& albedo = check.scene.medium.ground[f];
    if (!albedo) continue;
    const std::string path = fmt::format("medium.ground.{}", face_names[f]);
    if (!check.open(face / 2))
      check.error(path,
                  fmt::format("this face is no end of the medium, which is periodic along {}: "
                              "expected \"open\" in medium.sides",
                              axis_names[face / 2]));
  }
}

/// Checks that walks end. Without open sides only absorption ends them: that of the grounds, or
/// that of the medium if there are no grounds. Between white grounds a walk would never end.
void walks_end(Checker& check) {
  if (check.any_ground()) {
    const auto& grounds = check.scene.medium.ground;
    if (std::none_of(grounds.begin(), grounds.end(),
                     [](const auto& albedo) { return albedo && largest(*albedo) < 1; }))
      check.error(
          "medium.ground",
          "light never leaves: at least one ground needs an albedo below 1 in every channel, "
          "or a side must be open");
    return;
  }
  const auto absorbs = [](const Component& c) { return c.extinction > 0 && largest(c.albedo) < 1; };
  const std::vector<Component>& components = check.scene.medium.components;
  if (std::none_of(components.begin(), components.end(), absorbs)) {
    check.error("medium.sides",
                "with three periodic sides light never leaves: at least one component needs an "
                "extinction above 0 and "
                "an albedo below 1 in every channel");
  }
}

/// Warns if a component is tiny compared to the box, as if their units differed: few photons hit
/// it. The whole extent of a volume counts, even if little of it is filled.
void size(Checker& check, const std::string& path, const Component& c, const Densities& densities) {
  const glm::dvec3 box = check.scene.medium.box_max - check.scene.medium.box_min;
  double space = densities.filled;
  if (const auto* grid = std::get_if<SparseGrid>(&c.field);
      grid && grid->volume && space > 0 && std::isfinite(space)) {
    const Volume& v = *grid->volume;
    const glm::dvec3 extent = glm::dvec3(v.high() - v.low()) + 1.0;
    space = extent.x * extent.y * extent.z
            * std::abs(glm::determinant(glm::dmat3(c.transform * fitted(*grid) * v.to_world())));
  }
  const double fraction = space / (box.x * box.y * box.z);
  constexpr double least = 1e-6;
  if (fraction > 0 && fraction < least)
    check.warning(
        path + ".transform",
        fmt::format("its matter has {:.1g} of the space in medium.box: was a scale forgotten? "
                    "Give the component a transform, or the box its size",
                    fraction));
}

/// Warns of slow super-voxels. In a super-voxel on a surface, the majorant is that of the inside: a
/// photon that crosses it outside has as many tentative collisions as in a full one.
void crawling(Checker& check, const std::string& path, const Component& c, double typical_density) {
  const auto* solid = std::get_if<Solid>(&c.field);
  if (solid && std::holds_alternative<Everywhere>(solid->body)) return;
  const glm::dvec3 extent = check.scene.medium.box_max - check.scene.medium.box_min;
  double crossings = 0;  // [1/length] of super-voxels; by default, of the largest number
  for (int a = 0; a < 3; ++a) {
    const int n = check.scene.medium.majorant_resolution[static_cast<std::size_t>(a)];
    crossings += 0.5 * (n > 0 ? n : 64) / extent[a];
  }
  constexpr double many = 100;
  const double collisions = c.extinction * typical_density / crossings;
  if (!(collisions > many)) return;
  check.warning(
      path + ".extinction",
      fmt::format("photons crawl: they need {:.3g} tentative collisions to pass a super-voxel "
                  "at its surface; an extinction of {:.2g} is opaque, too, or raise "
                  "medium.majorants.resolution",
                  collisions, c.extinction * many / collisions));
}

/// Checks that positions resolve the mean free path: otherwise flights would not advance.
void extinction(Checker& check, const std::string& path, const Component& c,
                const Densities& densities) {
  if (c.extinction == 0)
    check.warning(path + ".extinction", "with extinction 0 this component does nothing");
  const double densest = densities.largest;
  const auto* grid = std::get_if<SparseGrid>(&c.field);
  const bool is_empty =
      grid && grid->volume && grid->volume->active_voxels() == 0;  // reported elsewhere
  if (densest == 0 && !is_empty)
    check.warning(path + ".field", "its density is 0 everywhere: this component does nothing");
  const double across = glm::length(check.scene.medium.box_max - check.scene.medium.box_min);
  constexpr double most = 2e6;
  if (c.extinction * densest * across > most) {
    check.error(
        path + ".extinction",
        fmt::format("too dense for single precision: {:.3g} mean free paths across the medium{}, "
                    "expected at most {:g}; an extinction of {:.3g} is opaque, too",
                    c.extinction * densest * across,
                    densest == 1 ? "" : fmt::format(", where the density is {:.3g}", densest), most,
                    most / (densest * across)));
  }
  crawling(check, path, c, densities.typical);
}

void transform(Checker& check, const std::string& path, const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      const double x = m[column][row];
      if (!limits::factor.contains(x)) {
        return check.error(path, fmt::format("expected matrix elements in [{}, {}], got {}",
                                             limits::factor.low, limits::factor.high, x));
      }
    }
  }
  if (!check.affine(path, m)) return;
  double lengths = 1;
  for (int column = 0; column < 3; ++column) {
    const double length = glm::length(glm::dvec3(m[column]));
    if (length < limits::size.low) {
      return check.error(
          path, fmt::format("singular: it shrinks {} to nothing; expected a scale of at least {}",
                            axis_names[column], limits::size.low));
    }
    lengths *= length;
  }
  if (std::abs(glm::determinant(glm::dmat3(m))) < parallel_sine * lengths) {
    check.error(path, "singular: it flattens space, and cannot be inverted");
  }
}

void emission(Checker& check, const std::string& path, const Component& c) {
  if (std::holds_alternative<NoEmission>(c.emission)) return;
  std::visit([&](const auto& e) { check.ranges(path, e); }, c.emission);
  if (const auto* color = std::get_if<ColorEmission>(&c.emission)) {
    if (check.is_good(path + ".radiance") && largest(color->radiance) == 0)
      check.warning(path, "this emission is black");
    check_field(check, path + ".field", c, color->field);
  }
  if (const auto* body = std::get_if<BlackbodyEmission>(&c.emission))
    check_field(check, path + ".temperature", c, body->temperature);
  if (std::min({c.albedo.x, c.albedo.y, c.albedo.z}) >= 1)
    check.error(
        path,
        "matter emits as it absorbs, and with albedo 1 it absorbs nothing: give the component "
        "an albedo below 1");
}

void component(Checker& check, const std::string& path, const Component& c,
               const Densities& densities) {
  const std::size_t errors = check.problems.errors.size();
  check.ranges(path, c);
  if (check.is_good(path + ".extinction")) extinction(check, path, c, densities);
  check_phase(check, path + ".phase", c.phase);
  transform(check, path + ".transform", c.transform);
  check_field(check, path + ".field", c, c.field);
  emission(check, path + ".emission", c);
  if (check.problems.errors.size() == errors) size(check, path, c, densities);
}

}  // namespace

void check_medium(Checker& check, std::vector<Densities>& densities) {
  const Medium& m = check.scene.medium;
  check.ranges("medium", m);
  if (check.is_good("medium.box.min") && check.is_good("medium.box.max")) box(check);
  ground(check);
  if (m.components.empty()) {
    check.error("medium.components",
                "expected at least one component: a medium of nothing has nothing to show");
  } else if (m.components.size() > max_components) {
    check.error("medium.components", fmt::format("expected at most {} components, got {}",
                                                 max_components, m.components.size()));
  }
  for (std::size_t i = 0; i < m.components.size(); ++i) {
    densities.push_back(measure_densities(m.components[i]));
    component(check, fmt::format("medium.components[{}]", i), m.components[i], densities.back());
  }
  if (!check.any_open() && !m.components.empty()) walks_end(check);
}

}  // namespace tyndall::scene
