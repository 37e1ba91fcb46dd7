/// \file
/// Preparation of a scene for the walks.
#include "tyndall/render/prepare.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include <glm/ext/matrix_transform.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double pi = std::numbers::pi;

Box box_of(const PreparedScene& scene) {
  return std::visit([](const auto& medium) { return medium.whole.box; }, scene.medium);
}

scene::Component ball(glm::dvec3 center, double radius, double extinction) {
  return component(scene::Solid{scene::Sphere{center, radius}}, extinction);
}

void expect_near(Vec3f a, glm::dvec3 b, double tolerance = 1e-6) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

/// The probability of choosing an emitter.
double share(const PreparedScene& scene, std::size_t i) {
  const double before = i == 0 ? 0 : scene.emitters[i - 1].last_word + 1.0;
  return (scene.emitters[i].last_word + 1.0 - before) * 0x1p-32;
}

/// The power of all photons [W], by colour.
glm::dvec3 mean_power(const PreparedScene& scene) {
  glm::dvec3 sum(0);
  for (std::size_t i = 0; i < scene.emitters.size(); ++i) {
    const Vec3f w = scene.emitters[i].weight;
    sum += scene.shot_power * share(scene, i) * glm::dvec3(w.x, w.y, w.z);
  }
  return sum;
}

// ---- Components

TEST(Prepare, sorts_components_by_their_largest_extinction_and_knows_their_places) {
  scene::DenseGrid grid;  // dense itself: 3 x 100
  grid.values = {100};
  const Scene scene =
      furnace({component(scene::Solid{}, 50, 0.5), component(grid, 3, 0.25),
               component(low_variation(4), 1e-3, 0.75), component(scene::Solid{}, 50, 0.125)});
  const PreparedScene prepared = prepare(scene, 0);
  EXPECT_EQ(prepared.scene_component, (std::vector<int>{2, 0, 3, 1}));
  const auto& medium = std::get<MixedMedium>(prepared.medium);
  for (int i = 0; i < 4; ++i) {
    const auto& written =
        scene.medium.components[static_cast<std::size_t>(prepared.scene_component[i])];
    EXPECT_EQ(medium.component(i).extinction, static_cast<float>(written.extinction));
    EXPECT_EQ(medium.component(i).albedo.x, static_cast<float>(written.albedo.x));
  }
}

TEST(Prepare, a_single_component_has_a_medium_of_its_own_type) {
  const auto medium = [](scene::Field field) {
    return prepare(furnace({component(std::move(field), 2)}), 0).medium.index();
  };
  EXPECT_EQ(medium(scene::Solid{}), AnyMedium(SingleMedium<Solid>{}).index());
  EXPECT_EQ(medium(low_variation(3)), AnyMedium(SingleMedium<NoiseCloud>{}).index());
  EXPECT_EQ(medium(random_grid(2, 2, 2, 1)), AnyMedium(SingleMedium<DenseGrid>{}).index());
}

// ---- Space

TEST(Prepare, local_space_begins_at_the_corner_of_the_box) {
  Scene scene = furnace({ball({4.5, -2, 7.5}, 0.25, 3)});
  scene.medium.box_min = {4, -3, 7};
  scene.medium.box_max = {5, -1, 8};
  scene.lights = {scene::PointLight{{4.5, 0.5, 6.5}, glm::dvec3(1)}};
  scene.camera.position = {4, -3, 2};
  const PreparedScene prepared = prepare(scene, 0);
  expect_near(box_of(prepared).extent, {1, 2, 1}, 0);
  expect_near(prepared.emitters[0].light.as<lights::Point>().position, {0.5, 3.5, -0.5}, 0);
  expect_near(prepared.camera.position, {0, 0, -5}, 0);
  EXPECT_EQ(sigma_t_at(prepared, {0.5f, 1.0f, 0.5f}), 3.0f);
  EXPECT_EQ(sigma_t_at(prepared, {0.5f, 1.2f, 0.5f}), 3.0f);
  EXPECT_EQ(sigma_t_at(prepared, {0.5f, 1.3f, 0.5f}), 0.0f);
}

TEST(Prepare, transforms_lead_from_field_space_to_world_space) {
  Scene scene = furnace({ball({0.25, 0.5, 0.125}, 0.05, 3)});
  scene.medium.box_min = {-2, -2, -2};
  scene.medium.box_max = {2, 2, 2};
  glm::dmat4 m = glm::translate(glm::dmat4(1), {0.5, 0.75, -1});
  m = glm::rotate(m, pi / 2, {0, 0, 1});  // x to y, y to -x
  m = glm::scale(m, {2, 1, 4});
  m[2][0] = 0.5;  // sheared
  scene.medium.components[0].transform = m;
  const glm::dvec3 center(m * glm::dvec4(0.25, 0.5, 0.125, 1));
  EXPECT_NEAR(center.x, 0.5 - 0.5 + 0.5 * 0.125, 1e-12);  // see the comments above
  EXPECT_NEAR(center.y, 0.75 + 0.5, 1e-12);
  EXPECT_NEAR(center.z, -1 + 0.5, 1e-12);
  const PreparedScene prepared = prepare(scene, 0);
  const auto inside = [&](glm::dvec3 offset) {
    const glm::dvec3 p = center + glm::dvec3(glm::dmat3(m) * offset) - scene.medium.box_min;
    return sigma_t_at(prepared,
                      {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)})
           > 0;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      glm::dvec3 offset(0);
      offset[axis] = side * 0.0495;
      EXPECT_TRUE(inside(offset));
      offset[axis] = side * 0.0505;
      EXPECT_FALSE(inside(offset));
    }
  }
}

TEST(Prepare, the_camera_sees_its_field_of_view_across_the_width) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.camera.position = {0.5, 0.5, -2};
  scene.camera.look_at = {0.5, 0.5, 9};
  scene.camera.fov = 90;
  scene.camera.resolution = {64, 16};
  const PreparedScene prepared = prepare(scene, 0);
  const double h = std::sqrt(0.5);
  expect_near(prepared.camera.ray(0.5f, 0.5f).direction, {0, 0, 1});
  expect_near(prepared.camera.ray(0, 0.5f).direction, {h, 0, h});  // left is +x, looking along +z
  expect_near(prepared.camera.ray(1, 0.5f).direction, {-h, 0, h});
  expect_near(prepared.camera.ray(0.5f, 0).direction, glm::normalize(glm::dvec3(0, 0.25, 1)));
  EXPECT_EQ(prepared.film_width, 64);
  EXPECT_EQ(prepared.film_height, 16);
}

// ---- Lights

TEST(Lights, a_beam_brings_its_irradiance_times_the_box_as_it_sees_it) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.medium.box_max = {1, 2, 3};
  const glm::dvec3 direction(2, -3, 6), irradiance(2, 4, 1);  // length 7
  scene.lights = {scene::DirectionalLight{direction, irradiance}};
  const PreparedScene prepared = prepare(scene, 0);
  ASSERT_EQ(prepared.emitters.size(), 3);  // the faces -x, +y, -z
  constexpr Face faces[] = {0, 3, 4};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(prepared.emitters[i].light.as<lights::Parallel>().face, faces[i]);
  const double seen = (2.0 * 6 + 3.0 * 3 + 6.0 * 2) / 7;
  EXPECT_NEAR(prepared.shot_power, 4 * seen, 1e-6);
  EXPECT_NEAR(share(prepared, 1), 9.0 / 33, 1e-9);
  const glm::dvec3 power = mean_power(prepared);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(power[c], irradiance[c] * seen, 1e-6);
  EXPECT_EQ(prepared.background.x, 0.0f);  // no camera sees the light
}

TEST(Lights, an_environment_brings_pi_times_its_radiance_times_the_open_faces) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.medium.box_max = {1, 2, 3};
  scene.medium.sides[1] = scene::Side::periodic;
  scene.lights = {scene::EnvironmentLight{{0.5, 0.25, 2}}};
  scene.background = {1, 2, 3};
  const PreparedScene prepared = prepare(scene, 0);
  EXPECT_EQ(prepared.emitters.size(), 4);
  EXPECT_NEAR(prepared.shot_power, 2 * pi * 2 * (6 + 2), 1e-5);
  EXPECT_NEAR(mean_power(prepared).y, 0.25 * pi * 2 * (6 + 2), 1e-5);
  expect_near(prepared.background, {1, 2, 3});  // rays also hit the environment
  ASSERT_EQ(prepared.direct_lights.size(), 1);
  expect_near(prepared.direct_lights[0].light.as<lights::ConstantEnvironment>().radiance,
              {0.5, 0.25, 2});
}

TEST(Lights, a_point_light_shoots_only_into_the_cone_about_the_box) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  const glm::dvec3 power(3, 1, 2), position(0.5, 0.5, -3.5);
  scene.lights = {scene::PointLight{position, power}};
  const PreparedScene prepared = prepare(scene, 0);
  const double sine = std::sqrt(0.75) / 4, solid_angle = 0.5 * (1 - std::sqrt(1 - sine * sine));
  EXPECT_NEAR(prepared.shot_power, 3 * solid_angle, 3e-5);
  EXPECT_GE(prepared.shot_power, 3 * solid_angle);  // never too narrow a cone
  expect_near(prepared.emitters[0].light.as<lights::Point>().cone.axis, {0, 0, 1});
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean_power(prepared)[c] + prepared.unshot_power[c], power[c], 1e-6);
  }

  scene.lights = {scene::PointLight{{0.1, 0.2, 0.3}, power}};  // within the box
  EXPECT_EQ(prepare(scene, 0).shot_power, 3);
  scene.lights = {scene::PointLight{position, power}};  // an infinite medium
  scene.medium.sides[0] = scene::Side::periodic;
  EXPECT_EQ(prepare(scene, 0).shot_power, 3);
}

TEST(Lights, are_chosen_in_proportion_to_the_power_of_their_photons) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  const glm::dvec3 within(0.5);
  scene.lights = {scene::PointLight{within, {1, 0.5, 0}}, scene::PointLight{within, glm::dvec3(0)},
                  scene::PointLight{within, {0, 2, 5}}, scene::PointLight{within, {2, 2, 2}}};
  const PreparedScene prepared = prepare(scene, 0);
  ASSERT_EQ(prepared.emitters.size(), 3);  // no emitter for the black light
  EXPECT_NEAR(share(prepared, 0), 1.0 / 8, 1e-9);
  EXPECT_NEAR(share(prepared, 1), 5.0 / 8, 1e-9);
  EXPECT_NEAR(share(prepared, 2), 2.0 / 8, 1e-9);
  EXPECT_EQ(prepared.emitters.back().last_word, 0xffffffffu);  // every word chooses one
  expect_near(prepared.emitters[1].weight, {0, 0.4, 1}, 1e-7);
  EXPECT_EQ(prepared.shot_power, 8);
}

// ---- Scales and defaults

TEST(Prepare, the_film_counts_in_powers_of_two_near_the_brightest_light) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  for (const double radiance : {1e-9, 1.0, 3.0, 1e9}) {
    scene.lights = {scene::EnvironmentLight{glm::dvec3(radiance)}};
    const float unit = prepare(scene, 0).film_unit;
    EXPECT_EQ(unit, std::exp2(std::round(std::log2(unit))));
    EXPECT_GE(unit, radiance / 2);
    EXPECT_LE(unit, 2 * radiance);
  }
}

TEST(Prepare, matter_is_scaled_to_use_forty_bits_and_no_more) {
  for (const double extinction : {1e-6, 0.7, 1.0, 900.0, 1e12}) {
    const PreparedScene prepared = prepare(
        furnace({component(scene::Solid{}, extinction), component(scene::Solid{}, extinction)}), 0);
    const double largest = 2 * extinction * prepared.matter_scale;
    EXPECT_LE(largest, 0x1p40);
    EXPECT_GE(largest, 0x1p38);
  }
}

TEST(Prepare, the_illumination_grid_has_the_harmonics_that_the_phase_functions_need) {
  const auto order = [](scene::Phase phase, int asked = -1) {
    Scene scene = furnace({component(scene::Solid{}, 1), component(scene::Solid{}, 1, 1, phase)});
    scene.illumination_order = asked;
    return prepare(scene, 0).cells.order;
  };
  EXPECT_EQ(order(scene::IsotropicPhase{}), 0);
  EXPECT_EQ(order(scene::HenyeyGreensteinPhase{0}), 0);
  EXPECT_EQ(order(scene::HenyeyGreensteinPhase{0.1}), 2);
  EXPECT_EQ(order(scene::RayleighPhase{}), 2);
  EXPECT_EQ(order(scene::RayleighPhase{}, 0), 0);
  EXPECT_EQ(order(scene::IsotropicPhase{}, 1), 1);
}

// About as many points as a 256^3 grid has cells, but 3 to 8 along each axis of a cell.
TEST(Prepare, matter_is_measured_at_enough_points_of_every_cell) {
  const auto strata = [](int nx, int ny, int nz) {
    Scene scene = furnace({component(scene::Solid{}, 1)});
    scene.illumination_resolution = {nx, ny, nz};
    return prepare(scene, 0).strata;
  };
  EXPECT_EQ(strata(64, 64, 64), 4);
  EXPECT_EQ(strata(16, 48, 16), 5);
  EXPECT_EQ(strata(1, 1, 1), 8);
  EXPECT_EQ(strata(512, 1, 1), 3);
}

TEST(Prepare, ray_marching_steps_are_the_finest_voxel_unless_told) {
  Scene scene = furnace({component(low_variation(5), 1), component(random_grid(4, 100, 4, 1), 1)});
  scene.medium.components[1].transform = glm::scale(glm::dmat4(1), glm::dvec3(5, 2, 5));
  scene.sampler = scene::Sampler::ray_marching;
  EXPECT_FLOAT_EQ(std::get<RayMarching>(prepare(scene, 0).sampler).step, 0.02f);
  scene.medium.components.pop_back();
  EXPECT_FLOAT_EQ(std::get<RayMarching>(prepare(scene, 0).sampler).step, 1.0f / 32);
  scene.medium.components[0].transform = glm::scale(glm::dmat4(1), glm::dvec3(1e-9));
  EXPECT_GE(std::get<RayMarching>(prepare(scene, 0).sampler).step, 4e-7f) << "it would stand still";
  scene.marching_step = 0.3;
  EXPECT_FLOAT_EQ(std::get<RayMarching>(prepare(scene, 0).sampler).step, 0.3f);
}

TEST(Prepare, tells_of_its_progress_and_stops_when_told) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  std::vector<double> seen;
  prepare(scene, 0, [&](double done) { seen.push_back(done); });
  EXPECT_GE(seen.size(), 10);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_LT(seen.back(), 1);
  std::atomic<int> calls = 0;
  EXPECT_THROW(prepare(scene, 2, {}, [&] { return ++calls >= 3; }), Stopped);
  EXPECT_LE(calls, 4);
}

TEST(Prepare, chooses_more_super_voxels_for_what_varies_more) {
  const auto chosen = [](scene::Field field, double extinction) {
    Scene scene = furnace({component(std::move(field), extinction)});
    scene.medium.majorant_resolution = {0, 0, 0};
    const MajorantTables t = prepare(scene, 0).tables;
    EXPECT_EQ(t.nx, t.ny);
    EXPECT_EQ(t.nx, t.nz);
    return t.nx;
  };
  EXPECT_EQ(chosen(scene::Solid{}, 100), 4) << "nothing varies";
  const int soft = chosen(low_variation(8), 128), hard = chosen(high_variation(8), 539);
  EXPECT_GT(soft, 15);
  EXPECT_LT(soft, 32);
  EXPECT_GT(hard, 32);
  EXPECT_LT(chosen(low_variation(8), 10), soft) << "thin";
}

TEST(Prepare, chosen_super_voxels_are_cubes_and_given_ones_are_kept) {
  Scene scene = furnace({component(low_variation(8), 128)});
  scene.medium.majorant_resolution = {0, 0, 0};
  scene.medium.box_max = {4, 1, 0.5};
  MajorantTables t = prepare(scene, 0).tables;
  EXPECT_NEAR(t.nx / 4.0, t.ny, 1.5);
  EXPECT_NEAR(t.ny / 2.0, t.nz, 1.5);
  scene.medium.majorant_resolution = {0, 7, 0};
  const int nx = t.nx, nz = t.nz;
  t = prepare(scene, 0).tables;
  EXPECT_EQ(t.nx, nx);
  EXPECT_EQ(t.ny, 7);
  EXPECT_EQ(t.nz, nz);
}

TEST(Prepare, bounds_of_the_whole_are_the_extremes_of_the_super_voxels) {
  const PreparedScene prepared =
      prepare(furnace({component(low_variation(4), 7), component(random_grid(3, 3, 3, 5), 2)}), 0);
  const MajorantTables& t = prepared.tables;
  const std::size_t cells = t.total.size();
  ASSERT_EQ(cells, 16 * 16 * 16);
  for (std::size_t c = 0; c < 2; ++c) {
    float upper = 0, lower = largest_float;
    for (std::size_t i = c * cells; i < (c + 1) * cells; ++i) {
      upper = std::max(upper, t.upper[i]);
      lower = std::min(lower, t.lower[i]);
      EXPECT_LE(t.lower[i], t.upper[i]);
    }
    EXPECT_EQ(upper, t.whole_upper[c]);
    EXPECT_EQ(lower, t.whole_lower[c]);
  }
  for (std::size_t i = 0; i < cells; ++i) EXPECT_EQ(t.total[i], t.upper[i] + t.upper[cells + i]);
  EXPECT_EQ(t.whole_total[0], t.whole_upper[0] + t.whole_upper[1]);
}

}  // namespace
}  // namespace tyndall::test
