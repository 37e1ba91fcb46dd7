/// \file
/// Paths in lanes have the same results as single paths, bit for bit, in every instruction set.
#include "host/lanes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "support/scenes.h"
#include "support/warp.h"
#include "tyndall/render/render.h"

namespace tyndall::test {
namespace {

struct Result {
  Account shot, gathered;
  std::vector<std::int64_t> illumination, matter, detected;
  std::vector<PixelTally> pixels;
};

/// Runs photons [begin, end), the extinction of all cells, and 2 samples of each pixel of the
/// image.
/// \param call (pass, begin, end) -> void
template <class Medium, class Sampler, class Call>
Result run(const PreparedScene& scene, const Medium& medium, const Sampler& sampler,
           std::uint64_t begin, std::uint64_t end, Call&& call) {
  Result result;
  result.illumination.assign(scene.cells.count() * static_cast<std::size_t>(scene.cells.moments()),
                             0);
  result.detected.assign(3 * scene.detectors.count(), 0);
  Detectors detectors = scene.detectors;
  detectors.sums = result.detected.empty() ? nullptr : result.detected.data();
  const IlluminationTally tally{scene.cells, result.illumination.data()};
  call(ShootPass<Medium, Sampler>{.medium = medium,
                                  .sampler = sampler,
                                  .lights = scene.lights(),
                                  .seed = scene.seed,
                                  .illumination = tally,
                                  .accounts = {&result.shot},
                                  .detectors = detectors},
       begin, end);
  result.matter.assign(scene.cells.count(), 0);
  call(MatterPass<Medium>{.medium = medium,
                          .seed = scene.seed,
                          .cells = scene.cells,
                          .cell_size = scene.cell_size,
                          .strata = scene.strata,
                          .scale = scene.matter_scale,
                          .matter = result.matter.data()},
       0, scene.cells.count());
  const std::vector<float> numerator(result.illumination.begin(), result.illumination.end()),
      denominator(result.matter.begin(), result.matter.end());
  result.pixels.resize(static_cast<std::size_t>(scene.film_width * scene.film_height));
  std::int64_t clamped = 0;
  const Film film{scene.film_width, scene.film_height, scene.film_unit, result.pixels.data(),
                  &clamped};
  call(
      GatherPass<Medium, Sampler>{
          .medium = medium,
          .sampler = sampler,
          .camera = scene.camera,
          .illumination = {scene.cells, numerator.data(), denominator.data()},
          .lights = {scene.direct_lights.data(), static_cast<int>(scene.direct_lights.size())},
          .background = scene.background,
          .bounces = scene.bounces,
          .is_apart = scene.is_apart,
          .seed = scene.seed,
          .samples = {0, 2},
          .film = film,
          .accounts = {&result.gathered}},
      0, 2 * film.pixel_count());
  return result;
}

void expect_equal(const Result& lanes, const Result& plain) {
  EXPECT_EQ(lanes.illumination, plain.illumination);
  EXPECT_EQ(lanes.matter, plain.matter);
  EXPECT_EQ(lanes.detected, plain.detected);
  EXPECT_EQ(std::memcmp(lanes.pixels.data(), plain.pixels.data(),
                        plain.pixels.size() * sizeof(PixelTally)),
            0);
  EXPECT_EQ(std::memcmp(&lanes.shot, &plain.shot, sizeof(Account)), 0);
  EXPECT_EQ(std::memcmp(&lanes.gathered, &plain.gathered, sizeof(Account)), 0);
}

/// Runs a pass index by index, for passes without warps.
template <class Pass>
void run_plain(const Pass& pass, std::uint64_t begin, std::uint64_t end) {
  for (std::uint64_t i = begin; i < end; ++i) pass(i);
}

/// Runs paths in emulated warps: first with launches of two turns, which leave lanes at all stages
/// and pause repeatedly, then with long ones.
template <class Pass>
requires has_lanes<Pass>
void run_warp(const Pass& pass, std::uint64_t begin, std::uint64_t end) {
  WarpUses uses{};
  const std::uint64_t half = begin + (end - begin) / 2, together = 2;
  std::uint64_t next = begin;
  for (int launches = 0; next < half && launches < 500;) {
    const auto pause = [&] { return ++launches % 100 == 0; };
    const std::uint64_t done = run_by_warps(pass, next, end, together, 2, 2, pause, uses);
    EXPECT_TRUE(done == end || (done - next) % together == 0) << next << " to " << done;
    next = done;
  }
  const auto never = [] { return false; };
  EXPECT_EQ(run_by_warps(pass, next, end, together, 3, 1000, never, uses), end);
}
template <class Pass>
void run_warp(const Pass& pass, std::uint64_t begin, std::uint64_t end) {
  run_plain(pass, begin, end);
}

/// Expects the same results of single paths, of each instruction set (if no side is periodic), and
/// of an emulated warp. \param photons from `begin`, more or fewer than there are lanes
/// \return the account of the single paths.
Account expect_equal(const Scene& scene, std::uint64_t begin, std::uint64_t photons) {
  const PreparedScene prepared = prepare(scene, 0);
  return std::visit(
      [&](const auto& medium) {
        const auto run_by = [&](auto&& call) {
          return run(prepared, medium, SuperVoxel{}, begin, begin + photons, call);
        };
        const Result plain = run_by([](const auto& pass, std::uint64_t first, std::uint64_t last) {
          run_plain(pass, first, last);
        });
        const Box& box = medium.whole.box;
        if (!box.periodic_x && !box.periodic_y && !box.periodic_z) {
          for (const std::string& isa : instruction_sets()) {
            SCOPED_TRACE(isa);
            expect_equal(run_by([&](const auto& pass, std::uint64_t first, std::uint64_t last) {
                           run_lanes(pass, first, last, {}, isa);
                         }),
                         plain);
          }
        }
        SCOPED_TRACE("warp");
        expect_equal(run_by([](const auto& pass, std::uint64_t first, std::uint64_t last) {
                       run_warp(pass, first, last);
                     }),
                     plain);
        EXPECT_EQ(plain.shot.ledger.shot, static_cast<std::int64_t>(photons));
        EXPECT_GT(plain.gathered.audit.flights, 0);
        return plain.shot;
      },
      prepared.medium);
}

/// Expects the same results of single paths and of a warp of another sampler.
void expect_equal(const Scene& scene, const AnySampler& sampler, std::uint64_t photons) {
  const PreparedScene prepared = prepare(scene, 0);
  std::visit(
      [&](const auto& medium, const auto& how) {
        const Result plain = run(prepared, medium, how, 0, photons,
                                 [](const auto& pass, std::uint64_t first, std::uint64_t last) {
                                   run_plain(pass, first, last);
                                 });
        expect_equal(run(prepared, medium, how, 0, photons,
                         [](const auto& pass, std::uint64_t first, std::uint64_t last) {
                           run_warp(pass, first, last);
                         }),
                     plain);
        EXPECT_GT(plain.shot.audit.real, 0);
      },
      prepared.medium, sampler);
}

Scene lit(scene::Component c) {
  Scene scene = furnace({std::move(c)});
  scene.medium.majorant_resolution = {7, 5, 9};
  scene.illumination_resolution = {12, 12, 12};
  return scene;
}

TEST(Lanes, leave_what_single_photons_leave) {
  const scene::Phase phases[] = {scene::IsotropicPhase{},
                                 scene::HenyeyGreensteinPhase{0.8},
                                 scene::HenyeyGreensteinPhase{-0.05},
                                 scene::RayleighPhase{},
                                 scene::TwoLobesPhase{0.8, -0.05, 0.7},
                                 scene::TabulatedPhase{std::make_shared<scene::PhaseTable>(
                                     scene::PhaseTable{{-1, 0.5, 0.9, 1}, {1, 0.5, 3, 20}})}};
  for (const scene::Phase& phase : phases) {
    EXPECT_GT(expect_equal(lit(component(low_variation(5), 40, 1, phase)), 0, 1000).audit.real, 0);
  }
  expect_equal(lit(component(high_variation(12), 90, 0.9)), 1000000, 1000);
  expect_equal(lit(component(low_variation(5), 20)), 5, 3);
}

TEST(Lanes, know_every_sampler) {
  Scene scene = lit(component(low_variation(5), 30, 0.9));
  scene.medium.sides = {scene::Side::periodic, scene::Side::open, scene::Side::periodic};
  for (const AnySampler sampler : {AnySampler(Woodcock{}), AnySampler(RayMarching{0.1f})}) {
    expect_equal(scene, sampler, 500);
    expect_equal(scene, sampler, 3);
  }
}

TEST(Lanes, know_lenses_filters_and_parts_of_pictures) {
  Scene scene = lit(component(low_variation(5), 40, 0.9));
  scene.camera.aperture_radius = 0.25;
  scene.camera.crop = {3, 5, 14, 15};
  scene.filter = scene::Filter::blackman_harris;
  expect_equal(scene, 0, 10);
}

TEST(Lanes, keep_the_account_of_coloured_light_that_misses_is_absorbed_and_escapes) {
  Scene scene = lit(component(low_variation(6), 30, 1));
  scene.medium.components[0].albedo = {0.99, 0.8, 0.5};
  scene.lights = {scene::PointLight{{1.5, 1.8, -0.5}, {3, 2, 1}},
                  scene::DirectionalLight{{0.2, -1, 0.1}, {1, 2, 3}}};
  expect_equal(scene, 0, 4000);
  scene.medium.components[0].albedo = {0, 0, 0};
  expect_equal(scene, 0, 2000);
}

TEST(Lanes, tell_detectors_what_single_photons_tell) {
  Scene scene = lit(component(low_variation(6), 30, 1, scene::HenyeyGreensteinPhase{0.6}));
  scene.detectors = {{9, 7}, 1000, 5, 50, 200, {5, 6, 7}};
  scene.illumination_resolution = {3, 3, 3};  // few cells to measure
  expect_equal(scene, 0, 4000);
  scene.medium.components[0].albedo = {0.99, 0.8, 0.5};
  scene.medium.components.push_back(
      component(scene::Solid{scene::Sphere{{0.5, 0.4, 0.5}, 0.2}}, 200, 0));
  scene.lights = {scene::PointLight{{1.5, 1.8, -0.5}, {3, 2, 1}},
                  scene::DirectionalLight{{0.2, -1, 0.1}, {1, 2, 3}}};
  expect_equal(scene, 0, 4000);
}

TEST(Lanes, find_the_cells_that_are_stored_as_single_photons_do) {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.5}}, 15, 0.9),
                         component(scene::Solid{scene::Sphere{{80.5, 0.4, 0.7}, 0.2}}, 60, 0.8)});
  scene.medium.box_max = {81, 1, 1};
  scene.illumination_resolution = {0, 0, 0};
  scene.lights = {scene::DirectionalLight{{0.2, -1, 0.1}, {1, 2, 3}},
                  scene::DirectionalLight{{-1, 0.002, 0.1}, {1, 2, 3}, 2},
                  scene::EnvironmentLight{}};
  ASSERT_TRUE(resolved(scene).illumination.is_sparse);
  const Account account = expect_equal(scene, 0, 4000);
  EXPECT_LT(account.ledger.missed, 2500) << "most are aimed at the spheres";
}

TEST(Lanes, go_on_from_grounds_as_single_photons_do) {
  Scene scene = lit(component(low_variation(6), 30, 1, scene::HenyeyGreensteinPhase{0.6}));
  scene.medium.components[0].albedo = {0.99, 0.8, 0.5};
  scene.medium.ground[1] = glm::dvec3(1);
  scene.medium.ground[2] = {0.9, 0.5, 0.1};
  scene.medium.ground[4] = glm::dvec3(0);
  scene.detectors = {{9, 7}, 1000, 5, 50, 200, {5, 6, 7}};
  scene.lights = {
      scene::PointLight{{0.5, 0.5, 0.9}, {3, 2, 1}}, scene::PointLight{{1.5, -0.3, 1.2}, {3, 2, 1}},
      scene::DirectionalLight{{0.2, -1, 0.1}, {1, 2, 3}, 20}, scene::EnvironmentLight{}};
  scene.camera.position = {0.3, 0.6, 2};
  for (const int bounces : {0, 2}) {
    scene.bounces = bounces;
    const Account account = expect_equal(scene, 0, 4000);
    EXPECT_GT(account.ledger.escaped_power[2][2], 0);
    EXPECT_GT(account.ledger.escaped[4], 0);
    EXPECT_EQ(account.ledger.escaped_power[1][0], 0);
  }
}

TEST(Lanes, know_media_of_several_components_and_fields) {
  Scene scene = lit(component(low_variation(7), 30, 0.9, scene::HenyeyGreensteinPhase{0.6}));
  scene.medium.components.push_back(
      component(scene::Solid{scene::Sphere{{0.5, 0.4, 0.5}, 0.2}}, 200, 0));
  scene.medium.components.push_back(component(high_variation(9), 40, 1));
  const Account account = expect_equal(scene, 0, 3000);
  EXPECT_GT(account.ledger.absorbed_power[0][0] + account.ledger.absorbed_power[1][0]
                + account.ledger.absorbed_power[2][0],
            0);
  expect_equal(lit(component(scene::Solid{scene::Sphere{{0.5, 0.4, 0.5}, 0.3}}, 20)), 0, 1000);
  scene::DenseGrid grid;
  grid.size = {2, 3, 2};
  grid.values = {0, 0.3f, 1.5f, 0.1f, 0.7f, 0, 0.2f, 2, 0.4f, 0.9f, 0, 0.6f};
  expect_equal(lit(component(grid, 10, 0.95)), 0, 1000);
}

TEST(Lanes, go_through_periodic_sides) {
  Scene scene = lit(component(low_variation(5), 20, 0.9));
  scene.medium.sides = {scene::Side::periodic, scene::Side::open, scene::Side::periodic};
  scene.lights = {scene::DirectionalLight{{0.2, -1, 0.1}, {1, 2, 3}}};
  EXPECT_GT(expect_equal(scene, 0, 2000).audit.cells, 0);
}

TEST(Lanes, have_nothing_to_do_in_an_empty_range) {
  expect_equal(lit(component(low_variation(5), 20)), 7, 0);
}

TEST(Lanes, give_up_where_single_photons_do) {
  Scene scene = lit(component(low_variation(4), 1e11, 0.5));
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.camera.resolution = {1, 1};  // each sample is as long as the photon
  scene.bounces = 0;
  EXPECT_EQ(expect_equal(scene, 0, 1).ledger.stalled, 1);
}

}  // namespace
}  // namespace tyndall::test
