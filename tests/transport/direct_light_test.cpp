/// \file
/// Every kind of light as seen from the medium, sampled and hit by rays, against closed forms and
/// quadrature; and its photons against the samples.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include <glm/geometric.hpp>

#include "support/scenes.h"
#include "tyndall/render/image.h"
#include "tyndall/render/lights.h"
#include "tyndall/transport/light.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr double pi_ = 3.14159265358979323846;

glm::dvec3 exact(Vec3f v) { return {v.x, v.y, v.z}; }
Vec3f rounded(glm::dvec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// A small coloured sky with a black texel, a bright one, and a bright pole.
std::shared_ptr<const Image> small_sky() {
  std::vector<Vec3f> texels;
  for (int i = 0; i < 6 * 5; ++i) {
    const auto k = static_cast<float>(i * 7 % 11);
    texels.push_back({0.1f * k, 0.5f + 0.05f * k, 1.5f - 0.1f * k});
  }
  texels[8] = {0, 0, 0};
  texels[15] = {9, 7, 5};
  texels[1] = {6, 3, 0};
  texels[27] = {0, 0, 0};
  return std::make_shared<const Image>(6, 5, std::move(texels));
}

/// The radiance of an image by its definition, in double precision.
glm::dvec3 radiance_of(const Image& image, glm::dvec3 direction, double rotation) {
  const double azimuth = std::atan2(direction.x, direction.z) - rotation * pi_ / 180;
  double u = 0.5 - azimuth / (2 * pi_);
  u -= std::floor(u);
  const double v = std::acos(std::clamp(direction.y, -1.0, 1.0)) / pi_;
  const double x = u * image.width() - 0.5, y = v * image.height() - 0.5;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const auto texel = [&](int column, int row) {
    column = (column + image.width()) % image.width();
    row = std::clamp(row, 0, image.height() - 1);
    return exact(image.texels()[static_cast<std::size_t>(row * image.width() + column)]);
  };
  const double s = x - i, t = y - j;
  return (1 - t) * ((1 - s) * texel(i, j) + s * texel(i + 1, j))
         + t * ((1 - s) * texel(i, j + 1) + s * texel(i + 1, j + 1));
}

/// A light, its bounding sphere unless it is distant, and the irradiance from all directions that a
/// point receives without a medium [W/area].
struct Case {
  const char* name;
  scene::Light light;
  glm::dvec3 center{0};
  double radius = -1;  ///< below 0: distant
};

std::vector<Case> cases() {
  using namespace scene;
  std::vector<Case> all;
  const auto placed = [&](const char* name, Light light, glm::dvec3 center, double radius) {
    all.push_back({name, std::move(light), center, radius});
  };
  placed("point", PointLight{{2.5, 1.7, -1}, {3, 5, 4}, ""}, {2.5, 1.7, -1}, 0);
  placed("point within", PointLight{{0.4, 1.3, 0.2}, {3, 5, 4}, ""}, {0.4, 1.3, 0.2}, 0);
  SpotLight spot{{2, 3, -1}, {-1, -1.5, 1.2}, 50, 0.6, {2, 1, 3}, ""};
  placed("spot", spot, spot.position, 0);
  spot.direction = {-1, -0.6, 0.6};
  placed("spot that is half past the box", spot, spot.position, 0);
  spot.angle = 10, spot.edge = 0, spot.direction = {-1, -1.4, 0.8};
  placed("spot with a hard edge", spot, spot.position, 0);
  spot.angle = 200, spot.edge = 1, spot.position = {0.7, 0.5, 0.3};
  placed("spot within", spot, spot.position, 0);
  DirectionalLight sun{{1, -2, 0.5}, {3, 2, 1}, 0, ""};
  all.push_back({"beam", sun});
  sun.angle = 0.53;
  all.push_back({"sun", sun});
  sun.angle = 150;
  all.push_back({"half a sky of sun", sun});
  EnvironmentLight environment;
  environment.radiance = {0.5, 1, 2};
  environment.scale = 1.5;
  all.push_back({"environment", environment});
  environment.image = small_sky();
  all.push_back({"image", environment});
  environment.rotation = 100;
  all.push_back({"turned image", environment});
  RectangleLight rectangle{{3, 2, 1}, {0.3, 0, 0.6}, {0, 0.5, 0}, {4, 2, 1}, ""};
  placed("rectangle", rectangle, rectangle.center, 0.42);
  rectangle.center = {1.5, 2.2, 0.3}, rectangle.edge_u = {1, -1, 0},
  rectangle.edge_v = {0.3, 0.3, 1};
  placed("parallelogram nearby", rectangle, rectangle.center, 0.93);
  rectangle.center = {0.5, 1.5, 0.25}, rectangle.edge_u = {0.2, 0, 0},
  rectangle.edge_v = {0, 0.02, 0.1};
  placed("rectangle within", rectangle, rectangle.center, 0.12);
  SphereLight sphere{{-2, 3, 1}, 0.4, {1, 3, 2}, ""};
  placed("sphere", sphere, sphere.center, sphere.radius);
  sphere.center = {0.6, 0.5, 0.3}, sphere.radius = 0.1;
  placed("sphere within", sphere, sphere.center, sphere.radius);
  sphere.center = {1.2, 1.8, 0.25}, sphere.radius = 0.5;
  placed("sphere that reaches in", sphere, sphere.center, sphere.radius);
  return all;
}

struct Lit {
  PreparedScene prepared;
  DirectLights lights;
  Box box;

  explicit Lit(const std::vector<scene::Light>& all, bool periodic = false) {
    Scene scene;
    scene.medium.box_min = {0.25, -1, 3};  // lights are relative to the box's corner
    scene.medium.box_max = scene.medium.box_min + glm::dvec3(1, 2, 0.5);
    scene.medium.majorant_resolution = {1, 1, 1};
    scene.medium.components = {component(scene::Solid{}, 1)};
    if (periodic) scene.medium.sides[0] = scene::Side::periodic;
    scene.lights = all;
    for (scene::Light& light : scene.lights) {
      const glm::dvec3 shift = scene.medium.box_min;
      if (auto* l = std::get_if<scene::PointLight>(&light)) l->position += shift;
      if (auto* l = std::get_if<scene::SpotLight>(&light)) l->position += shift;
      if (auto* l = std::get_if<scene::RectangleLight>(&light)) l->center += shift;
      if (auto* l = std::get_if<scene::SphereLight>(&light)) l->center += shift;
    }
    prepared = prepare(scene, 1);
    lights = {prepared.direct_lights.data(), static_cast<int>(prepared.direct_lights.size())};
    box = std::visit([](const auto& medium) { return medium.whole.box; }, prepared.medium);
  }

  LightSample sample(Vec3f p, std::uint64_t index) const {
    const RandomStream random{7, index, Domain::pixel_sample};
    return lights.sample(p, random.block(3, Purpose::light));
  }
  Photon photon(std::uint64_t index) const {
    const RandomStream random{42, index, Domain::photon};
    return emit({prepared.emitters.data(), static_cast<int>(prepared.emitters.size())}, box,
                random.block(0, Purpose::emission), random.block(0, Purpose::aim));
  }
};

struct Met {
  glm::dvec3 radiance{0};
  double pdf = 0;
  int times = 0;
};
Met meet(const DirectLights& lights, Vec3f from, Vec3f direction, float distance) {
  Met met;
  lights.intersect({from, direction}, distance, [&](Vec3f radiance, float pdf, int) {
    met.radiance += exact(radiance);
    met.pdf += double{pdf};
    ++met.times;
  });
  return met;
}

/// Calls f(bin, direction, solid angle) over the cone of half angle `angle` [radian], in `bins` x
/// `bins` parts of equal angles. Each part has 4n x n points, denser towards the edge.
void over_cone(glm::dvec3 axis, double angle, int bins, int n,
               const std::function<void(int, glm::dvec3, double)>& f) {
  const glm::dvec3 side = glm::normalize(
      glm::cross(axis, std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  const glm::dvec3 up = glm::cross(axis, side);
  const int rows = bins * 4 * n, columns = bins * n;
  for (int i = 0; i < rows; ++i) {
    const double theta = angle * (i + 0.5) / rows, sine = std::sin(theta);
    for (int j = 0; j < columns; ++j) {
      const double phi = 2 * pi_ * (j + 0.5) / columns;
      f(i / (4 * n) * bins + j / n,
        glm::normalize(std::cos(theta) * axis + sine * (std::cos(phi) * side + std::sin(phi) * up)),
        sine * angle / rows * 2 * pi_ / columns);
    }
  }
}

/// A cone slightly larger than the one in which `p` sees a light.
void cone_of(const Case& c, glm::dvec3 p, glm::dvec3& axis, double& angle) {
  axis = {0, 1, 0}, angle = pi_;
  if (c.radius >= 0) {
    const double distance = glm::length(c.center - p);
    axis = glm::normalize(c.center - p);
    if (1.02 * c.radius < distance) angle = std::asin(1.02 * c.radius / distance);
  } else if (const auto* sun = std::get_if<scene::DirectionalLight>(&c.light)) {
    axis = -glm::normalize(sun->direction);
    angle = 1.02 * sun->angle / 2 * pi_ / 180;
  }
}

/// Whether a light is a constant sky, which is never sampled.
bool is_even(const scene::Light& light) {
  const auto* sky = std::get_if<scene::EnvironmentLight>(&light);
  return sky && !sky->image;
}

const glm::dvec3 places[] = {{0.8, 0.3, 0.4}, {0.1, 1.9, 0.05}};

// ---- Samples and hits of lights

TEST(DirectLights, draw_directions_with_the_density_that_rays_meet_them_with) {
  for (const Case& c : cases()) {
    if (is_even(c.light)) continue;
    const Lit lit({c.light});
    if (!lit.lights.any_hit()) continue;
    for (const glm::dvec3& p : places) {
      glm::dvec3 axis;
      double angle = 0;
      cone_of(c, p, axis, angle);
      constexpr int bins = 10, n = 32;
      std::vector<double> expected(bins * bins, 1e-6);  // corners lie between the points
      double sum = 0;
      over_cone(axis, angle, bins, n, [&](int bin, glm::dvec3 direction, double solid_angle) {
        const Met met = meet(lit.lights, rounded(p), rounded(direction), largest_float);
        expected[static_cast<std::size_t>(bin)] += met.pdf * solid_angle;
        sum += met.pdf * solid_angle;
      });
      std::vector<std::int64_t> counts(bins * bins, 0);
      const glm::dvec3 side = glm::normalize(
          glm::cross(axis, std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
      const glm::dvec3 up = glm::cross(axis, side);
      constexpr int samples = 40000;
      int dark = 0;
      for (int k = 0; k < samples; ++k) {
        const LightSample s = lit.sample(rounded(p), static_cast<std::uint64_t>(k));
        if (s.pdf == 0) {  // on the dark side
          EXPECT_EQ(largest(s.irradiance), 0.0f);
          ++dark;
          continue;
        }
        const glm::dvec3 d = exact(s.direction);
        ASSERT_NEAR(glm::length(d), 1, 1e-6);
        const double part = 2 * std::asin(std::min(0.5 * glm::length(d - axis), 1.0)) / angle;
        ASSERT_LT(part, 1 + 1e-6) << c.name;
        const double turn = std::atan2(glm::dot(d, up), glm::dot(d, side)) / (2 * pi_);
        const int i = std::min(static_cast<int>(bins * part), bins - 1),
                  j = static_cast<int>(bins * (turn - std::floor(turn))) % bins;
        ++counts[static_cast<std::size_t>(i * bins + j)];
      }
      if (dark == samples) {
        EXPECT_EQ(sum, 0) << c.name;
        continue;
      }
      EXPECT_EQ(dark, 0) << c.name << ": a flat light shows one side";
      EXPECT_NEAR(sum, 1, 2e-3) << c.name;
      EXPECT_GT(chi_square_test(counts, expected).p, level) << c.name;
    }
  }
}

TEST(DirectLights, that_were_drawn_are_met_where_they_were_drawn) {
  for (const Case& c : cases()) {
    if (is_even(c.light)) continue;
    const Lit lit({c.light});
    const bool is_met = lit.lights.any_hit();
    int missed = 0;
    for (int k = 0; k < 2000; ++k) {
      const glm::dvec3 p = glm::mix(places[0], places[1], k / 2000.0);
      const LightSample s = lit.sample(rounded(p), static_cast<std::uint64_t>(k));
      EXPECT_EQ(s.distance == largest_float, c.radius < 0) << c.name;
      if (!is_met) {
        EXPECT_EQ(s.pdf, 0.0f) << c.name;
        continue;
      }
      if (s.pdf == 0) continue;
      const bool distant = s.distance == largest_float;
      const Met met =
          meet(lit.lights, rounded(p), s.direction, distant ? largest_float : 1.001f * s.distance);
      if (met.times == 0) {  // at the light's edge
        ++missed;
        continue;
      }
      EXPECT_NEAR(met.pdf / double{s.pdf}, 1, 2e-3) << c.name;
      for (int channel = 0; channel < 3; ++channel) {
        const double drawn = exact(s.irradiance)[channel] * double{s.pdf};
        EXPECT_NEAR(met.radiance[channel], drawn, 2e-3 * drawn + 1e-4) << c.name;
      }
      const float before = distant ? 1e30f : 0.998f * s.distance;
      EXPECT_EQ(meet(lit.lights, rounded(p), s.direction, before).times, 0) << c.name;
    }
    EXPECT_LT(missed, 6) << c.name;
  }
}

/// The irradiance of a point from all directions, without occlusion.
glm::dvec3 received(const scene::Light& light, glm::dvec3 p) {
  using namespace scene;
  if (const auto* l = std::get_if<PointLight>(&light))
    return l->power / (4 * pi_ * glm::dot(l->position - p, l->position - p));
  if (const auto* l = std::get_if<SpotLight>(&light)) {
    const glm::dvec3 way = p - l->position;
    const double cosine = glm::dot(glm::normalize(way), glm::normalize(l->direction));
    const double outer = std::cos(l->angle / 2 * pi_ / 180),
                 inner = std::cos(l->angle / 2 * (1 - l->edge) * pi_ / 180);
    const double x = std::clamp((cosine - outer) / (inner - outer + 1e-30), 0.0, 1.0);
    return x * x * (3 - 2 * x) * l->intensity / glm::dot(way, way);
  }
  glm::dvec3 sum(0);
  if (const auto* l = std::get_if<DirectionalLight>(&light)) {
    if (l->angle == 0) return l->irradiance;
    const double half = l->angle / 2 * pi_ / 180;
    return l->irradiance * 2.0 * (1 - std::cos(half)) / (std::sin(half) * std::sin(half));
  }
  if (const auto* l = std::get_if<EnvironmentLight>(&light)) {
    if (!l->image) return 4 * pi_ * l->scale * l->radiance;
    over_cone({0, 1, 0}, pi_, 1, 250, [&](int, glm::dvec3 direction, double solid_angle) {
      sum += solid_angle * l->scale * radiance_of(*l->image, direction, l->rotation);
    });
    return sum;
  }
  if (const auto* l = std::get_if<RectangleLight>(&light)) {
    constexpr int n = 300;
    const glm::dvec3 across = glm::cross(l->edge_u, l->edge_v) / double(n * n);
    for (int k = 0; k < n * n; ++k) {
      const glm::dvec3 way = p
                             - (l->center + ((k % n + 0.5) / n - 0.5) * l->edge_u
                                + ((k / n + 0.5) / n - 0.5) * l->edge_v);
      const double distance = glm::length(way);
      sum += std::max(glm::dot(way, across), 0.0) / std::pow(distance, 3) * l->radiance;
    }
    return sum;
  }
  const auto& l = std::get<SphereLight>(light);
  const double sine = l.radius / glm::length(l.center - p);
  return sine < 1 ? 2 * pi_ * (1 - std::sqrt(1 - sine * sine)) * l.radiance : glm::dvec3(0);
}

TEST(DirectLights, send_what_closed_forms_and_quadrature_say) {
  for (const Case& c : cases()) {
    if (is_even(c.light)) continue;
    const Lit lit({c.light});
    for (const glm::dvec3& p : places) {
      const glm::dvec3 expected = received(c.light, p);
      Series series[3];
      for (int k = 0; k < 20000; ++k) {
        const glm::dvec3 e =
            exact(lit.sample(rounded(p), static_cast<std::uint64_t>(k)).irradiance);
        for (int channel = 0; channel < 3; ++channel) series[channel].add(e[channel]);
      }
      for (int channel = 0; channel < 3; ++channel) {
        const Series& s = series[channel];
        const double error = std::abs(s.mean() - expected[channel]);
        EXPECT_LT(error, 4.5 * s.standard_error() + 1e-4 * expected[channel] + 1e-6)
            << c.name << ": " << s.mean() << ", expected " << expected[channel];
        EXPECT_LE(s.standard_error(), 0.03 * expected[channel]) << c.name;
      }
    }
  }
}

TEST(DirectLights, are_chosen_with_the_chance_that_their_density_has) {
  std::vector<scene::Light> all;
  std::vector<glm::dvec3> expected;
  const glm::dvec3 p = places[0];
  for (const Case& c : cases()) {
    if (is_even(c.light)) continue;
    scene::Light light = c.light;
    std::visit([&](auto& l) { l.group = c.name; }, light);
    all.push_back(light);
    expected.push_back(received(light, p));
  }
  const Lit lit(all);
  ASSERT_EQ(lit.prepared.light_groups.size(), all.size());
  ASSERT_EQ(lit.lights.count, static_cast<int>(all.size()));
  double chances = 0;
  for (const DirectLight& light : lit.prepared.direct_lights) chances += double{light.probability};
  EXPECT_NEAR(chances, 1, 1e-6);
  std::vector<Series> series(all.size());
  for (int k = 0; k < 400000; ++k) {
    const LightSample s = lit.sample(rounded(p), static_cast<std::uint64_t>(k));
    for (std::size_t i = 0; i < all.size(); ++i)
      series[i].add(s.group == static_cast<int>(i) ? double{s.irradiance.y} : 0.0);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (expected[i].y == 0) continue;
    EXPECT_GT(series[i].p_of_mean(expected[i].y), level / 18) << cases()[i].name;
  }
}

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

// ---- Light of photons

// The fluence of unscattered light: the photons' path lengths in a cell, divided by its volume,
// agree with the irradiance at its points.
TEST(Photons, bring_to_every_cell_what_its_points_see_of_the_light) {
  constexpr int n = 3, photons = 60000, points = 4000;
  for (const Case& c : cases()) {
    const Lit lit({c.light});
    const glm::dvec3 extent = exact(lit.box.extent), cell = extent / double(n);
    std::vector<std::array<Series, 3>> brought(n * n * n), seen(n * n * n);
    const double power = lit.prepared.shot_power / (cell.x * cell.y * cell.z);
    int failed = 0;
    for (int k = 0; k < photons; ++k) {
      const Photon photon = lit.photon(static_cast<std::uint64_t>(k));
      ASSERT_LE(largest(photon.weight), 1.0f);
      failed += largest(photon.weight) == 0;
      for (int i = 0; i < n * n * n; ++i) {
        const glm::dvec3 low = cell * glm::dvec3(i % n, i / n % n, i / n / n);
        const double length = length_within(photon.ray, low, low + cell);
        for (int channel = 0; channel < 3; ++channel)
          brought[static_cast<std::size_t>(i)][static_cast<std::size_t>(channel)].add(
              power * length * exact(photon.weight)[channel]);
      }
    }
    EXPECT_LT(failed, 0.7 * photons) << c.name;
    std::vector<double> p;
    for (int i = 0; i < n * n * n; ++i) {
      const glm::dvec3 low = cell * glm::dvec3(i % n, i / n % n, i / n / n);
      // Near a light the variance of the irradiance is infinite.
      const double away = glm::length(c.center - (low + 0.5 * cell)) - 0.5 * glm::length(cell);
      if (c.radius >= 0 && away < 0.1 + c.radius) continue;
      for (int k = 0; k < points; ++k) {
        const RandomStream random{11, static_cast<std::uint64_t>(i * points + k), Domain::matter};
        const RandomBlock r = random.block(0, Purpose::place);
        const Vec3f at = rounded(low + cell * glm::dvec3(uniform(r.a), uniform(r.b), uniform(r.c)));
        const glm::dvec3 e =
            exact(lit.sample(at, static_cast<std::uint64_t>(i * points + k)).irradiance);
        for (int channel = 0; channel < 3; ++channel)
          seen[static_cast<std::size_t>(i)][static_cast<std::size_t>(channel)].add(e[channel]);
      }
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const Series &a = brought[static_cast<std::size_t>(i)][channel],
                     &b = seen[static_cast<std::size_t>(i)][channel];
        const double error = std::hypot(a.standard_error(), b.standard_error());
        if (a.mean() == 0 && b.mean() == 0) continue;
        p.push_back(normal_p((a.mean() - b.mean()) / std::max(error, 1e-5 * b.mean())));
      }
    }
    ASSERT_GT(p.size(), 3u) << c.name;
    EXPECT_GT(bonferroni_p(p), level) << c.name;
  }
}

// The power that is not shot would miss the medium.
TEST(Photons, have_all_the_power_of_a_light_that_was_not_left_out) {
  using namespace scene;
  for (const Case& c : cases()) {
    glm::dvec3 power(0);
    if (const auto* l = std::get_if<PointLight>(&c.light)) power = l->power;
    if (const auto* l = std::get_if<SpotLight>(&c.light)) power = solid_angle(*l) * l->intensity;
    if (const auto* l = std::get_if<RectangleLight>(&c.light)) power = etendue(*l) * l->radiance;
    if (const auto* l = std::get_if<SphereLight>(&c.light)) power = etendue(*l) * l->radiance;
    if (power.x == 0) continue;
    const Lit lit({c.light});
    Series series;
    for (int k = 0; k < 100000; ++k)
      series.add(double{lit.photon(static_cast<std::uint64_t>(k)).weight.x});
    const double shot = lit.prepared.shot_power * series.mean(),
                 error = lit.prepared.shot_power * series.standard_error();
    EXPECT_LT(std::abs(shot + lit.prepared.unshot_power.x - power.x), 4 * error + 1e-3 * power.x)
        << c.name << ": " << shot << " + " << lit.prepared.unshot_power.x << " of " << power.x;
  }
}

TEST(Spots, have_the_power_that_their_intensity_integrates_to) {
  for (const double edge : {0.0, 0.3, 1.0}) {
    scene::SpotLight spot;
    spot.angle = 70;
    spot.edge = edge;
    spot.direction = {0, 0, 1};
    double sum = 0;
    over_cone({0, 0, 1}, 36 * pi_ / 180, 1, 400, [&](int, glm::dvec3 d, double solid_angle) {
      sum += solid_angle * received(spot, d).x;
    });
    EXPECT_NEAR(sum / solid_angle(spot), 1, 2e-3);
  }
}

TEST(DirectLights, between_periodic_sides_are_those_without_images) {
  std::vector<scene::Light> all;
  for (const Case& c : cases()) all.push_back(c.light);
  const Lit lit(all, true);
  for (const DirectLight& light : lit.prepared.direct_lights) EXPECT_TRUE(light.is_distant());
  EXPECT_EQ(lit.lights.count, 6);
  for (const Emitter& e : lit.prepared.emitters) {
    EXPECT_EQ(e.is_apart, e.light.visit([](const auto& light) { return light.is_distant; }));
  }
  EXPECT_EQ(lit.prepared.unshot_power, glm::dvec3(0));
}

TEST(DirectLights, are_those_that_rays_meet_first) {
  const Lit lit({scene::PointLight{}, scene::SphereLight{{2, 2, 2}, 0.1, glm::dvec3(1), ""},
                 scene::DirectionalLight{}, scene::EnvironmentLight{}});
  EXPECT_TRUE(lit.lights.any_hit());
  EXPECT_FALSE(lit.prepared.direct_lights[1].is_delta());
  EXPECT_TRUE(lit.prepared.direct_lights[2].is_delta());
  EXPECT_FALSE(Lit({scene::PointLight{}, scene::DirectionalLight{}}).lights.any_hit());
  EXPECT_EQ(lit.prepared.light_groups, std::vector<std::string>{""});
}

TEST(DirectLights, that_are_the_same_from_everywhere_are_met_and_never_asked) {
  scene::EnvironmentLight sky;
  sky.radiance = {1, 2, 3};
  const Lit alone({sky});
  EXPECT_TRUE(alone.lights.any_hit());
  EXPECT_FALSE(alone.lights.any_sampled());
  const Lit lit(
      {scene::PointLight{}, sky, scene::DirectionalLight{{0, -1, 0}, glm::dvec3(1), 2, ""}});
  EXPECT_TRUE(lit.lights.any_sampled());
  Vec3f met{0, 0, 0};
  lit.lights.intersect({{0, 0, 0}, {0, -1, 0}}, largest_float, [&](Vec3f radiance, float pdf, int) {
    EXPECT_EQ(pdf, 0.0f) << "all of it is found by chance";
    met = met + radiance;
  });
  EXPECT_EQ(met.z, 3.0f);
  for (int k = 0; k < 10000; ++k) {
    const LightSample s = lit.sample({0.2f, 0.3f, 0.4f}, static_cast<std::uint64_t>(k));
    EXPECT_TRUE(std::isfinite(s.irradiance.x));
    EXPECT_TRUE(s.distance < 100 || s.direction.y > 0.9f);
  }
}

TEST(DirectLights, never_give_what_is_no_number) {
  for (const Case& c : cases()) {
    if (is_even(c.light)) continue;
    const Lit lit({c.light});
    for (int k = 0; k < 300; ++k) {
      const Vec3f p = rounded(c.center + (k % 3 == 0 ? 0.0 : std::pow(10.0, -k / 10)) * places[0]);
      LightSample s = lit.sample(p, static_cast<std::uint64_t>(k));
      EXPECT_TRUE(std::isfinite(s.pdf * s.pdf) && std::isfinite(largest(s.irradiance))
                  && std::isfinite(s.distance) && std::isfinite(length(s.direction)))
          << c.name << " " << k;
      if (largest(s.irradiance) == 0) continue;
      const Met met = meet(lit.lights, p, s.direction, largest_float);
      EXPECT_TRUE(std::isfinite(met.pdf * met.pdf) && std::isfinite(met.radiance.x)) << c.name;
    }
  }
}

// ---- Images of the sky

TEST(Skies, lie_around_the_scene_as_declared) {
  std::vector<Vec3f> texels(8 * 4, Vec3f{0, 0, 0});
  const auto at = [&](int row, int column) -> Vec3f& {
    return texels[static_cast<std::size_t>(8 * row + column)];
  };
  for (int i = 0; i < 8; ++i) at(0, i) = {5, 5, 5};       // the top
  at(1, 3) = at(1, 4) = at(2, 3) = at(2, 4) = {1, 0, 0};  // the middle
  at(1, 1) = at(1, 2) = at(2, 1) = at(2, 2) = {0, 1, 0};  // a quarter to the left
  scene::EnvironmentLight light;
  light.image = std::make_shared<const Image>(8, 4, texels);
  const auto seen = [&](Vec3f direction) {
    const Lit lit({light});
    return meet(lit.lights, {0.5f, 0.5f, 0.2f}, direction, largest_float).radiance;
  };
  EXPECT_EQ(seen({0, 1, 0}), glm::dvec3(5));
  EXPECT_EQ(seen({0, -1, 0}), glm::dvec3(0));
  EXPECT_NEAR(seen({0, 0, 1}).x, 1, 1e-5);
  EXPECT_NEAR(seen({1, 0, 0}).y, 1, 1e-5);
  EXPECT_NEAR(glm::length(seen({-1, 0, 0})), 0, 1e-5);
  EXPECT_NEAR(glm::length(seen({0, 0, -1})), 0, 1e-5);
  light.rotation = 90;  // turns +z to +x
  EXPECT_NEAR(seen({1, 0, 0}).x, 1, 1e-5);
  EXPECT_NEAR(seen({0, 0, -1}).y, 1, 1e-5);
}

TEST(Skies, of_one_colour_are_environments) {
  scene::EnvironmentLight light;
  light.image = std::make_shared<const Image>(7, 3, std::vector<Vec3f>(21, Vec3f{2, 1, 4}));
  const Lit lit({light});
  for (int k = 0; k < 1000; ++k) {
    const RandomStream random{1, static_cast<std::uint64_t>(k), Domain::photon};
    const RandomBlock r = random.block(0, Purpose::aim);
    const Vec3f d = direction_in_cone({0, 1, 0}, 2, uniform(r.a), uniform(r.b));
    const glm::dvec3 seen = meet(lit.lights, {0, 0, 0}, d, largest_float).radiance;
    EXPECT_NEAR(seen.x, 2, 1e-6);
    EXPECT_NEAR(seen.z, 4, 2e-6);
  }
}

TEST(Skies, of_one_texel_and_of_black_are_no_trouble) {
  scene::EnvironmentLight light;
  light.image = std::make_shared<const Image>(1, 1, std::vector<Vec3f>{{1, 2, 3}});
  const Lit one({light});
  EXPECT_NEAR(meet(one.lights, {0, 0, 0}, {0.6f, 0, 0.8f}, largest_float).radiance.y, 2, 1e-6);
  EXPECT_GT(one.sample({0, 0, 0}, 5).pdf, 0.0f);
  light.image = std::make_shared<const Image>(2, 2, std::vector<Vec3f>(4, Vec3f{0, 0, 0}));
  const Lit black({light});
  EXPECT_EQ(black.lights.count, 0);
  EXPECT_TRUE(black.prepared.emitters.empty());
}

// The rounding of the table neither loses nor moves the photons of a bright texel in the dark.
TEST(Skies, draw_a_single_bright_texel_of_many) {
  std::vector<Vec3f> texels(256 * 128, Vec3f{1e-3f, 1e-3f, 1e-3f});
  texels[40 * 256 + 100] = {5e4f, 4e4f, 3e4f};
  scene::EnvironmentLight light;
  light.image = std::make_shared<const Image>(256, 128, texels);
  const Lit lit({light});
  int bright = 0;
  for (int k = 0; k < 1000; ++k)
    bright += largest(lit.sample({0, 0, 0}, static_cast<std::uint64_t>(k)).irradiance) > 1;
  EXPECT_GT(bright, 980);
}

TEST(Images, mend_and_count_what_is_no_radiance) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const Image image(2, 2, {{1, nan, 2}, {-1, 0, 0}, {0, infinity, 0}, {3, 4, 5}});
  EXPECT_EQ(image.mended(), 3u);
  EXPECT_EQ(image.texels()[0].y, 0.0f);
  EXPECT_EQ(image.texels()[1].x, 0.0f);
  EXPECT_EQ(image.texels()[2].y, Image::largest_texel);
  EXPECT_NE(image.hash(), Image(4, 1, image.texels()).hash());
  EXPECT_EQ(image.hash(), Image(2, 2, image.texels()).hash());
}

}  // namespace
}  // namespace tyndall::test
