#include "tyndall/medium/medium.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/statistics.h"
#include "tyndall/random/random.h"

namespace tyndall {
namespace {

float random_number(std::uint64_t index, Purpose purpose = Purpose::walk) {
  return uniform(RandomStream{17, index, Domain::photon}.block(0, purpose).a);
}

/// The half-space x < 1/2.
Solid half_space() {
  Solid s;
  s.body = Solid::Body::cuboid;
  s.half = {0.5f, 100, 100};
  return s;
}

struct OneCell {
  std::vector<float> total{0}, upper, lower;
  MajorantGrid grid;
  OneCell(std::vector<float> majorants, std::vector<float> minorants)
      : upper(std::move(majorants)), lower(std::move(minorants)) {
    for (const float x : upper) total[0] += x;
    grid.components = static_cast<int>(upper.size());
    grid.total = total.data(), grid.upper = upper.data(), grid.lower = lower.data();
  }
};

Component<AnyField> dense(float extinction, AnyField field = Solid{}, Vec3f albedo = {1, 1, 1}) {
  return {field, {}, extinction, albedo, {}};
}

TEST(Component, extinction_is_a_number_of_lengths_times_the_density_in_field_space) {
  Component<Solid> c{half_space(), {}, 3, {1, 1, 1}, {}};
  EXPECT_EQ(c.sigma_t({0.25f, 0, 0}), 3.0f);
  EXPECT_EQ(c.sigma_t({0.75f, 0, 0}), 0.0f);
  c.to_field.row_x = {0.5f, 0, 0};
  c.to_field.offset = {-0.25f, 0, 0};
  EXPECT_EQ(c.sigma_t({1.4f, 0, 0}), 3.0f);
  EXPECT_EQ(c.sigma_t({1.6f, 0, 0}), 0.0f);
  EXPECT_TRUE(c.scatters());
  c.albedo = {0, 0, 0.01f};
  EXPECT_TRUE(c.scatters());
  c.albedo = {0, 0, 0};
  EXPECT_FALSE(c.scatters());
}

TEST(Medium, total_sigma_t_adds_the_components) {
  const std::vector<Component<AnyField>> parts = {
      dense(1, half_space()), dense(10, Solid{}, {0, 0, 0}), dense(100, Solid{}, {0, 0.5f, 0})};
  MixedMedium medium{{}, {}, parts.data(), 3};
  EXPECT_EQ(total_sigma_t(medium, {0.25f, 0, 0}), 111.0f);
  EXPECT_EQ(total_sigma_t(medium, {0.75f, 0, 0}), 110.0f);
}

TEST(SingleMedium, is_real_in_the_proportion_of_extinction_to_majorant) {
  const OneCell cell({8}, {0});
  const SingleMedium<Solid> medium{cell.grid, cell.grid, {Solid{}, {}, 3, {1, 1, 1}, {}}};
  const std::uint64_t n = 400000;
  Lookups count;
  std::int64_t real = 0;
  for (std::uint64_t i = 0; i < n; ++i)
    real += medium.collide(cell.grid, 0, random_number(i) * 8, {0, 0, 0}, count) == 0;
  EXPECT_GT(test::proportion_p(real, n, 3.0 / 8), 1e-4);
  EXPECT_EQ(count.lookups, static_cast<int>(n));
  EXPECT_EQ(count.violations, 0);
}

TEST(SingleMedium, below_the_minorant_needs_no_look_up) {
  const OneCell cell({8}, {2.5f});
  const SingleMedium<Solid> medium{cell.grid, cell.grid, {Solid{}, {}, 3, {1, 1, 1}, {}}};
  Lookups count;
  EXPECT_EQ(medium.collide(cell.grid, 0, 0.01f, {0, 0, 0}, count), 0);
  EXPECT_EQ(medium.collide(cell.grid, 0, 2.49f, {0, 0, 0}, count), 0);
  EXPECT_EQ(count.lookups, 0);
  EXPECT_EQ(medium.collide(cell.grid, 0, 2.51f, {0, 0, 0}, count), 0);
  EXPECT_EQ(medium.collide(cell.grid, 0, 3.01f, {0, 0, 0}, count), virtual_particle);
  EXPECT_EQ(count.lookups, 2);
}

TEST(SingleMedium, a_look_up_outside_its_bounds_is_a_violation) {
  struct Case {
    float lower, upper;
    int violations;
  };
  for (const Case c : {Case{0, 2.9f, 1}, {0, 3, 0}, {3, 3, 0}, {3.1f, 9, 1}, {2, 4, 0}}) {
    const OneCell cell({c.upper}, {c.lower});
    const SingleMedium<Solid> medium{cell.grid, cell.grid, {Solid{}, {}, 3, {1, 1, 1}, {}}};
    Lookups count;
    medium.collide(cell.grid, 0, std::nextafter(c.upper, 0.0f), {0, 0, 0}, count);
    const bool looked = std::nextafter(c.upper, 0.0f) >= c.lower;
    EXPECT_EQ(count.lookups, looked ? 1 : 0);
    EXPECT_EQ(count.violations, looked ? c.violations : 0) << c.lower << " to " << c.upper;
  }
}

TEST(MixedMedium, hits_each_component_in_proportion_to_its_extinction) {
  // The upper bounds are 1, 4, 7, 8; the extinctions 0.5, 4, 0 (at this point) and 2.
  Solid elsewhere = half_space();
  elsewhere.center.x = 50;
  const std::vector<Component<AnyField>> parts = {dense(0.5f), dense(4), dense(6, elsewhere),
                                                  dense(2)};
  const OneCell cell({1, 4, 7, 8}, {0.25f, 4, 0, 0});
  const MixedMedium medium{cell.grid, cell.grid, parts.data(), 4};
  const std::uint64_t n = 400000;
  std::vector<std::int64_t> hits(5, 0);
  Lookups count;
  for (std::uint64_t i = 0; i < n; ++i) {
    const int hit = medium.collide(cell.grid, 0, random_number(i) * 20, {0, 0, 0}, count);
    ++hits[hit == virtual_particle ? 4u : static_cast<unsigned>(hit)];
  }
  EXPECT_EQ(hits[2], 0);
  EXPECT_GT(test::chi_square_test(hits, {0.5, 4, 0, 2, 13.5}).p, 1e-4);
  EXPECT_EQ(count.violations, 0);
  // No look-up below the minorants, 4.25 of 20; otherwise at most one.
  EXPECT_GT(test::proportion_p(count.lookups, n, 15.75 / 20), 1e-4);
}

TEST(MixedMedium, of_one_component_is_a_single_medium) {
  const OneCell cell({5}, {1});
  const std::vector<Component<AnyField>> part = {dense(2)};
  const MixedMedium mixed{cell.grid, cell.grid, part.data(), 1};
  const SingleMedium<Solid> single{cell.grid, cell.grid, {Solid{}, {}, 2, {1, 1, 1}, {}}};
  Lookups a, b;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const float v = random_number(i) * 5;
    ASSERT_EQ(mixed.collide(cell.grid, 0, v, {0, 0, 0}, a),
              single.collide(cell.grid, 0, v, {0, 0, 0}, b));
  }
  EXPECT_EQ(a.lookups, b.lookups);
}

TEST(MixedMedium, above_the_sum_by_a_rounding_error_is_a_virtual_particle) {
  const OneCell cell({1, 2}, {1, 2});
  const std::vector<Component<AnyField>> parts = {dense(1), dense(2)};
  const MixedMedium medium{cell.grid, cell.grid, parts.data(), 2};
  Lookups count;
  EXPECT_EQ(medium.collide(cell.grid, 0, std::nextafter(3.0f, 0.0f), {0, 0, 0}, count), 1);
  EXPECT_EQ(medium.collide(cell.grid, 0, 3.0f, {0, 0, 0}, count), virtual_particle);
  EXPECT_EQ(count.lookups, 0);
}

TEST(Medium, reads_the_bounds_of_the_right_component_and_super_voxel) {
  // 2 components, 6 super-voxels: each pair has a different majorant.
  MajorantGrid grid;
  grid.nx = 3, grid.ny = 2, grid.nz = 1;
  grid.components = 2;
  std::vector<float> upper, lower(12, 0.0f);
  for (int i = 0; i < 12; ++i) upper.push_back(static_cast<float>(i + 1));
  grid.upper = upper.data(), grid.lower = lower.data();
  const std::vector<Component<AnyField>> parts = {dense(1), dense(7)};
  const MixedMedium medium{grid, grid, parts.data(), 2};
  for (std::size_t cell = 0; cell < 6; ++cell) {
    const float first = upper[cell];
    Lookups count;
    EXPECT_EQ(medium.collide(grid, cell, 0.5f, {0, 0, 0}, count), 0);
    EXPECT_EQ(medium.collide(grid, cell, first + 6.5f, {0, 0, 0}, count), 1);
    EXPECT_EQ(medium.collide(grid, cell, first + 0.5f, {0, 0, 0}, count), 1);
    EXPECT_EQ(count.violations, 0);
  }
}

// ---- The grid

TEST(MajorantGrid, numbers_its_cells_x_fastest_and_knows_those_of_positions) {
  MajorantGrid grid;
  grid.nx = 3, grid.ny = 5, grid.nz = 2;
  grid.box.extent = {1.5f, 10, 0.25f};
  grid.cell_size = {0.5f, 2, 0.125f};
  grid.inverse_cell_size = {2, 0.5f, 8};
  EXPECT_EQ(grid.count(), 30u);
  std::size_t next = 0;
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(grid.index(i, j, k), next++);
        const Vec3f low{0.5f * static_cast<float>(i), 2 * static_cast<float>(j),
                        0.125f * static_cast<float>(k)};
        EXPECT_EQ(grid.cell_of(low), grid.index(i, j, k));
        EXPECT_EQ(grid.cell_of(low + Vec3f{0.49f, 1.99f, 0.12f}), grid.index(i, j, k));
      }
    }
  }
}

TEST(MajorantGrid, positions_outside_belong_to_its_outermost_cells) {
  MajorantGrid grid;
  grid.nx = grid.ny = grid.nz = 4;
  grid.inverse_cell_size = {4, 4, 4};
  EXPECT_EQ(grid.cell_of({-1e-7f, 0.5f, 0.5f}), grid.index(0, 2, 2));
  EXPECT_EQ(grid.cell_of({1, 1, 1}), grid.index(3, 3, 3));
  EXPECT_EQ(grid.cell_of({1e30f, -1e30f, 0.3f}), grid.index(3, 0, 1));
}

}  // namespace
}  // namespace tyndall
