#include "tyndall/transport/walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "support/random.h"

namespace tyndall {
namespace {

using test::Random;

using Triple = std::array<double, 3>;
Triple triple(Vec3f v) { return {v.x, v.y, v.z}; }
Vec3f vec3(const std::array<float, 3>& a) { return {a[0], a[1], a[2]}; }

MajorantGrid grid_of(int nx, int ny, int nz, Vec3f extent) {
  const auto x = static_cast<float>(nx), y = static_cast<float>(ny), z = static_cast<float>(nz);
  MajorantGrid grid;
  grid.nx = nx, grid.ny = ny, grid.nz = nz;
  grid.box.extent = extent;
  grid.cell_size = {extent.x / x, extent.y / y, extent.z / z};
  grid.inverse_cell_size = {x / extent.x, y / extent.y, z / extent.z};
  return grid;
}

std::vector<MajorantGrid> grids() {
  return {grid_of(1, 1, 1, {1, 1, 1}), grid_of(2, 3, 5, {1, 0.7f, 3.1f}),
          grid_of(16, 16, 16, {1, 1, 1}), grid_of(40, 1, 7, {0.3f, 1e-3f, 900})};
}

Triple extent(const MajorantGrid& g) { return triple(g.box.extent); }
std::array<int, 3> resolution(const MajorantGrid& g) { return {g.nx, g.ny, g.nz}; }

/// The largest error of a position relative to its super-voxel: prepare() enlarges it by this.
double slack(const MajorantGrid& g, std::size_t axis) { return 8 * 0x1p-24 * extent(g)[axis]; }

// ---- Rays, most of them degenerate

float nudged(float x, Random& random) {
  const int way = random.below(4);
  return way == 0 ? std::nextafter(x, -1e30f) : way == 1 ? std::nextafter(x, 1e30f) : x;
}

/// A ray that starts in the box, on its faces or between cells, or an ulp beside them. Its
/// direction is arbitrary, along axes, within planes, through corners, or nearly along planes.
Ray any_ray(const MajorantGrid& grid, Random& random) {
  const Triple e = extent(grid);
  const std::array<int, 3> n = resolution(grid);
  std::array<float, 3> origin, direction;
  for (std::size_t a = 0; a < 3; ++a) {
    const float cell = static_cast<float>(e[a]) / static_cast<float>(n[a]);
    switch (random.below(4)) {
      case 0:
        origin[a] = nudged(random.below(2) ? static_cast<float>(e[a]) : 0.0f, random);
        break;
      case 1:
        origin[a] = nudged(static_cast<float>(random.below(n[a] + 1)) * cell, random);
        break;
      default:
        origin[a] = static_cast<float>(random(0, e[a]));
    }
  }
  const int kind = random.below(4);
  for (std::size_t a = 0; a < 3; ++a) {
    const float cell = static_cast<float>(e[a]) / static_cast<float>(n[a]);
    const float sign = random.below(2) ? 1.0f : -1.0f;
    switch (kind) {
      case 0:  // anywhere
        direction[a] = static_cast<float>(random(-1, 1));
        break;
      case 1:  // along axes and diagonals of the box
        direction[a] = sign * static_cast<float>(random.below(2));
        break;
      case 2:  // through a corner of a cell
        direction[a] = static_cast<float>(random.below(n[a] + 1)) * cell - origin[a];
        break;
      default: {  // tiny components along some axes
        const float tiny[] = {0.0f, -0.0f, 1e-42f, 1e-31f, 1e-30f, 1e-20f, 1e-8f, 1.0f};
        direction[a] = sign * tiny[random.below(8)];
      }
    }
  }
  const Vec3f d = vec3(direction);
  if (length(d) < 1e-6f) return {vec3(origin), {0, random.below(2) ? 1.0f : -1.0f, 0}};
  return {vec3(origin), normalize(d)};
}

/// The length of the ray within the cell, in double; the cell grows by `margin` slacks on each
/// side.
double clipped(const MajorantGrid& grid, const Ray& ray, std::array<int, 3> cell, double margin) {
  const Triple e = extent(grid), o = triple(ray.origin), d = triple(ray.direction);
  const std::array<int, 3> n = resolution(grid);
  double t0 = 0, t1 = 1e300;
  for (std::size_t a = 0; a < 3; ++a) {
    const double low = e[a] * cell[a] / n[a] - margin * slack(grid, a);
    const double high = e[a] * (cell[a] + 1) / n[a] + margin * slack(grid, a);
    if (d[a] == 0) {
      if (o[a] < low || o[a] > high) return 0;
    } else {
      t0 = std::max(t0, std::min((low - o[a]) / d[a], (high - o[a]) / d[a]));
      t1 = std::min(t1, std::max((low - o[a]) / d[a], (high - o[a]) / d[a]));
    }
  }
  return std::max(0.0, t1 - t0);
}

/// The distance at which the ray leaves the box along one axis. The box grows by `margin` slacks.
double exit_along(const MajorantGrid& grid, const Ray& ray, std::size_t axis, double margin) {
  const double d = triple(ray.direction)[axis], o = triple(ray.origin)[axis];
  const double beyond = margin * slack(grid, axis);
  if (d == 0) return 1e300;
  return std::max(0.0, ((d > 0 ? extent(grid)[axis] + beyond : -beyond) - o) / d);
}
double exit_of(const MajorantGrid& grid, const Ray& ray, double margin) {
  return std::min({exit_along(grid, ray, 0, margin), exit_along(grid, ray, 1, margin),
                   exit_along(grid, ray, 2, margin)});
}

bool within(const MajorantGrid& grid, std::size_t cell, Vec3f p) {
  const std::array<int, 3> n = resolution(grid);
  const int c = static_cast<int>(cell);
  const std::array<int, 3> at = {c % n[0], c / n[0] % n[1], c / n[0] / n[1]};
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = triple(p)[a], size = extent(grid)[a] / n[a];
    if (x < at[a] * size - slack(grid, a) || x > (at[a] + 1) * size + slack(grid, a)) return false;
  }
  return true;
}

// The length in each cell lies between those of a slightly smaller and a slightly larger cell, so
// rays within faces and through corners need no exception.
TEST(SuperVoxelWalk, stretches_are_those_of_clipping_every_cell) {
  Random random(1);
  const std::vector<MajorantGrid> all = grids();
  const int rays[] = {200000, 500000, 100000, 200000};
  for (std::size_t g = 0; g < all.size(); ++g) {
    const MajorantGrid& grid = all[g];
    std::vector<double> stretch(grid.count());
    for (int n = 0; n < rays[g]; ++n) {
      const Ray ray = any_ray(grid, random);
      SuperVoxelWalk walk(grid, ray);
      std::vector<std::size_t> visited;
      double total = 0;
      bool inside = true;
      do {
        ASSERT_LT(visited.size(), static_cast<std::size_t>(grid.nx + grid.ny + grid.nz))
            << "ray " << n << " of grid " << g << " does not end";
        visited.push_back(walk.cell());
        ASSERT_GE(walk.length_to_exit(), 0.0f);
        ASSERT_LT(walk.length_to_exit(), 1e4f);
        stretch[walk.cell()] += double{walk.length_to_exit()};
        total += double{walk.length_to_exit()};
        SuperVoxelWalk half = walk, whole = walk;
        half.advance(0.5f * walk.length_to_exit());
        whole.advance(walk.length_to_exit());
        inside = inside && within(grid, walk.cell(), walk.position())
                 && within(grid, walk.cell(), half.position())
                 && within(grid, walk.cell(), whole.position());
      } while (walk.cross());
      ASSERT_TRUE(inside) << "ray " << n << " of grid " << g;

      const double rounding = 1e-6 * (total + 1e-3);
      ASSERT_GE(total, exit_of(grid, ray, -1) - rounding) << "ray " << n << " of grid " << g;
      ASSERT_LE(total, exit_of(grid, ray, 1) + rounding) << "ray " << n << " of grid " << g;
      const auto axis = static_cast<std::size_t>(walk.face() / 2);
      ASSERT_NE(triple(ray.direction)[axis], 0);
      ASSERT_EQ(triple(ray.direction)[axis] > 0, walk.face() % 2 == 1);
      ASSERT_LE(exit_along(grid, ray, axis, -1), exit_of(grid, ray, 1) + rounding)
          << "another face";

      // Checks all cells of small grids. For the others, the visited cells cover the whole ray.
      const auto check = [&](int i, int j, int k) {
        const double s = stretch[grid.index(i, j, k)];
        return s <= clipped(grid, ray, {i, j, k}, 1) + rounding
               && s >= clipped(grid, ray, {i, j, k}, -1) - rounding;
      };
      bool right = true;
      if (grid.count() < 100 || n < 2000) {
        for (int k = 0; k < grid.nz; ++k) {
          for (int j = 0; j < grid.ny; ++j) {
            for (int i = 0; i < grid.nx; ++i) right = right && check(i, j, k);
          }
        }
      } else {
        for (const std::size_t cell : visited) {
          const int c = static_cast<int>(cell);
          right = right && check(c % grid.nx, c / grid.nx % grid.ny, c / grid.nx / grid.ny);
        }
      }
      ASSERT_TRUE(right) << "ray " << n << " of grid " << g;
      for (const std::size_t cell : visited) stretch[cell] = 0;
    }
  }
}

TEST(SuperVoxelWalk, neighbours_along_the_way_share_a_face) {
  Random random(2);
  for (const MajorantGrid& grid : grids()) {
    for (int n = 0; n < 20000; ++n) {
      const Ray ray = any_ray(grid, random);
      SuperVoxelWalk walk(grid, ray);
      for (;;) {
        const SuperVoxelWalk::Place a = walk.place();
        if (!walk.cross()) break;
        const SuperVoxelWalk::Place b = walk.place();
        const std::array<int, 3> moved{b.i - a.i, b.j - a.j, b.k - a.k};
        ASSERT_EQ(std::count(moved.begin(), moved.end(), 0), 2);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (moved[axis] == 0) continue;
          ASSERT_EQ(moved[axis], triple(ray.direction)[axis] > 0 ? 1 : -1);
        }
      }
    }
  }
}

TEST(SuperVoxelWalk, advances_no_further_than_its_cell) {
  const MajorantGrid grid = grid_of(4, 1, 1, {1, 1, 1});
  SuperVoxelWalk walk(grid, {{0, 0.5f, 0.5f}, {1, 0, 0}});
  walk.advance(0.1f);
  EXPECT_FLOAT_EQ(walk.position().x, 0.1f);
  EXPECT_FLOAT_EQ(walk.length_to_exit(), 0.15f);
  walk.advance(7);
  EXPECT_EQ(walk.position().x, 0.25f);
  EXPECT_EQ(walk.length_to_exit(), 0.0f);
  EXPECT_EQ(walk.cell(), 0u);
}

TEST(SuperVoxelWalk, stays_in_a_periodic_box_and_on_its_line) {
  Random random(3);
  for (MajorantGrid grid : grids()) {
    grid.box.periodic_x = grid.box.periodic_y = grid.box.periodic_z = true;
    const Triple e = extent(grid);
    for (int n = 0; n < 300; ++n) {
      const Ray ray = any_ray(grid, random);
      SuperVoxelWalk walk(grid, ray);
      double way = 0;
      for (int crossing = 0; crossing < 300; ++crossing) {
        way += double{walk.length_to_exit()};
        ASSERT_TRUE(walk.cross());
        const Triple p = triple(walk.position());
        ASSERT_TRUE(within(grid, walk.cell(), walk.position())) << crossing;
        for (std::size_t a = 0; a < 3; ++a) {
          const double x = triple(ray.origin)[a] + way * triple(ray.direction)[a];
          const double off = std::remainder(x - p[a], e[a]);  // modulo the period
          ASSERT_LE(std::abs(off), (crossing + 2) * slack(grid, a) + 1e-6 * std::abs(x))
              << crossing;
        }
      }
    }
  }
}

TEST(SuperVoxelWalk, leaves_through_open_sides_and_passes_periodic_ones) {
  MajorantGrid grid = grid_of(3, 4, 5, {1, 1, 1});
  grid.box.periodic_x = true;
  Random random(4);
  for (int n = 0; n < 5000; ++n) {
    const Ray ray = any_ray(grid, random);
    if (std::abs(ray.direction.y) < 0.01f && std::abs(ray.direction.z) < 0.01f) continue;
    SuperVoxelWalk walk(grid, ray);
    int crossings = 0;
    while (walk.cross()) ASSERT_LT(++crossings, 1000);
    ASSERT_GE(walk.face(), 2);
  }
}

// ---- Flights through a medium that records its calls

struct Question {
  std::size_t cell;
  float v;
  Vec3f p;
};

struct Witness {
  mutable std::vector<Question> asked;
  std::size_t real = ~std::size_t{0};  ///< the first call that returns a component

  int collide(const MajorantGrid&, std::size_t cell, float v, Vec3f p, Lookups&,
              Decision = Decision::audited) const {
    asked.push_back({cell, v, p});
    return asked.size() > real ? 0 : virtual_particle;
  }
};

struct Majorants {
  std::vector<float> total;
  MajorantGrid grid;
  Majorants(MajorantGrid g, std::vector<float> values) : total(std::move(values)), grid(g) {
    grid.total = total.data();
  }
};

Majorants random_majorants(const MajorantGrid& grid, double scale, Random& random) {
  std::vector<float> total(grid.count());
  for (float& x : total) x = random.below(4) == 0 ? 0.0f : static_cast<float>(random(0, scale));
  return {grid, total};
}

double distance(Vec3f a, Vec3f b) {
  const Triple p = triple(a), q = triple(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

/// The optical depth of the majorants from `a` to `b`.
double depth_between(const Majorants& m, const Ray& ray, Vec3f a, Vec3f b) {
  const double begin = distance(ray.origin, a), end = distance(ray.origin, b);
  double sum = 0, at = 0;
  SuperVoxelWalk walk(m.grid, ray);
  do {
    const double next = at + double{walk.length_to_exit()};
    sum += double{m.total[walk.cell()]} * std::max(0.0, std::min(next, end) - std::max(at, begin));
    at = next;
  } while (walk.cross());
  return sum;
}

TEST(Track, draws_one_block_for_each_tentative_collision_and_none_for_crossings) {
  Random random(5);
  for (const MajorantGrid& shape : grids()) {
    const Majorants m = random_majorants(shape, 20 / shape.box.extent.x, random);
    for (std::uint64_t n = 0; n < 2000; ++n) {
      const RandomStream stream{99, n, Domain::photon};
      const std::uint32_t before = static_cast<std::uint32_t>(n % 5);
      Path path{
          any_ray(shape, random), exponential(stream.block(0, Purpose::emission).d), before, {}};
      Witness medium;
      medium.real = 3;
      Audit audit;
      const Flight flight = track(medium, m.grid, path, stream, audit);
      ASSERT_EQ(path.event - before, medium.asked.size());
      ASSERT_EQ(static_cast<std::size_t>(audit.tentative), medium.asked.size());
      ASSERT_EQ(audit.real, flight.end == Flight::End::collided);
      ASSERT_EQ(flight.end == Flight::End::collided, medium.asked.size() == 4);
      for (std::size_t i = 0; i < medium.asked.size(); ++i) {
        const Question& q = medium.asked[i];
        const auto event = static_cast<std::uint32_t>(before + 1 + i);
        ASSERT_EQ(q.v, uniform(stream.block(event, Purpose::walk).a) * m.total[q.cell]);
        ASSERT_GT(m.total[q.cell], 0.0f) << "a collision where nothing is";
        ASSERT_TRUE(within(shape, q.cell, q.p));
      }
      if (medium.asked.empty()) continue;
      const RandomBlock last = stream.block(path.event, Purpose::walk);
      ASSERT_EQ(path.drawn.a, last.a);
      ASSERT_EQ(path.drawn.d, last.d);
      const bool collided = flight.end == Flight::End::collided;
      ASSERT_EQ(path.tau == exponential(last.b), collided) << "what is left crosses cells";
    }
  }
}

// The optical depth between tentative collisions is the sampled one, across any number of cells.
TEST(Track, carries_the_optical_depth_across_cells_and_past_virtual_particles) {
  Random random(6);
  const MajorantGrid shape = grid_of(7, 5, 9, {1, 2, 3});
  int tentative = 0;
  for (std::uint64_t n = 0; n < 3000; ++n) {
    const Majorants m = random_majorants(shape, 8, random);
    const RandomStream stream{7, n, Domain::pixel_sample};
    const Ray ray = any_ray(shape, random);
    const float first = exponential(stream.block(0, Purpose::emission).d);
    Path path{ray, first, 0, {}};
    Witness medium;  // all collisions are null: the flight ends at the box
    Audit audit;
    const Flight flight = track(medium, m.grid, path, stream, audit);
    ASSERT_EQ(flight.end, Flight::End::escaped);
    Vec3f from = ray.origin;
    double tau = first;
    std::uint32_t event = 0;
    for (const Question& q : medium.asked) {
      ASSERT_NEAR(depth_between(m, ray, from, q.p), tau, 2e-5);
      from = q.p;
      tau = exponential(stream.block(++event, Purpose::walk).b);
    }
    tentative += static_cast<int>(event);
    ASSERT_NEAR(depth_between(m, ray, from, path.ray.origin), tau - double{path.tau}, 2e-5);
    ASSERT_GT(path.tau, 0.0f);
  }
  EXPECT_GT(tentative, 3000);
}

TEST(Track, counts_the_super_voxels_it_enters) {
  const Majorants m(grid_of(4, 1, 1, {1, 1, 1}), {0, 0, 0, 1e6f});
  const RandomStream stream{1, 1, Domain::photon};
  Path path{{{0, 0.5f, 0.5f}, {1, 0, 0}}, 1, 0, {}};
  Witness medium;
  medium.real = 0;
  Audit audit;
  track(medium, m.grid, path, stream, audit);
  EXPECT_EQ(audit.cells, 4);
  EXPECT_NEAR(path.ray.origin.x, 0.75, 1e-5);
  path = {{{0.6f, 0.5f, 0.5f}, {-1, 0, 0}}, 1, 0, {}};
  const Flight flight = track(medium, m.grid, path, stream, audit);
  EXPECT_EQ(flight.end, Flight::End::escaped);
  EXPECT_EQ(flight.face, 0);
  EXPECT_EQ(audit.cells, 4 + 3);
  EXPECT_EQ(audit.flights, 2);
}

TEST(Track, gives_up_in_an_empty_periodic_box) {
  MajorantGrid shape = grid_of(2, 2, 2, {1, 1, 1});
  shape.box.periodic_x = shape.box.periodic_y = shape.box.periodic_z = true;
  const Majorants m(shape, std::vector<float>(8, 0.0f));
  const RandomStream stream{1, 1, Domain::photon};
  Path path{{{0.1f, 0.2f, 0.3f}, normalize({0.5f, -0.3f, 0.8f})}, 1, 0, {}};
  Witness medium;
  Audit audit;
  EXPECT_EQ(track(medium, m.grid, path, stream, audit).end, Flight::End::stalled);
  EXPECT_EQ(audit.cells, most_crossings + 1);
  EXPECT_EQ(path.event, 0u);
  EXPECT_TRUE(medium.asked.empty());
}

/// A medium with only null collisions.
struct Void {
  int collide(const MajorantGrid&, std::size_t, float, Vec3f, Lookups&,
              Decision = Decision::audited) const {
    return virtual_particle;
  }
};

// Steps of 1e-9 vanish in the rounding of a distance of 0.5, so the walk does not advance.
TEST(Track, gives_up_among_virtual_particles_too_dense_to_pass) {
  const Majorants m(grid_of(1, 2, 1, {1, 1, 1}), {1e9f, 1e9f});
  const RandomStream stream{1, 1, Domain::photon};
  Path path{{{0.5f, 0.01f, 0.5f}, {0, 1, 0}}, 1, 0, {}};
  Audit audit;
  EXPECT_EQ(track(Void{}, m.grid, path, stream, audit).end, Flight::End::stalled);
  EXPECT_EQ(audit.tentative, most_virtual);
}

// ---- Entering the box

TEST(Enter, moves_a_ray_onto_an_open_box_or_says_that_it_misses) {
  Random random(7);
  const Box box{{1, 2, 0.5f}};
  int met = 0, missed = 0;
  for (int n = 0; n < 200000; ++n) {
    const std::array<float, 3> o = {static_cast<float>(random(-2, 3)),
                                    static_cast<float>(random(-2, 4)),
                                    static_cast<float>(random(-2, 2.5))};
    const std::array<float, 3> d = {static_cast<float>(random(-1, 1)),
                                    static_cast<float>(random(-1, 1)),
                                    static_cast<float>(random(-1, 1))};
    const Ray before{vec3(o), normalize(vec3(d))};
    Ray ray = before;
    const bool meets = enter(box, ray);
    // The entry and the exit in double precision.
    double t0 = 0, t1 = 1e300;
    for (std::size_t a = 0; a < 3; ++a) {
      const double p = triple(before.origin)[a], v = triple(before.direction)[a];
      const double low = (0 - p) / v, high = (triple(box.extent)[a] - p) / v;
      t0 = std::max(t0, std::min(low, high));
      t1 = std::min(t1, std::max(low, high));
    }
    if (std::abs(t1 - t0) < 1e-5) continue;  // grazes
    ASSERT_EQ(meets, t0 < t1);
    (meets ? met : missed)++;
    if (!meets) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      ASSERT_NEAR(triple(ray.origin)[a],
                  triple(before.origin)[a] + t0 * triple(before.direction)[a], 2e-6);
      ASSERT_GE(triple(ray.origin)[a], 0);
      ASSERT_LE(triple(ray.origin)[a], triple(box.extent)[a]);
    }
  }
  EXPECT_GT(met, 5000);
  EXPECT_GT(missed, 5000);
}

TEST(Enter, leaves_a_ray_that_starts_inside_where_it_is) {
  const Box box{{1, 1, 1}};
  for (const Vec3f o : {Vec3f{0.3f, 0.4f, 0.5f}, Vec3f{0, 0, 0}, Vec3f{1, 0.5f, 1}}) {
    for (const Vec3f d : {Vec3f{1, 0, 0}, Vec3f{0, -1, 0}, Vec3f{-0.0f, 0, 1}}) {
      Ray ray{o, d};
      ASSERT_TRUE(enter(box, ray));
      EXPECT_EQ(triple(ray.origin), triple(o));
    }
  }
}

TEST(Enter, rays_along_a_face_of_the_box_meet_it_and_those_beside_it_miss) {
  const Box box{{1, 1, 1}};
  for (const float y : {0.0f, 1.0f}) {
    Ray along{{-1, y, 0.5f}, {1, 0, 0}};
    EXPECT_TRUE(enter(box, along));
    EXPECT_EQ(along.origin.x, 0.0f);
  }
  for (const float y : {-1e-6f, 1.0000001f}) {
    Ray beside{{-1, y, 0.5f}, {1, -0.0f, 0}};
    EXPECT_FALSE(enter(box, beside));
  }
  Ray away{{-1, 0.5f, 0.5f}, {-1, 0, 0}};
  EXPECT_FALSE(enter(box, away));
}

TEST(Enter, ends_at_the_back_of_a_ground) {
  Box box{{1, 2, 3}};
  box.grounds = 1u << 2;  // -y
  const auto entry = [&](Vec3f origin, Vec3f direction) {
    Ray ray{origin, normalize(direction)}, same = ray;
    const Entry found = approach(box, ray);
    EXPECT_EQ(enter(box, same), found == Entry::open);
    return found;
  };
  EXPECT_EQ(entry({0.5f, -1, 1}, {0.1f, 1, 0.2f}), Entry::ground);
  EXPECT_EQ(entry({0.5f, 3, 1}, {0.1f, -1, 0.2f}), Entry::open);     // from above
  EXPECT_EQ(entry({-0.1f, -0.1f, 1}, {1, 0.5f, 0}), Entry::ground);  // beyond two faces
  EXPECT_EQ(entry({-0.1f, -0.1f, 1}, {0.5f, 1, 0}), Entry::open);    // through -x
  EXPECT_EQ(entry({0.5f, 0, 1}, {0, 1, 0}), Entry::open);            // on it
  EXPECT_EQ(entry({0.5f, -1, 1}, {0, -1, 0}), Entry::none);
}

TEST(Enter, finds_the_place_within_the_first_period) {
  Random random(8);
  Box box{{1, 0.7f, 2}};
  box.periodic_x = box.periodic_y = true;
  for (int n = 0; n < 20000; ++n) {
    const Vec3f o{static_cast<float>(random(-20, 20)), static_cast<float>(random(-20, 20)), -1};
    const Vec3f d =
        normalize({static_cast<float>(random(-1, 1)), static_cast<float>(random(-1, 1)), 1});
    Ray ray{o, d};
    ASSERT_TRUE(enter(box, ray)) << "no ray misses a layer that it flies towards";
    ASSERT_EQ(ray.origin.z, 0.0f);
    const double t = 1 / double{d.z};
    const double x = o.x + t * d.x, y = o.y + t * d.y;
    ASSERT_NEAR(std::remainder(x - ray.origin.x, 1.0), 0, 1e-5);
    ASSERT_NEAR(std::remainder(y - ray.origin.y, double{box.extent.y}), 0, 1e-5);
    ASSERT_TRUE(ray.origin.x >= 0 && ray.origin.x <= 1);
    ASSERT_TRUE(ray.origin.y >= 0 && ray.origin.y <= box.extent.y);
  }
  box.periodic_z = true;  // infinite: every ray is inside
  Ray ray{{-7.25f, 3.6f, 9.5f}, {0, 0, 1}};
  ASSERT_TRUE(enter(box, ray));
  EXPECT_NEAR(ray.origin.x, 0.75f, 1e-5);
  EXPECT_NEAR(ray.origin.y, 0.1f, 1e-5);
  EXPECT_NEAR(ray.origin.z, 1.5f, 1e-5);
}

}  // namespace
}  // namespace tyndall
