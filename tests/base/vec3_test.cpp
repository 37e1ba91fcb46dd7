#include "tyndall/base/vec3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "support/statistics.h"

namespace tyndall {
namespace {

struct Exact {
  double x, y, z;
  explicit Exact(Vec3f v) : x(v.x), y(v.y), z(v.z) {}
};
double dot(Exact a, Exact b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Random directions, the poles, their neighbours, and everything with a zero or a tiny component.
std::vector<Vec3f> directions() {
  std::vector<Vec3f> all;
  for (float tiny :
       {0.0f, -0.0f, 1e-38f, -1e-38f, 1e-20f, -1e-20f, 1e-7f, -1e-7f, 1e-4f, -1e-4f, 1e-3f}) {
    for (float other : {0.0f, 1e-20f, -1e-7f, 3e-4f}) {
      for (float one : {1.0f, -1.0f}) {
        all.push_back(normalize(Vec3f{tiny, other, one}));
        all.push_back(normalize(Vec3f{tiny, one, other}));
        all.push_back(normalize(Vec3f{one, tiny, other}));
      }
    }
  }
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 20000; ++i)
    all.push_back(normalize(Vec3f{normal(random), normal(random), normal(random)}));
  return all;
}

TEST(Vec3, arithmetic_is_by_component) {
  const Vec3f a{1, 2, 3}, b{4, -5, 6};
  const auto same = [](Vec3f u, Vec3f v) { return u.x == v.x && u.y == v.y && u.z == v.z; };
  EXPECT_TRUE(same(a + b, {5, -3, 9}));
  EXPECT_TRUE(same(a - b, {-3, 7, -3}));
  EXPECT_TRUE(same(a * b, {4, -10, 18}));
  EXPECT_TRUE(same(2.0f * a, {2, 4, 6}));
  EXPECT_TRUE(same(cross(a, b), {27, 6, -13}));
  EXPECT_EQ(tyndall::dot(a, b), 12.0f);
  EXPECT_EQ(length(Vec3f{2, 3, 6}), 7.0f);
  EXPECT_EQ(largest(b), 6.0f);
  EXPECT_EQ(largest(Vec3f{-3, -2, -5}), -2.0f);
}

TEST(Vec3, frames_are_orthonormal_and_right_handed_everywhere) {
  for (const Vec3f axis : directions()) {
    const Exact s(to_frame_of(axis, {1, 0, 0})), t(to_frame_of(axis, {0, 1, 0})),
        z(to_frame_of(axis, {0, 0, 1}));
    const double tolerance = 5e-7;
    ASSERT_NEAR(dot(s, s), 1, tolerance) << axis.x << ' ' << axis.y << ' ' << axis.z;
    ASSERT_NEAR(dot(t, t), 1, tolerance) << axis.x << ' ' << axis.y << ' ' << axis.z;
    ASSERT_NEAR(dot(s, t), 0, tolerance) << axis.x << ' ' << axis.y << ' ' << axis.z;
    ASSERT_NEAR(dot(s, Exact(axis)), 0, tolerance) << axis.x << ' ' << axis.y << ' ' << axis.z;
    ASSERT_NEAR(dot(t, Exact(axis)), 0, tolerance) << axis.x << ' ' << axis.y << ' ' << axis.z;
    ASSERT_EQ(z.x, axis.x);
    ASSERT_EQ(z.y, axis.y);
    ASSERT_EQ(z.z, axis.z);
    const double handed = (s.y * t.z - s.z * t.y) * z.x + (s.z * t.x - s.x * t.z) * z.y
                          + (s.x * t.y - s.y * t.x) * z.z;
    ASSERT_NEAR(handed, 1, tolerance);
  }
}

TEST(Vec3, directions_around_an_axis_have_its_cosine_and_unit_length) {
  std::mt19937 random(2);
  for (const Vec3f axis : directions()) {
    const float cosine = 1.0f - 2.0f * static_cast<float>(random() >> 8) * 0x1p-24f;
    const Vec3f d = direction_around(axis, cosine, static_cast<float>(random() >> 8) * 0x1p-24f);
    ASSERT_NEAR(dot(Exact(d), Exact(d)), 1, 5e-7);
    ASSERT_NEAR(dot(Exact(d), Exact(axis)), cosine, 6e-7);
  }
  for (float cosine : {1.0f, -1.0f}) {
    const Vec3f d = direction_around({0, 0, 1}, cosine, 0.3f);
    EXPECT_EQ(d.z, cosine);
    EXPECT_EQ(d.x, 0.0f);
  }
}

TEST(Vec3, turns_go_evenly_around_the_axis) {
  std::mt19937 random(3);
  const Vec3f axis = normalize(Vec3f{0.3f, -0.5f, -0.8f});
  const Vec3f s = to_frame_of(axis, {1, 0, 0}), t = to_frame_of(axis, {0, 1, 0});
  std::vector<std::int64_t> octants(8);
  for (int i = 0; i < 80000; ++i) {
    const Vec3f d =
        direction_around(axis, 0.2f, (static_cast<float>(random() >> 9) + 0.5f) * 0x1p-23f);
    const double turn = std::atan2(tyndall::dot(d, t), tyndall::dot(d, s)) / (2 * M_PI);
    ++octants[static_cast<std::size_t>(std::min(7.0, 8 * (turn < 0 ? turn + 1 : turn)))];
  }
  EXPECT_GT(test::chi_square_test(octants).p, 1e-4);
}

TEST(Vec3, affine_maps_are_rows_and_an_offset) {
  const Affine map{{1, 2, 3}, {0, -1, 0.5f}, {4, 0, 0}, {10, 20, 30}};
  const Vec3f p = map({1, 2, 4});
  EXPECT_EQ(p.x, 27.0f);
  EXPECT_EQ(p.y, 20.0f);
  EXPECT_EQ(p.z, 34.0f);
  const Vec3f q = Affine{}({1.5f, -2.25f, 0.125f});
  EXPECT_EQ(q.x, 1.5f);
  EXPECT_EQ(q.y, -2.25f);
  EXPECT_EQ(q.z, 0.125f);
}

}  // namespace
}  // namespace tyndall
