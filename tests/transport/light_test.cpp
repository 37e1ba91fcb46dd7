#include "tyndall/transport/light.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr std::uint64_t photons = 200000;
constexpr double level = 1e-4;

struct Lit {
  Scene scene;
  PreparedScene prepared;
  Box box;
  explicit Lit(std::vector<scene::Light> lights, glm::dvec3 low = {0, 0, 0},
               glm::dvec3 high = {1, 2, 0.5}) {
    scene.medium.box_min = low;
    scene.medium.box_max = high;
    scene.medium.majorant_resolution = {1, 1, 1};
    scene.medium.components = {component(scene::Solid{}, 1)};
    scene.lights = std::move(lights);
    prepare_again();
  }
  void prepare_again() {
    prepared = prepare(scene, 1);
    box = std::visit([](const auto& medium) { return medium.whole.box; }, prepared.medium);
  }
  Photon photon(std::uint64_t index) const {
    const RandomStream random{42, index, Domain::photon};
    return emit({prepared.emitters.data(), static_cast<int>(prepared.emitters.size())}, box,
                random.block(0, Purpose::emission), random.block(0, Purpose::aim));
  }
};

/// The face of the box on which a point lies (-1: none), and its position there in [0, 1]^2.
struct Place {
  Face face = -1;
  double u = 0, v = 0;
};
Place place_of(const Box& box, Vec3f p) {
  const double x[] = {p.x, p.y, p.z}, e[] = {box.extent.x, box.extent.y, box.extent.z};
  for (int axis = 0; axis < 3; ++axis) {
    const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
    for (int high = 0; high < 2; ++high) {
      if (x[axis] == (high ? e[axis] : 0.0)) return {2 * axis + high, x[a] / e[a], x[b] / e[b]};
    }
  }
  return {};
}

double area(const Box& box, Face face) {
  const Vec3f e = box.extent;
  return double{face / 2 == 0 ? e.y * e.z : face / 2 == 1 ? e.x * e.z : e.x * e.y};
}

std::size_t bin(double x, int n) {
  return static_cast<std::size_t>(std::min(n - 1, static_cast<int>(x * n)));
}

TEST(Lights, a_point_light_shines_evenly_into_a_cone_that_holds_the_box) {
  for (const glm::dvec3 position : {glm::dvec3(3, 1, 0.2), glm::dvec3(-0.2, -4, 7),
                                    glm::dvec3(0.5, 1, 0.25), glm::dvec3(0.5, 1, 1.0)}) {
    const Lit lit({scene::PointLight{position, glm::dvec3(8)}});
    ASSERT_EQ(lit.prepared.emitters.size(), 1u);
    const auto& e = lit.prepared.emitters[0].light.as<lights::Point>();
    const Vec3f axis = e.cone.axis;
    const double height = e.cone.height, share = 0.5 * height;
    EXPECT_NEAR(lit.prepared.shot_power, 8 * share, 1e-9);
    EXPECT_NEAR(lit.prepared.unshot_power.x, 8 * (1 - share), 1e-9);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3f c{corner & 1 ? 1.0f : 0.0f, corner & 2 ? 2.0f : 0.0f, corner & 4 ? 0.5f : 0.0f};
      EXPECT_GE(double{dot(normalize(c - e.position), axis)}, 1 - height) << corner;
    }
    std::vector<std::int64_t> counts(200, 0);
    const Vec3f s = to_frame_of(axis, {1, 0, 0}), t = to_frame_of(axis, {0, 1, 0});
    for (std::uint64_t i = 0; i < photons; ++i) {
      const Vec3f d = lit.photon(i).ray.direction;
      ASSERT_NEAR(length(d), 1, 1e-6);
      const double part = double{cap_height(d, axis)} / height;
      ASSERT_LT(part, 1 + 1e-4);
      const double turn = 0.5 + std::atan2(double{dot(d, t)}, double{dot(d, s)}) / (2 * double{pi});
      ++counts[20 * bin(part, 10) + bin(turn, 20)];
    }
    EXPECT_GT(chi_square_test(counts).p, level);
  }
}

// The result is the same as for all directions: photons outside the cone would miss the box.
TEST(Lights, the_cone_of_a_point_light_leaves_out_nothing_that_meets_the_box) {
  const glm::dvec3 position(2.5, 1.7, -1);
  const Lit lit({scene::PointLight{position, glm::dvec3(1)}});
  Emitter everywhere = lit.prepared.emitters[0];
  auto& point = everywhere.light.as<lights::Point>();
  point.cone.height = 2;
  point.is_far = false;
  std::int64_t met = 0, met_of_all = 0;
  for (std::uint64_t i = 0; i < photons; ++i) {
    Ray ray = lit.photon(i).ray;
    met += enter(lit.box, ray);
    const RandomStream random{43, i, Domain::photon};
    ray = emit({&everywhere, 1}, lit.box, random.block(0, Purpose::emission),
               random.block(0, Purpose::aim))
              .ray;
    met_of_all += enter(lit.box, ray);
  }
  const double n = photons, share = lit.prepared.shot_power;
  const double a = static_cast<double>(met) / n, b = static_cast<double>(met_of_all) / n;
  const double variance = (share * share * a * (1 - a) + b * (1 - b)) / n;
  EXPECT_GT(normal_p((share * a - b) / std::sqrt(variance)), level);
  EXPECT_GT(a, 0.1);
  EXPECT_LT(share, 0.4);
}

TEST(Lights, parallel_light_falls_evenly_on_the_faces_that_it_meets) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(1, -2, 0.5));
  const Lit lit({scene::DirectionalLight{direction, glm::dvec3(3)}});
  std::vector<std::int64_t> counts(6 * 64, 0);
  std::vector<double> expected(6 * 64, 0);
  double power = 0;
  for (const Face face : {0, 3, 4}) {
    const Vec3f n = inward_normal(face);
    const double flux = 3 * area(lit.box, face) * glm::dot(direction, glm::dvec3(n.x, n.y, n.z));
    power += flux;
    for (std::size_t i = 0; i < 64; ++i) expected[static_cast<std::size_t>(face) * 64 + i] = flux;
  }
  EXPECT_NEAR(lit.prepared.shot_power, power, 1e-6);
  for (std::uint64_t i = 0; i < photons; ++i) {
    const Photon photon = lit.photon(i);
    ASSERT_NEAR(photon.ray.direction.y, direction.y, 1e-7);
    const Place p = place_of(lit.box, photon.ray.origin);
    ASSERT_GE(p.face, 0);
    ++counts[static_cast<std::size_t>(p.face) * 64 + 8 * bin(p.u, 8) + bin(p.v, 8)];
  }
  EXPECT_GT(chi_square_test(counts, expected).p, level);
}

TEST(Lights, an_environment_is_even_over_the_faces_and_lambertian_in_direction) {
  const Lit lit({scene::EnvironmentLight{glm::dvec3(2)}});
  std::vector<std::int64_t> places(6 * 16, 0), directions(200, 0);
  std::vector<double> expected;
  double all = 0;
  for (Face face = 0; face < 6; ++face) {
    all += area(lit.box, face);
    expected.insert(expected.end(), 16, area(lit.box, face));
  }
  EXPECT_NEAR(lit.prepared.shot_power, 2 * double{pi} * all, 1e-5);
  Series chords;
  for (std::uint64_t i = 0; i < photons; ++i) {
    const Ray ray = lit.photon(i).ray;
    const Place p = place_of(lit.box, ray.origin);
    ASSERT_GE(p.face, 0);
    ++places[static_cast<std::size_t>(p.face) * 16 + 4 * bin(p.u, 4) + bin(p.v, 4)];
    const Vec3f d = ray.direction, n = inward_normal(p.face);
    const double cosine = dot(d, n);
    ASSERT_GT(cosine, 0);
    const double along = p.face / 2 == 0 ? d.y : d.x, across = p.face / 2 == 2 ? d.y : d.z;
    const double turn = 0.5 + std::atan2(across, along) / (2 * double{pi});
    ++directions[20 * bin(cosine * cosine, 10) + bin(turn, 20)];
    chords.add(distance_to_exit(lit.box, ray));
  }
  EXPECT_GT(chi_square_test(places, expected).p, level);
  EXPECT_GT(chi_square_test(directions).p, level);
  const double volume = 1 * 2 * 0.5;
  EXPECT_GT(chords.p_of_mean(4 * volume / all), level) << "the mean chord is 4 V / S";
}

TEST(Lights, nothing_comes_through_periodic_sides) {
  Lit lit({scene::EnvironmentLight{}, scene::DirectionalLight{{1, 1, 1}, glm::dvec3(1)}});
  lit.scene.medium.sides = {scene::Side::periodic, scene::Side::open, scene::Side::periodic};
  lit.prepare_again();
  for (const Emitter& e : lit.prepared.emitters) {
    const Face face = e.light.is<lights::Parallel>()
                          ? e.light.as<lights::Parallel>().face
                          : e.light.as<lights::ConstantEnvironment>().face;
    EXPECT_EQ(face / 2, 1);
  }
  EXPECT_EQ(lit.prepared.emitters.size(), 3u);
}

TEST(Lights, are_chosen_in_proportion_to_their_power_and_give_their_colour) {
  const glm::dvec3 inside(0.5, 1, 0.25);
  const std::vector<double> powers = {1, 7, 2, 0.01, 5};
  std::vector<scene::Light> lights;
  for (std::size_t i = 0; i < powers.size(); ++i) {
    lights.push_back(scene::PointLight{inside + glm::dvec3(0.01 * double(i), 0, 0),
                                       powers[i] * glm::dvec3(0.5, 1, 0.25)});
  }
  lights.push_back(scene::PointLight{inside, glm::dvec3(0)});  // a black light has no emitter
  const Lit lit(lights);
  ASSERT_EQ(lit.prepared.emitters.size(), powers.size());
  std::vector<std::int64_t> counts(powers.size(), 0);
  for (std::uint64_t i = 0; i < photons; ++i) {
    const Photon photon = lit.photon(i);
    ++counts[static_cast<std::size_t>(std::lround((photon.ray.origin.x - 0.5f) / 0.01f))];
    ASSERT_EQ(photon.weight.x, 0.5f);
    ASSERT_EQ(photon.weight.y, 1.0f);
    ASSERT_EQ(photon.weight.z, 0.25f);
  }
  EXPECT_GT(chi_square_test(counts, powers).p, level);
  EXPECT_NEAR(lit.prepared.shot_power, 15.01, 1e-12);
}

TEST(Lights, the_extreme_words_choose_the_first_and_the_last) {
  const Lit lit({scene::PointLight{{0.25, 1, 0.25}, glm::dvec3(1)},
                 scene::PointLight{{0.75, 1, 0.25}, glm::dvec3(1)}});
  const Lights lights{lit.prepared.emitters.data(), 2};
  EXPECT_EQ(emit(lights, lit.box, {0, 0, 0, 0}, {}).ray.origin.x, 0.25f);
  EXPECT_EQ(emit(lights, lit.box, {0x7fffffff, 0, 0, 0}, {}).ray.origin.x, 0.25f);
  EXPECT_EQ(emit(lights, lit.box, {0x80000000, 0, 0, 0}, {}).ray.origin.x, 0.75f);
  EXPECT_EQ(emit(lights, lit.box, {0xffffffff, 0, 0, 0}, {}).ray.origin.x, 0.75f);
}

TEST(Lights, positions_are_relative_to_the_box) {
  const Lit lit({scene::PointLight{{1e6 + 0.5, 1, 3}, glm::dvec3(1)}}, {1e6, 0, 2},
                {1e6 + 1, 2, 4});
  const Vec3f p = lit.photon(0).ray.origin;
  EXPECT_EQ(p.x, 0.5f);
  EXPECT_EQ(p.z, 1.0f);
}

}  // namespace
}  // namespace tyndall::test
