#include "tyndall/transport/camera.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>

#include <glm/geometric.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

PreparedScene prepared(const scene::Camera& c, glm::dvec3 box_min = {0, 0, 0}) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.medium.box_min = box_min;
  scene.medium.box_max = box_min + glm::dvec3(1);
  scene.camera = c;
  return prepare(scene, 1);
}

/// The prepared camera, without its filter.
Camera camera(const scene::Camera& c, glm::dvec3 box_min = {0, 0, 0}) {
  return prepared(c, box_min).camera;
}

glm::dvec3 direction(const Camera& c, double u, double v) {
  const Vec3f d = c.ray(static_cast<float>(u), static_cast<float>(v)).direction;
  return {d.x, d.y, d.z};
}

double degrees(glm::dvec3 a, glm::dvec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / double{pi};
}

scene::Camera tilted() {
  scene::Camera c;
  c.position = {1, -2, 3};
  c.look_at = {0.2, 0.4, 0.1};
  c.up = {0.1, 1, 0.3};
  c.fov = 50;
  c.resolution = {300, 100};
  return c;
}

TEST(Camera, looks_at_its_target_from_its_place) {
  const scene::Camera c = tilted();
  const Camera pinhole = camera(c);
  EXPECT_EQ(pinhole.ray(0.2f, 0.9f).origin.y, -2.0f);
  EXPECT_LT(degrees(direction(pinhole, 0.5, 0.5), c.look_at - c.position), 1e-4);
}

TEST(Camera, spans_its_angle_across_the_width_and_has_square_pixels) {
  const Camera c = camera(tilted());
  EXPECT_NEAR(degrees(direction(c, 0, 0.5), direction(c, 1, 0.5)), 50, 1e-4);
  const double tangent = std::tan(25 * double{pi} / 180) / 3;
  EXPECT_NEAR(degrees(direction(c, 0.5, 0), direction(c, 0.5, 1)),
              2 * std::atan(tangent) * 180 / double{pi}, 1e-4);
}

TEST(Camera, u_runs_right_and_v_runs_down) {
  scene::Camera c;  // looks along +z, y is up: x runs left
  const Camera pinhole = camera(c);
  EXPECT_LT(direction(pinhole, 1, 0.5).x, -0.3);
  EXPECT_GT(direction(pinhole, 0, 0.5).x, 0.3);
  EXPECT_GT(direction(pinhole, 0.5, 0).y, 0.3);
  EXPECT_LT(direction(pinhole, 0.5, 1).y, -0.3);
}

TEST(Camera, straight_lines_stay_straight_and_evenly_divided) {
  const scene::Camera c = tilted();
  const Camera pinhole = camera(c);
  const glm::dvec3 forward = glm::normalize(c.look_at - c.position);
  const auto on_plane = [&](double u, double v) {
    const glm::dvec3 d = direction(pinhole, u, v);
    return d / glm::dot(d, forward);
  };
  const glm::dvec3 middle = on_plane(0.5, 0.5), right = on_plane(1, 0.5) - middle,
                   down = on_plane(0.5, 1) - middle;
  EXPECT_NEAR(glm::dot(right, down), 0, 1e-7);
  EXPECT_NEAR(glm::dot(right, forward), 0, 1e-6);
  for (double u = 0; u <= 1; u += 0.125) {
    for (double v = 0; v <= 1; v += 0.125) {
      const glm::dvec3 expected = middle + (2 * u - 1) * right + (2 * v - 1) * down;
      ASSERT_LT(glm::length(on_plane(u, v) - expected), 1e-6);
      ASSERT_NEAR(glm::length(direction(pinhole, u, v)), 1, 1e-6);
    }
  }
}

TEST(Camera, is_placed_relative_to_the_box) {
  scene::Camera c;
  c.position = {1e6 + 0.5, 0.25, -2};
  c.look_at = {1e6 + 0.5, 0.25, 0};
  const Camera pinhole = camera(c, {1e6, 0, 0});
  EXPECT_EQ(pinhole.position.x, 0.5f);
  EXPECT_EQ(pinhole.forward.z, 1.0f);
}

glm::dvec3 to_dvec3(Vec3f v) { return {v.x, v.y, v.z}; }

/// The axes of an image, computed from the scene's camera.
struct Axes {
  glm::dvec3 forward, right, up;
};
Axes axes(const scene::Camera& c) {
  const glm::dvec3 forward = glm::normalize(c.look_at - c.position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, c.up));
  return {forward, right, glm::cross(right, forward)};
}

TEST(Camera, focal_length_and_film_width_say_the_field_of_view) {
  scene::Camera c = tilted();
  c.focal_length = 35;
  const double half = std::atan(18.0 / 35) * 180 / double{pi};
  Camera pinhole = camera(c);
  EXPECT_NEAR(degrees(direction(pinhole, 0, 0.5), direction(pinhole, 1, 0.5)), 2 * half, 1e-4);
  c.film_width = 24;
  c.focal_length = 12;
  pinhole = camera(c);
  EXPECT_NEAR(degrees(direction(pinhole, 0, 0.5), direction(pinhole, 1, 0.5)), 90, 1e-4);
}

// The rays of an image point through all points of the lens meet where the ray through the lens's
// centre hits the plane in focus. Their origins are uniform on the lens.
TEST(Camera, rays_through_the_lens_meet_in_the_plane_in_focus) {
  scene::Camera c = tilted();
  c.aperture_radius = 0.25;
  const auto [forward, right, up] = axes(c);
  for (const double distance : {0.0, 1.5, 40.0}) {
    c.focus_distance = distance;
    const double focus = distance > 0 ? distance : glm::length(c.look_at - c.position);
    const Camera lens = camera(c);
    std::vector<std::int64_t> rings(8), sectors(8);
    double farthest = 0;
    std::uint64_t index = 0;
    for (const double u : {0.0, 0.3, 1.0}) {
      for (const double v : {0.0, 0.5, 0.9}) {
        const glm::dvec3 middle = direction(lens, u, v);
        const glm::dvec3 met = c.position + focus / glm::dot(middle, forward) * middle;
        for (int i = 0; i < 2000; ++i) {
          const RandomBlock r =
              RandomStream{1, index++, Domain::pixel_sample}.block(0, Purpose::aim);
          const Ray ray = lens.ray_through_lens(static_cast<float>(u), static_cast<float>(v),
                                                uniform(r.a), uniform(r.b));
          const glm::dvec3 o = to_dvec3(ray.origin), d = to_dvec3(ray.direction);
          ASSERT_NEAR(glm::dot(o - c.position, forward), 0, 1e-6);
          const glm::dvec3 there = o + glm::dot(met - o, forward) / glm::dot(d, forward) * d;
          ASSERT_LT(glm::length(there - met), 4e-6 * (1 + focus)) << u << " " << v;
          ASSERT_NEAR(glm::length(d), 1, 1e-6);
          const double x = glm::dot(o - c.position, right), y = glm::dot(o - c.position, up);
          const double share = (x * x + y * y) / (0.25 * 0.25);
          farthest = std::max(farthest, share);
          ++rings[static_cast<std::size_t>(std::min(share * 8, 7.0))];
          ++sectors[static_cast<std::size_t>(
              std::min((std::atan2(y, x) / (2 * double{pi}) + 0.5) * 8, 7.0))];
        }
      }
    }
    EXPECT_LT(farthest, 1 + 1e-5);
    EXPECT_GT(chi_square_test(rings).p, 1e-4);
    EXPECT_GT(chi_square_test(sectors).p, 1e-4);
  }
}

TEST(Camera, orthographic_rays_are_parallel_and_start_in_a_plane) {
  scene::Camera c = tilted();
  c.projection = scene::Projection::orthographic;
  c.width = 6;
  const Camera parallel = camera(c);
  const auto [forward, right, up] = axes(c);
  for (double u = 0; u <= 1; u += 0.25) {
    for (double v = 0; v <= 1; v += 0.25) {
      const Ray ray = parallel.ray(static_cast<float>(u), static_cast<float>(v));
      const glm::dvec3 expected = c.position + (6 * u - 3) * right + (1 - 2 * v) * up;
      ASSERT_LT(glm::length(to_dvec3(ray.origin) - expected), 2e-6);
      ASSERT_LT(glm::length(to_dvec3(ray.direction) - forward), 1e-7);
    }
  }
}

TEST(Camera, spherical_rays_go_by_longitude_and_latitude) {
  scene::Camera c = tilted();
  c.projection = scene::Projection::spherical;
  const Camera all = camera(c);
  const auto [forward, right, up] = axes(c);
  const int n = 256, m = 128;
  double solid_angle = 0;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= m; ++j) {
      const double u = double{1} * i / n, v = double{1} * j / m;
      const double longitude = (2 * u - 1) * double{pi}, latitude = v * double{pi};
      const glm::dvec3 expected =
          std::sin(latitude) * (std::cos(longitude) * forward + std::sin(longitude) * right)
          + std::cos(latitude) * up;
      ASSERT_LT(glm::length(direction(all, u, v) - expected), 1e-6);
      if (i == n || j == m) continue;
      // The area of a small quadrilateral: half the parallelogram spanned by its diagonals.
      const double w = 1.0 / n, h = 1.0 / m;
      solid_angle += 0.5
                     * glm::length(glm::cross(direction(all, u + w, v + h) - direction(all, u, v),
                                              direction(all, u, v + h) - direction(all, u + w, v)));
    }
  }
  EXPECT_NEAR(solid_angle, 4 * double{pi}, 0.002);
  EXPECT_LT(degrees(direction(all, 0.5, 0.5), c.look_at - c.position), 1e-4);
  EXPECT_EQ(to_dvec3(all.ray(0.2f, 0.9f).origin), c.position);
}

TEST(Camera, a_matrix_places_it_as_look_at_does) {
  for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic,
                                scene::Projection::spherical}) {
    scene::Camera c = tilted();
    c.projection = projection;
    const Camera looking = camera(c);
    const auto [forward, right, up] = axes(c);
    glm::dmat4 m(1);
    m[0] = glm::dvec4(right, 0), m[1] = glm::dvec4(up, 0), m[2] = glm::dvec4(-forward, 0);
    m[3] = glm::dvec4(c.position, 1);
    c.matrix = m;
    c.position = {7, 8, 9};  // not used
    c.look_at = {9, 9, 9};
    const Camera placed = camera(c);
    for (const float u : {0.0f, 0.4f, 1.0f}) {
      for (const float v : {0.0f, 0.7f, 1.0f}) {
        const Ray a = looking.ray(u, v), b = placed.ray(u, v);
        EXPECT_LT(length(a.origin - b.origin), 5e-7f);
        EXPECT_LT(length(a.direction - b.direction), 5e-7f);
      }
    }
  }
}

// ---- Crop windows

TEST(CropWindow, has_the_streams_of_the_whole_picture) {
  const CropWindow window{7, 5, 2, 1, 3, 4};
  EXPECT_EQ(window.stream(0, 0), 9u);
  for (std::uint64_t index = 0; index < 3 * window.pixel_count(); ++index) {
    const std::uint64_t pixel = index % 12, stream = window.stream(pixel, index / 12);
    EXPECT_EQ(stream / 35, index / 12);
    EXPECT_EQ(window.column(stream), 2 + static_cast<int>(pixel % 3));
    EXPECT_EQ(window.row(stream), 1 + static_cast<int>(pixel / 3));
    EXPECT_EQ(window.pixel(stream), pixel);
  }
}

TEST(CropWindow, has_the_pixels_of_the_whole_picture_bit_for_bit) {
  Scene scene = furnace({component(low_variation(5), 20, 0.9, scene::HenyeyGreensteinPhase{0.5})});
  scene.medium.majorant_resolution = {6, 5, 4};
  scene.lights = {scene::PointLight{{1.5, 2, -0.5}, glm::dvec3(50)}};
  scene.background = {0.25, 0.5, 1};
  scene.photons = 2000;
  scene.illumination_resolution = {6, 5, 4};
  scene.samples = 3;
  scene.camera.resolution = {21, 16};
  scene.camera.aperture_radius = 0.2;
  scene.filter = scene::Filter::gaussian;
  const auto backend = make_cpu_backend();
  for (const auto sampler : {scene::Sampler::super_voxel, scene::Sampler::woodcock}) {
    scene.sampler = sampler;
    scene.camera.crop = {0, 0, 0, 0};
    const Picture whole = render(scene, *backend).picture;
    EXPECT_EQ(whole.whole_width, 21);
    for (const std::array<int, 4>& crop :
         {std::array{5, 2, 17, 13}, std::array{0, 0, 21, 16}, std::array{20, 15, 21, 16}}) {
      scene.camera.crop = crop;
      const Picture part = render(scene, *backend).picture;
      EXPECT_EQ(part.left, crop[0]);
      EXPECT_EQ(part.top, crop[1]);
      EXPECT_EQ(part.whole_height, 16);
      ASSERT_EQ(part.width, crop[2] - crop[0]);
      ASSERT_EQ(part.height, crop[3] - crop[1]);
      for (int y = 0; y < part.height; ++y) {
        const auto row = static_cast<std::size_t>((crop[1] + y) * 21 + crop[0]);
        EXPECT_EQ(std::memcmp(&part.rgba[static_cast<std::size_t>(4 * y * part.width)],
                              &whole.rgba[4 * row],
                              static_cast<std::size_t>(part.width) * 4 * sizeof(float)),
                  0);
      }
    }
  }
}

// ---- Filters

/// The cumulative distribution function: the probability of values below x.
using Distribution = std::function<double(double)>;

double filter_p(scene::Filter filter, double radius, const Distribution& below) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.filter = filter;
  scene.filter_radius = radius;
  const PreparedScene ready = prepare(scene, 1);
  std::vector<double> places;
  for (std::uint64_t i = 0; i < 100000; ++i) {
    const RandomBlock r = RandomStream{3, i, Domain::pixel_sample}.block(0, Purpose::emission);
    places.push_back(ready.camera.filter.place(uniform(r.a)) - 0.5);
  }
  return kolmogorov_smirnov_test(places, below);
}

TEST(PixelFilter, samples_are_distributed_as_the_filter) {
  const double exact_pi = 3.14159265358979323846;
  for (const double radius : {0.3, 2.0}) {
    EXPECT_GT(
        filter_p(scene::Filter::box, radius, [=](double x) { return 0.5 + 0.5 * x / radius; }),
        1e-4);
  }
  for (const double radius : {0.0, 0.5, 4.0}) {
    const double r = radius > 0 ? radius : 1.5;
    EXPECT_GT(filter_p(scene::Filter::gaussian, radius,
                       [=](double x) {
                         return 0.5
                                + 0.5 * std::erf(3 * x / r / std::sqrt(2.0))
                                      / std::erf(3 / std::sqrt(2.0));
                       }),
              1e-4);
    EXPECT_GT(filter_p(scene::Filter::blackman_harris, radius,
                       [=](double x) {
                         const double a = exact_pi * x / r;
                         return 0.5
                                + (0.35875 * a + 0.48829 * std::sin(a)
                                   + 0.14128 * std::sin(2 * a) / 2 + 0.01168 * std::sin(3 * a) / 3)
                                      / (2 * exact_pi * 0.35875);
                       }),
              1e-4);
  }
}

TEST(PixelFilter, the_usual_box_leaves_its_numbers_as_they_are) {
  const PreparedScene ready = prepared(tilted());
  for (const float u : {1e-9f, 0.1f, 0.5f, 0.7654321f, 0.99999994f})
    EXPECT_EQ(ready.camera.filter.place(u), u);
}

// ---- In the medium

// From the centre of an absorbing ball all directions are equally dark; of a glowing one, equally
// bright.
TEST(Camera, sees_from_within_the_medium) {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{glm::dvec3(0.5), 0.4}}, 2.5, 0)});
  scene.lights = {};
  scene.background = glm::dvec3(1);
  scene.camera.projection = scene::Projection::spherical;
  scene.camera.position = glm::dvec3(0.5);
  scene.camera.look_at = {0.5, 0.5, 0.75};
  scene.camera.resolution = {32, 16};
  scene.samples = 64;
  scene.photons = 1;
  const auto alpha = [](const RenderResult& result) {
    double hits = 0;
    for (std::size_t i = 3; i < result.picture.rgba.size(); i += 4) hits += result.picture.rgba[i];
    return static_cast<std::int64_t>(hits * 64 + 0.5);
  };
  const auto backend = make_cpu_backend();
  RenderResult result = render(scene, *backend);
  const double absorbed = 1 - std::exp(-1.0);
  EXPECT_GT(proportion_p(alpha(result), 32 * 16 * 64, absorbed), 1e-4);
  EXPECT_NEAR(mean_of_picture(result), 1 - static_cast<double>(alpha(result)) / (32 * 16 * 64),
              1e-6);

  scene.background = glm::dvec3(0);
  scene.medium.components[0].emission = scene::ColorEmission{{2, 2, 2}, scene::Solid{}};
  result = render(scene, *backend);
  EXPECT_GT(proportion_p(alpha(result), 32 * 16 * 64, absorbed), 1e-4);
  EXPECT_NEAR(mean_of_picture(result), 2.0 * static_cast<double>(alpha(result)) / (32 * 16 * 64),
              1e-5);
}

}  // namespace
}  // namespace tyndall::test
