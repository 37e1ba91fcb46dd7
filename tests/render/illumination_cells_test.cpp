/// \file
/// The default number of cells of the illumination grid.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/random.h"
#include "support/scenes.h"
#include "tyndall/render/check.h"

namespace tyndall::test {
namespace {

TEST(IlluminationCells, follow_the_mean_free_path_within_limits) {
  Scene scene = furnace({component(high_variation(8), 140)});
  scene.medium.box_max = {1, 0.5, 0.25};
  scene.illumination_resolution = {0, 0, 0};
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{80, 40, 20}));
  scene.medium.components[0].extinction = 1;
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{64, 32, 16}));
  scene.medium.components[0].extinction = 1000;
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{128, 64, 32}));
  scene.illumination_resolution = {7, 0, 9};
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{7, 64, 9}));
  scene.medium.components[0].albedo = glm::dvec3(0);  // deposits no light
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{7, 32, 9}));
}

TEST(IlluminationCells, of_many_mean_free_paths_are_warned_of) {
  Scene scene = furnace({component(high_variation(8), 1000)});
  const auto warned = [&] {
    const auto warnings = check(scene).warnings;
    return std::any_of(warnings.begin(), warnings.end(), [](const Problem& p) {
      return p.path == "photons.illumination.resolution";
    });
  };
  scene.illumination_resolution = {0, 0, 0};
  scene.medium.components[0].extinction = 200;
  scene.bounces = 1;
  EXPECT_FALSE(warned()) << "1.75 mean free paths: 2.7 %";
  scene.bounces = 0;
  EXPECT_TRUE(warned()) << "7.3 %";
  scene.bounces = 2;
  scene.medium.components[0].extinction = 400;
  EXPECT_TRUE(warned()) << "3.1 mean free paths: 3.6 %";
  scene.bounces = 3;
  EXPECT_FALSE(warned()) << "2 %";
  scene.bounces.reset();
  EXPECT_FALSE(warned()) << "the same";
  scene.medium.components[0].extinction = 1100;
  EXPECT_TRUE(warned()) << "8.6 mean free paths";
  scene.medium.components[0].extinction = 400;
  scene.bounces = 1;
  EXPECT_TRUE(warned());
  scene.medium.components[0].phase = scene::HenyeyGreensteinPhase{0.85};
  EXPECT_FALSE(warned()) << "of transport 0.47";
  scene.medium.components[0].phase = {};
  scene.integrator = scene::Integrator::path;
  EXPECT_FALSE(warned());
}

bool warns_of(const Scene& scene, const std::string& path) {
  const auto warnings = check(scene).warnings;
  return std::any_of(warnings.begin(), warnings.end(),
                     [&](const Problem& p) { return p.path == path; });
}

TEST(IlluminationCells, are_judged_by_where_most_of_the_extinction_is) {
  scene::DenseGrid grid;
  grid.size = {10, 10, 10};
  grid.values.assign(1000, 1.0f);
  Scene scene = furnace({component(grid, 100)});  // cells of 1/16
  scene.bounces = 0;
  EXPECT_TRUE(warns_of(scene, "photons.illumination.resolution")) << "6.3 mean free paths";
  scene.medium.components[0].extinction = 10;
  EXPECT_FALSE(warns_of(scene, "photons.illumination.resolution")) << "0.6 mean free paths";
  std::get<scene::DenseGrid>(scene.medium.components[0].field).values[0] = 100;
  EXPECT_FALSE(warns_of(scene, "photons.illumination.resolution")) << "but for a single voxel";
  auto& values = std::get<scene::DenseGrid>(scene.medium.components[0].field).values;
  std::fill(values.begin(), values.begin() + 20, 100.0f);
  EXPECT_TRUE(warns_of(scene, "photons.illumination.resolution")) << "two thirds of it";
  values.assign(1000, 0.0f);
  EXPECT_FALSE(warns_of(scene, "photons.illumination.resolution"));
}

TEST(IlluminationCells, may_be_wide_where_nothing_varies) {
  Scene scene = slab(40, 0.99);  // in 1 x 1 x 64 cells
  scene.bounces = 0;
  EXPECT_FALSE(warns_of(scene, "photons.illumination.resolution"));
  scene.medium.components[0].field =
      scene::Solid{scene::Cuboid{{0, 0, 0.25}, {1, 1, 0.75}}};  // nor does this one across z
  EXPECT_FALSE(warns_of(scene, "photons.illumination.resolution"));
  Scene lit = scene;
  lit.lights.push_back(scene::PointLight{{0.5, 0.5, -1}, glm::dvec3(1)});
  EXPECT_TRUE(warns_of(lit, "photons.illumination.resolution")) << "the light varies";
  Scene lump = scene;
  lump.medium.components[0].field = scene::Solid{scene::Cuboid{{0.5, 0, 0.25}, {1, 1, 0.75}}};
  EXPECT_TRUE(warns_of(lump, "photons.illumination.resolution")) << "the matter varies along x";
  Scene open = scene;
  open.medium.sides[1] = scene::Side::open;
  EXPECT_TRUE(warns_of(open, "photons.illumination.resolution")) << "light leaves along y";
  scene.medium.components[0].extinction = 600;
  EXPECT_TRUE(warns_of(scene, "photons.illumination.resolution")) << "it varies along z";
}

TEST(IlluminationCells, are_fine_across_slabs_and_one_along_them) {
  Scene scene = slab(100, 1);
  scene.illumination_resolution = {0, 0, 0};
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{1, 1, 500}));
  EXPECT_EQ(resolved(scene).bounces, 1);
  scene.medium.components[0].extinction = 2;
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{1, 1, 64}));
  scene.medium.components[0].extinction = 1e4;
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{1, 1, 1024}));
  scene.lights.push_back(scene::PointLight{{0.5, 0.5, -1}, glm::dvec3(1)});
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{128, 128, 128}));
}

TEST(IlluminationCells, ask_for_bounces_where_they_are_wide) {
  Scene scene = slab(100, 1);
  scene.medium.sides = {};
  scene.illumination_resolution = {0, 0, 0};
  const auto bounces_at = [&](double extinction, const scene::Phase& phase) {
    scene.medium.components[0].extinction = extinction;
    scene.medium.components[0].phase = phase;
    return resolved(scene).bounces;
  };
  const auto expect_bounces = [&](int of_noise, int of_solid, double extinction,
                                  const scene::Phase& phase) {
    scene.medium.components[0].field = low_variation(6);
    EXPECT_EQ(bounces_at(extinction, phase), of_noise);
    scene.medium.components[0].field = scene::Solid{};
    EXPECT_EQ(bounces_at(extinction, phase), of_solid);
  };
  expect_bounces(1, 1, 10, {});
  expect_bounces(1, 1, 34, {});  // 64 cells of 0.53 mean free paths
  expect_bounces(1, 2, 36, {});
  expect_bounces(1, 5, 57, {});  // 0.89
  expect_bounces(2, 5, 59, {});
  expect_bounces(3, 16, 100, {});                                   // 1.56
  expect_bounces(1, 4, 100, scene::HenyeyGreensteinPhase{0.5});     // of transport 0.78
  expect_bounces(2, 8, 100, scene::TwoLobesPhase{0.9, -0.1, 0.4});  // of transport 1.09
  expect_bounces(3, 16, 100, scene::HenyeyGreensteinPhase{-0.5});
  scene.bounces = 0;
  EXPECT_EQ(bounces_at(100, {}), 0);
  scene.bounces.reset();
  scene.medium.components[0].albedo = glm::dvec3(0);
  EXPECT_EQ(bounces_at(1000, {}), 1) << "no light to be read";
}

/// Two balls at a distance.
Scene balls(double distance) {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.5}}, 40),
                         component(scene::Solid{scene::Sphere{{0, 0, 0}, 0.5}}, 40)});
  scene.medium.components[1].transform[3] = {distance + 0.5, 0.5, 0.5, 1};
  scene.medium.box_max = {distance + 1, 1, 1};
  scene.illumination_resolution = {0, 0, 0};
  return scene;
}

TEST(IlluminationCells, are_stored_where_matter_is_in_a_box_that_is_nearly_empty) {
  Scene scene = balls(1000);
  const IlluminationPlan plan = resolved(scene).illumination;
  EXPECT_TRUE(plan.is_sparse);
  // The volume of both balls is 1.047. 64 cells along the edge of such a cube are finer than 1.75
  // mean free paths.
  EXPECT_EQ(plan.cells, (std::array{63087, 64, 64}));
  EXPECT_LT(plan.stored, 3000000u);
  EXPECT_FALSE(warns_of(scene, "photons.illumination.resolution"));
  EXPECT_LT(resolved(scene).memory(), 3000000000u);
  scene.medium.components[0].extinction = 140;
  EXPECT_EQ(resolved(scene).illumination.cells, (std::array{80080, 80, 80}));
  EXPECT_TRUE(resolved(balls(100)).illumination.is_sparse);
  EXPECT_FALSE(resolved(balls(5)).illumination.is_sparse) << "filled by an eighth and more";

  Scene given = balls(1000);
  given.illumination_resolution = {128, 1, 1};
  EXPECT_FALSE(resolved(given).illumination.is_sparse);
  EXPECT_TRUE(warns_of(given, "photons.illumination.resolution"));
  Scene alone = furnace({component(scene::Solid{scene::Sphere{{1, 1, 1}, 0.5}}, 0.01)});
  alone.illumination_resolution = {0, 0, 0};
  alone.medium.box_max = {3, 3, 3};
  EXPECT_FALSE(resolved(alone).illumination.is_sparse) << "a dense grid does as well";
  alone.medium.components[0].extinction = 400;
  EXPECT_TRUE(resolved(alone).illumination.is_sparse)
      << "its cells would be 9 mean free paths wide";
  Scene fog = balls(1000);
  fog.medium.components.push_back(component(scene::Solid{}, 1e-3));
  EXPECT_FALSE(resolved(fog).illumination.is_sparse) << "matter everywhere";
}

TEST(IlluminationCells, hold_all_matter_where_not_all_are_stored) {
  std::vector<Scene> scenes{balls(1000), balls(60)};
  scenes.push_back(balls(300));
  scenes[2].medium.components[0].field = high_variation(6);
  scenes[2].medium.components[1].transform[3] = {299.5, 0.5, 0.5, 1};
  Random random(3);
  for (const Scene& scene : scenes) {
    ASSERT_TRUE(resolved(scene).illumination.is_sparse);
    const PreparedScene prepared = prepare(scene, 0);
    const IlluminationCells& cells = prepared.cells;
    ASSERT_LE(cells.count(), most_stored_cells);
    ASSERT_LE(cells.count(), 2 * resolved(scene).illumination.stored);
    int met = 0;
    for (int n = 0; n < 20000; ++n) {
      const double away = n % 2 == 0 ? 0 : scene.medium.box_max.x - 1;
      const Vec3f p{static_cast<float>(away + random(0, 1)), static_cast<float>(random(0, 1)),
                    static_cast<float>(random(0, 1))};
      const std::size_t cell = cells.cell_of(p);
      ASSERT_LT(cell, cells.count());
      if (!(sigma_t_at(prepared, p) > 0)) continue;
      ++met;
      ASSERT_GE(cell, cells.first()) << p.x << " " << p.y << " " << p.z;
      const auto [i, j, k] = cells.place(cell);
      ASSERT_EQ(cells.index(i, j, k), cell);
      ASSERT_NEAR((static_cast<float>(i) + 0.5f) * prepared.cell_size.x, p.x,
                  0.51 * prepared.cell_size.x + 2e-7 * p.x);
      // It also lies in a clump.
      ASSERT_TRUE(std::any_of(prepared.clumps.begin(), prepared.clumps.end(), [&](const Clump& c) {
        const Vec3f q = p - c.low;
        return q.x >= 0 && q.y >= 0 && q.z >= 0 && q.x <= c.size.x && q.y <= c.size.y
               && q.z <= c.size.z;
      }));
    }
    EXPECT_GT(met, 1000);
    EXPECT_GE(prepared.clumps.size(), 2u);
    for (const Clump& clump : prepared.clumps) EXPECT_LT(clump.size.x, 1.5f);
  }
}

}  // namespace
}  // namespace tyndall::test
