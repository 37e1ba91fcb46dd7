#include "scene/lights.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "scene/checker.h"
#include "scene/phases.h"
#include "scene/prepare_phase.h"
#include "tyndall/base/math.h"
#include "tyndall/render/image.h"
#include "tyndall/transport/illumination.h"

namespace tyndall::scene {
namespace {

/// The least diameter of a sun's disc [degree] within which single precision resolves directions.
constexpr double least_sun_angle = 0.01;

/// Checks the name of a group: it names a layer of EXR files, where dots have a meaning.
void group(Checker& check, const std::string& path, const std::string& name) {
  const auto is_good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'
           || c == '-';
  };
  if (name.size() > 24 || !std::all_of(name.begin(), name.end(), is_good))
    check.error(path,
                fmt::format("expected up to 24 letters, digits, '_' and '-', got \"{}\"", name));
  for (const char* taken : {"others", "emission", "background"})
    if (name == taken)
      check.error(path, fmt::format("\"{}\" is the layer of what no group has", name));
}

void check_black(Checker& check, const std::string& path, const glm::dvec3& amount) {
  if (check.is_good(path) && largest(amount) == 0) check.warning(path, "this light is black");
}

/// Warns of the series' truncation: the illumination grid holds all light of this light from its
/// first collision.
void truncated(Checker& check, const std::string& path, const char* kind) {
  double missing = 1;
  for (const Component& c : check.scene.medium.components) {
    const auto* tabulated = std::get_if<TabulatedPhase>(&c.phase);
    if (largest(c.albedo) == 0) continue;
    if (tabulated && (!tabulated->table || !phase_table_problem(*tabulated->table).message.empty()))
      continue;
    std::vector<std::vector<PhaseKnot>> tables;
    const tyndall::Phase phase = prepare_phase(c.phase, highest_order, 1, tables);
    const double series =
        double{phase.moment(0)} + 3 * double{phase.moment(1)} + 5 * double{phase.moment(2)};
    if (phase.is_split)
      missing = std::max(missing, 4 * double{pi} * double{phase.evaluate(1.0f)} / series);
  }
  if (missing > 1.1)
    check.warning(path,
                  fmt::format("between periodic sides the light of a {} is read from the "
                              "illumination grid alone, whose harmonics end at order 2: seen "
                              "towards it, light scattered once is up to {:.3g} times too dark. "
                              "Open the sides, or use a sun or an environment",
                              kind, missing));
}

/// \param half extent of the box around the light
void place(Checker& check, const std::string& path, const char* key, const char* kind,
           const glm::dvec3& center, const glm::dvec3& half) {
  if (!(check.open(0) && check.open(1) && check.open(2))
      && (check.scene.integrator == Integrator::path || check.scene.bounces != 0
          || check.any_ground()))
    check.error(path,
                fmt::format("between periodic sides a {} light has images without end, which the "
                            "camera's paths cannot ask one by one: expected the integrator "
                            "\"photons\" without bounces (gather.bounces 0), and no ground",
                            kind));
  if (!(check.open(0) && check.open(1) && check.open(2))) truncated(check, path, kind);
  bool inside = true, enters = false;
  for (int a = 0; a < 3; ++a) {
    const bool below = center[a]
                       + half[a]<check.scene.medium.box_min[a], above = center[a] - half[a]> check
                             .scene.medium.box_max[a];
    inside = inside && !below && !above;
    enters = enters || (below && check.open_face(2 * a)) || (above && check.open_face(2 * a + 1));
  }
  if (!inside && !enters) {
    check.error(
        path + "." + key,
        "outside the medium, and every side that faces it is periodic or a ground: its light "
        "cannot enter; move it inside or open a side");
  }
}

void check_light(Checker& check, const std::string& path, const PointLight& l) {
  check_black(check, path + ".power", l.power);
  if (check.is_good(path + ".position"))
    place(check, path, "position", "point", l.position, glm::dvec3(0));
}

void check_light(Checker& check, const std::string& path, const SpotLight& l) {
  check_black(check, path + ".intensity", l.intensity);
  check.direction(path + ".direction", l.direction);
  if (check.is_good(path + ".position"))
    place(check, path, "position", "spot", l.position, glm::dvec3(0));
}

void check_light(Checker& check, const std::string& path, const RectangleLight& l) {
  check_black(check, path + ".radiance", l.radiance);
  if (!check.direction(path + ".edge_u", l.edge_u) || !check.direction(path + ".edge_v", l.edge_v))
    return;
  const double lengths = glm::length(l.edge_u) * glm::length(l.edge_v);
  if (glm::length(glm::cross(l.edge_u, l.edge_v)) < 1e-3 * lengths)
    return check.error(path + ".edge_v", "parallel to edge_u: they must span an area");
  if (check.is_good(path + ".center"))
    place(check, path, "center", "rectangle", l.center,
          0.5 * (glm::abs(l.edge_u) + glm::abs(l.edge_v)));
}

void check_light(Checker& check, const std::string& path, const SphereLight& l) {
  check_black(check, path + ".radiance", l.radiance);
  if (check.is_good(path + ".center") && check.is_good(path + ".radius"))
    place(check, path, "center", "sphere", l.center, glm::dvec3(l.radius));
}

void check_light(Checker& check, const std::string& path, const DirectionalLight& l) {
  check_black(check, path + ".irradiance", l.irradiance);
  if (check.is_good(path + ".angle") && l.angle > 0 && l.angle < least_sun_angle)
    check.error(path + ".angle",
                fmt::format("expected 0, for parallel light, or at least {}, got {}",
                            least_sun_angle, l.angle));
  if (!check.direction(path + ".direction", l.direction)) return;
  if (l.angle > 0 && check.any_open()) return;
  const glm::dvec3 way = glm::normalize(l.direction);
  for (int a = 0; a < 3; ++a) {
    if (std::abs(way[a]) > parallel_sine && check.open_face(2 * a + (way[a] < 0 ? 1 : 0))) return;
  }
  check.error(path + ".direction",
              "it hits no open side of the medium: its light cannot enter; turn it or open a side");
}

void check_light(Checker& check, const std::string& path, const EnvironmentLight& l) {
  if (!l.image) check_black(check, path + ".radiance", l.radiance);
  if (l.scale == 0) check.warning(path + ".scale", "this light is black");
  if (l.image && l.image->largest() == 0) check.warning(path + ".image", "this light is black");
  if (!check.any_open())
    check.error(path, "an environment shines in through open sides, and there are none");
}

}  // namespace

void check_lights(Checker& check) {
  for (std::size_t i = 0; i < check.scene.lights.size(); ++i) {
    const std::string path = fmt::format("lights[{}]", i);
    std::visit(
        [&](const auto& l) {
          check.ranges(path, l);
          check_light(check, path, l);
          group(check, path + ".group", l.group);
        },
        check.scene.lights[i]);
  }
}

void check_shines(Checker& check) {
  const glm::dvec3& background = check.scene.background;
  const auto shines = [](const Light& light) {
    return std::visit(
        Overloaded{[](const PointLight& l) { return largest(l.power) > 0; },
                   [](const DirectionalLight& l) { return largest(l.irradiance) > 0; },
                   [](const EnvironmentLight& l) {
                     return l.scale > 0
                            && (l.image ? l.image->largest() > 0 : largest(l.radiance) > 0);
                   },
                   [](const SpotLight& l) { return largest(l.intensity) > 0; },
                   [](const auto& l) { return largest(l.radiance) > 0; }},
        light);
  };
  if (std::any_of(check.scene.lights.begin(), check.scene.lights.end(), shines)) return;
  const std::vector<Component>& components = check.scene.medium.components;
  if (std::any_of(components.begin(), components.end(), [](const Component& c) {
        return !std::holds_alternative<NoEmission>(c.emission);
      }))
    return;
  if (largest(background) > 0) {
    check.warning("lights", "no light shines: only the background will be seen");
  } else {
    Problem dark{"lights",
                 "nothing shines, neither a light nor the background: the picture would be black",
                 {"background"}};
    for (std::size_t i = 0; i < components.size(); ++i)
      dark.depends_on.push_back(fmt::format("medium.components[{}].emission", i));
    check.problems.errors.push_back(std::move(dark));
  }
}

}  // namespace tyndall::scene
