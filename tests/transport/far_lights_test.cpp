/// \file
/// Photons of placed lights of any size, at any distance. They reach everything that can receive
/// them, with the irradiance that points there see.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "support/scenes.h"
#include "tyndall/render/lights.h"
#include "tyndall/transport/light.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr double pi_ = 3.14159265358979323846;

glm::dvec3 exact(Vec3f v) { return {v.x, v.y, v.z}; }

/// The signed solid angle of a triangle [vanOosterom1983].
double solid_angle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  a = glm::normalize(a), b = glm::normalize(b), c = glm::normalize(c);
  return 2
         * std::atan2(glm::dot(a, glm::cross(b, c)),
                      1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
}

/// The fluence rate at `p`, which sees the whole light.
double fluence(const scene::Light& light, const glm::dvec3& p) {
  if (const auto* l = std::get_if<scene::PointLight>(&light))
    return l->power.x / (4 * pi_ * glm::dot(l->position - p, l->position - p));
  if (const auto* l = std::get_if<scene::SpotLight>(&light)) {
    const glm::dvec3 way = p - l->position;
    const glm::dvec3 axis = glm::normalize(l->direction);
    const double outer = 2 * std::pow(std::sin(l->angle / 4 * pi_ / 180), 2),
                 inner = 2 * std::pow(std::sin(l->angle * (1 - l->edge) / 4 * pi_ / 180), 2);
    const double here = 0.5 * std::pow(glm::length(glm::normalize(way) - axis), 2);
    const double x = std::clamp((outer - here) / (outer - inner + 1e-30), 0.0, 1.0);
    return x * x * (3 - 2 * x) * l->intensity.x / glm::dot(way, way);
  }
  if (const auto* l = std::get_if<scene::RectangleLight>(&light)) {
    const glm::dvec3 across = glm::cross(l->edge_u, l->edge_v), way = p - l->center;
    const double distance = glm::length(way);
    if (distance > 100 * std::max(glm::length(l->edge_u), glm::length(l->edge_v)))
      return l->radiance.x * std::max(glm::dot(across, way), 0.0) / std::pow(distance, 3);
    const auto corner = [&](double u, double v) {
      return l->center + u * l->edge_u + v * l->edge_v - p;
    };
    const glm::dvec3 a = corner(-0.5, -0.5), b = corner(0.5, -0.5), c = corner(0.5, 0.5),
                     d = corner(-0.5, 0.5);
    // From the lit side, the corners turn the other way.
    return l->radiance.x * std::max(-(solid_angle(a, b, c) + solid_angle(a, c, d)), 0.0);
  }
  const auto& l = std::get<scene::SphereLight>(light);
  const double sine = l.radius / glm::length(l.center - p);
  return sine < 1 ? 2 * pi_ * sine * sine / (1 + std::sqrt(1 - sine * sine)) * l.radiance.x : 0;
}

struct Case {
  std::string name;
  scene::Light light;
  double least;  ///< fraction of the photons that must arrive
};

/// Lights around a medium of width 1 at the origin.
std::vector<Case> cases() {
  using namespace scene;
  std::vector<Case> all;
  const glm::dvec3 one(1);
  const auto add = [&](std::string name, Light light, double least = 0.1) {
    all.push_back({std::move(name), std::move(light), least});
  };
  for (const double distance : {3.0, 1e3, 1e6, 1e8}) {
    const glm::dvec3 at = distance * glm::normalize(glm::dvec3(2, 9, -4));
    const std::string from = " from " + std::to_string(distance);
    add("point" + from, PointLight{at, one, ""}, 0.2);
    SpotLight spot{at, -at, 40, 0.5, one, ""};
    add("spot" + from, spot, 0.1);
    for (const double size : {0.01, 1.0, 100.0, 1e4}) {
      const std::string of = " of " + std::to_string(size) + from;
      if (0.8 * size < distance) add("sphere" + of, SphereLight{at, 0.5 * size, one, ""});
      const glm::dvec3 u = glm::normalize(glm::cross(at, glm::dvec3(1, 0, 0))),
                       v = glm::normalize(glm::cross(u, at));
      add("rectangle" + of, RectangleLight{at, size * u, size * v, one, ""});
      const glm::dvec3 tilted = glm::normalize(v + 2.0 * glm::normalize(at));
      add("tilted" + of, RectangleLight{at, size * u, size * tilted, one, ""});
    }
  }
  add("a pencil of light", SpotLight{{2e3, 9e3, -4e3}, {-2, -9, 4}, 0.01, 0.5, one, ""}, 0.3);
  add("a huge sphere that touches", SphereLight{{0, 1e4 + 0.51, 0}, 1e4, one, ""});
  add("a strip", RectangleLight{{3, 2, 1}, {0, 0, 300}, {-0.02, 0, 0}, one, ""}, 0.05);
  add("a wall at a grazing angle",
      RectangleLight{{5100, 0.8, 0}, {1e4, 0, 0}, {0, 0, 1e4}, one, ""}, 0.04);
  add("rectangle within", RectangleLight{{0.1, 0.2, 0}, {0.2, 0, 0}, {0, 0.02, 0.1}, one, ""}, 0.9);
  add("sphere within", SphereLight{{0.1, 0.2, 0}, 0.1, one, ""}, 0.9);
  return all;
}

struct Lit {
  Scene scene;
  PreparedScene prepared;
  Box box;
  /// \param inside fraction of the box's width that the medium fills, in the middle
  Lit(const scene::Light& light, double inside) {
    scene.medium.box_min = glm::dvec3(-0.5 / inside);
    scene.medium.box_max = glm::dvec3(0.5 / inside);
    const int cells = inside < 1 ? 64 : 1;
    scene.medium.majorant_resolution = {cells, cells, cells};
    const scene::Cuboid middle{glm::dvec3(-0.49), glm::dvec3(0.49)};
    scene.medium.components = {inside < 1 ? component(scene::Solid{middle}, 1)
                                          : component(scene::Solid{}, 1)};
    scene.lights = {light};
    prepared = prepare(scene, 1);
    box = std::visit([](const auto& medium) { return medium.whole.box; }, prepared.medium);
  }
  Photon photon(std::uint64_t index) const {
    const RandomStream random{5, index, Domain::photon};
    return emit({prepared.emitters.data(), static_cast<int>(prepared.emitters.size())}, box,
                random.block(0, Purpose::emission), random.block(0, Purpose::aim));
  }
};

/// The length of a ray within a box.
double length_within(const Ray& ray, glm::dvec3 low, glm::dvec3 high) {
  double t0 = 0, t1 = 1e30;
  const glm::dvec3 o = exact(ray.origin), d = exact(ray.direction);
  for (int a = 0; a < 3; ++a) {
    const double x = (low[a] - o[a]) / d[a], y = (high[a] - o[a]) / d[a];
    t0 = std::max(t0, std::min(x, y)), t1 = std::min(t1, std::max(x, y));
  }
  return std::max(t1 - t0, 0.0);
}

void expect_right(double inside) {
  constexpr int n = 2, photons = 20000, points = 6;
  const double edge = 1.0 / n;
  for (const Case& c : cases()) {
    const Lit lit(c.light, inside);
    ASSERT_FALSE(lit.prepared.emitters.empty()) << c.name;
    ASSERT_TRUE(lit.prepared.warnings.empty()) << c.name << ": " << lit.prepared.warnings[0];
    const glm::dvec3 corner = glm::dvec3(0.5 / inside - 0.5);
    std::vector<Series> brought(n * n * n);
    int arrived = 0;
    for (int k = 0; k < photons; ++k) {
      const Photon photon = lit.photon(static_cast<std::uint64_t>(k));
      ASSERT_LE(largest(photon.weight), 1.0f);
      double sum = 0;
      for (int i = 0; i < n * n * n; ++i) {
        const glm::dvec3 low = corner + edge * glm::dvec3(i % n, i / n % n, i / n / n);
        const double length =
            largest(photon.weight) > 0 ? length_within(photon.ray, low, low + edge) : 0.0;
        sum += length;
        brought[static_cast<std::size_t>(i)].add(lit.prepared.shot_power * length
                                                 / (edge * edge * edge) * double{photon.weight.x});
      }
      arrived += sum > 0;
    }
    EXPECT_GT(arrived, c.least * photons) << c.name;
    if (c.name.find("within") != c.name.npos) continue;
    std::vector<double> p;
    for (int i = 0; i < n * n * n; ++i) {
      double seen = 0;
      for (int m = 0; m < points * points * points; ++m) {
        const glm::dvec3 at =
            glm::dvec3(-0.5) + edge * glm::dvec3(i % n, i / n % n, i / n / n)
            + edge / points
                  * (0.5 + glm::dvec3(m % points, m / points % points, m / points / points));
        seen += fluence(c.light, at) / (points * points * points);
      }
      const Series& s = brought[static_cast<std::size_t>(i)];
      p.push_back(
          normal_p((s.mean() - seen) / std::hypot(s.standard_error(), 2e-3 * seen + 1e-30)));
    }
    EXPECT_GT(bonferroni_p(p), level) << c.name;
  }
}

TEST(FarLights, of_any_size_bring_what_points_see) { expect_right(1); }

TEST(FarLights, are_aimed_at_the_matter_in_a_large_box) { expect_right(0.125); }

TEST(FarLights, account_for_all_power) {
  for (const Case& c : cases()) {
    double power = 0;
    if (const auto* l = std::get_if<scene::PointLight>(&c.light)) power = l->power.x;
    if (const auto* l = std::get_if<scene::SpotLight>(&c.light))
      power = tyndall::solid_angle(*l) * l->intensity.x;
    if (const auto* l = std::get_if<scene::RectangleLight>(&c.light))
      power = etendue(*l) * l->radiance.x;
    if (const auto* l = std::get_if<scene::SphereLight>(&c.light))
      power = etendue(*l) * l->radiance.x;
    const Lit lit(c.light, 1);
    Series series;
    for (int k = 0; k < 10000; ++k)
      series.add(double{lit.photon(static_cast<std::uint64_t>(k)).weight.x});
    const double shot = lit.prepared.shot_power * series.mean(),
                 error = lit.prepared.shot_power * series.standard_error();
    EXPECT_LT(std::abs(shot + lit.prepared.unshot_power.x - power), 4 * error + 1e-3 * power)
        << c.name << ": " << shot << " + " << lit.prepared.unshot_power.x << " of " << power;
  }
}

// Detectors count light that crosses the box without hitting the medium.
TEST(FarLights, shine_at_the_whole_box_where_detectors_count_what_leaves_it) {
  const scene::Light light = scene::PointLight{{0, 50, 0}, glm::dvec3(1), ""};
  Scene scene = Lit(light, 0.125).scene;
  const double matter = prepare(scene, 1).shot_power;
  scene.detectors.exit_angle_bins = 4;
  EXPECT_GT(prepare(scene, 1).shot_power, 20 * matter);
}

TEST(FarLights, shine_at_grounds) {
  const scene::Light light = scene::PointLight{{0, 50, 0}, glm::dvec3(1), ""};
  Scene scene = Lit(light, 0.125).scene;
  const double matter = prepare(scene, 1).shot_power;
  scene.medium.ground[2] = glm::dvec3(0.5);
  EXPECT_GT(prepare(scene, 1).shot_power, 20 * matter);
}

// ---- Lights without effect

std::string warning_of(const scene::Light& light, bool has_ground = false) {
  Scene scene = Lit(scene::PointLight{{0, 2, 0}, glm::dvec3(1), ""}, 1).scene;
  if (has_ground) scene.medium.ground[2] = glm::dvec3(0.5);
  scene.lights.push_back(light);
  const std::vector<std::string> warnings = prepare(scene, 1).warnings;
  return warnings.empty() ? std::string() : warnings[0];
}

void expect_starts(const std::string& text, const std::string& with) {
  EXPECT_EQ(text.substr(0, with.size()), with) << text;
}

TEST(LightsThatGiveNothing, are_named_with_cause_and_remedy) {
  using namespace scene;
  const glm::dvec3 one(1);
  expect_starts(warning_of(SpotLight{{0, 3, 0}, {0, 1, 0}, 40, 0.5, one, ""}),
                "lights[1] (spot): none of its light reaches the medium: its cone passes by; turn "
                "its direction to [0, -3, 0]");
  EXPECT_EQ(warning_of(SpotLight{{0, 3, 0}, {0, -1, 0}, 40, 0.5, one, ""}), "");
  expect_starts(warning_of(RectangleLight{{0, 3, 0}, {0, 0, 1}, {1, 0, 0}, one, "key"}),
                "lights[1] (rectangle, group \"key\"): none of its light reaches the medium: it is "
                "turned away");
  EXPECT_EQ(warning_of(RectangleLight{{0, 3, 0}, {1, 0, 0}, {0, 0, 1}, one, ""}), "");
  expect_starts(warning_of(SphereLight{{0, 0, 0}, 2, one, ""}),
                "lights[1] (sphere): none of its light reaches the medium: the matter is inside");
  EXPECT_EQ(warning_of(SphereLight{{0, 1, 0}, 0.3, one, ""}), "");
  for (const Light& light : std::vector<Light>{
           PointLight{{0, -3, 0}, one, ""}, SpotLight{{0, -3, 0}, {0, 1, 0}, 9, 0.5, one, ""},
           SphereLight{{0, -3, 0}, 0.1, one, ""},
           RectangleLight{{0, -3, 0}, {0, 0, 1}, {1, 0, 0}, one, ""}}) {
    EXPECT_EQ(warning_of(light), "");
    EXPECT_NE(warning_of(light, true).find("a ground is between"), std::string::npos)
        << warning_of(light, true);
  }
  EXPECT_EQ(warning_of(PointLight{{0, -3, 0}, glm::dvec3(0), ""}), "") << "check() says so";
}

TEST(LightsThatGiveNothing, have_emissions_among_them) {
  using namespace scene;
  const auto warning = [](scene::Emission emission, glm::dvec3 albedo = glm::dvec3(0.2)) {
    Scene scene = Lit(PointLight{{0, 2, 0}, glm::dvec3(1), ""}, 1).scene;
    scene.medium.components[0].albedo = albedo;
    scene.medium.components[0].emission = std::move(emission);
    const std::vector<std::string> warnings = prepare(scene, 1).warnings;
    return warnings.empty() ? std::string() : warnings[0];
  };
  scene::DenseGrid cold = ramp(4, 0);  // up to 0.875
  BlackbodyEmission body;
  body.temperature = cold;
  expect_starts(warning(body),
                "medium.components[0].emission: its largest temperature is 0.875 K, and black "
                "bodies below 700 K do not shine visibly; the convention 0 to 1 wants a remap that "
                "makes kelvins of it, such as \"remap\": {\"scale\": 2286}");
  cold.remap.scale = 2286;
  body.temperature = cold;
  EXPECT_EQ(warning(body), "");
  cold.remap.scale = 300;
  body.temperature = cold;
  EXPECT_NE(warning(body).find("262.5 K"), std::string::npos) << warning(body);
  cold.remap.offset = 100;
  body.temperature = cold;
  EXPECT_NE(warning(body).find("give a remap that makes kelvins of its numbers"), std::string::npos)
      << "no number is right with an offset: " << warning(body);
  cold.remap.offset = 0;
  BlackbodyEmission none;
  none.temperature = scene::Solid{};
  none.intensity = 0;
  EXPECT_NE(warning(none).find("its intensity is 0"), std::string::npos) << warning(none);
  scene::DenseGrid hot;  // in the corner that is outside the box
  hot.size = {8, 8, 8};
  hot.values.assign(512, 300);
  hot.values[511] = 2500;
  body.temperature = hot;
  EXPECT_NE(warning(body).find("hot only where the medium is not: its largest temperature is 2500 "
                               "K, 300 K in the medium"),
            std::string::npos)
      << warning(body);
  cold.remap.scale = 0;
  EXPECT_NE(warning(ColorEmission{glm::dvec3(1), cold}).find("its field is 0"), std::string::npos);
  EXPECT_NE(
      warning(ColorEmission{{0, 1, 0}, scene::Solid{}}, {0.5, 1, 0.5}).find("absorbs nothing"),
      std::string::npos);
  EXPECT_NE(warning(ColorEmission{{0, 1, 0}, scene::Solid{Sphere{glm::dvec3(9), 0.1}}})
                .find("where the matter is"),
            std::string::npos);
  EXPECT_EQ(warning(ColorEmission{{0, 1, 0}, scene::Solid{}}), "");
}

TEST(Components, outside_the_box_are_warned_of) {
  const auto warnings = [](glm::dvec3 center) {
    Scene scene = Lit(scene::PointLight{{0, 2, 0}, glm::dvec3(1), ""}, 1).scene;
    scene.medium.components.push_back(scene.medium.components[0]);
    scene.medium.components[1].field = scene::Solid{scene::Sphere{center, 0.2}};
    return prepare(scene, 1).warnings;
  };
  EXPECT_TRUE(warnings({0, 0, 0}).empty());
  const std::vector<std::string> outside = warnings({50, 0, 0});
  ASSERT_EQ(outside.size(), 1U);
  expect_starts(outside[0], "medium.components[1]: no part of it is within medium.box");
}

}  // namespace
}  // namespace tyndall::test
