/// \file
/// Cameras too far away for float positions have the same images as near ones.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "render/camera.h"
#include "support/scenes.h"
#include "tyndall/transport/camera.h"

namespace tyndall::test {
namespace {

glm::dvec3 to_dvec3(Vec3f v) { return {v.x, v.y, v.z}; }

const std::vector<glm::dvec3> directions = {
    {0, 0, -1}, {0, 0.70710678, 0.70710678}, {1, 0, 0}, {0.48, -0.6, 0.64}, {-0.6, 0.64, 0.48}};

/// A camera whose image is `across` wide at the centre of the unit box.
scene::Camera distant(glm::dvec3 direction, double distance, double across = 1.4) {
  scene::Camera c;
  c.look_at = glm::dvec3(0.5);
  c.position = c.look_at + distance * glm::normalize(direction);
  c.up = std::abs(direction.y) > 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  c.fov = 2 * std::atan(0.5 * across / distance) * 180 / 3.14159265358979323846;
  c.width = across;
  c.resolution = {48, 32};
  return c;
}

PreparedScene prepared(const scene::Camera& c) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.camera = c;
  return prepare(scene, 1);
}

struct Line {
  glm::dvec3 position, direction;
};

/// The ray of a sample in double precision, computed from the scene's camera.
Line exact(const scene::Camera& c, const Camera& drawn, const RandomStream& random) {
  const glm::dvec3 forward = glm::normalize(c.look_at - c.position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, c.up));
  const glm::dvec3 up = glm::cross(right, forward);
  const RandomBlock first = random.block(0, Purpose::emission);
  const double u =
      (drawn.window.column(random.index) + double{drawn.filter.place(uniform(first.a))})
      / c.resolution[0];
  const double v = (drawn.window.row(random.index) + double{drawn.filter.place(uniform(first.b))})
                   / c.resolution[1];
  const double aspect = double{1} * c.resolution[1] / c.resolution[0];
  const double x = 2 * u - 1, y = (1 - 2 * v) * aspect;
  if (c.projection == scene::Projection::orthographic)
    return {c.position + 0.5 * c.width * (x * right + y * up), forward};
  if (c.projection == scene::Projection::spherical) {
    const double longitude = 2 * 3.14159265358979323846 * u, latitude = 3.14159265358979323846 * v;
    return {c.position,
            std::sin(latitude) * (-std::cos(longitude) * forward - std::sin(longitude) * right)
                + std::cos(latitude) * up};
  }
  const double tangent = half_tangent(c);  // rounded as in the camera
  const glm::dvec3 middle = forward + tangent * (x * right + y * up);
  if (c.aperture_radius == 0) return {c.position, glm::normalize(middle)};
  const RandomBlock aim = random.block(0, Purpose::aim);
  const double radius = c.aperture_radius * std::sqrt(double{uniform(aim.a)});
  const double turn = 2 * 3.14159265358979323846 * double{uniform(aim.b)};
  const glm::dvec3 offset = radius * (std::cos(turn) * right + std::sin(turn) * up);
  const double focus =
      c.focus_distance > 0 ? c.focus_distance : glm::length(c.look_at - c.position);
  return {c.position + offset, glm::normalize(middle - offset / focus)};
}

/// \return the largest distance between the rays of samples and exact rays, where the latter pass
/// the centre of the box [length]; over rays that pass within `near` of it.
double largest_error(const scene::Camera& c, double near = 2) {
  const PreparedScene ready = prepared(c);
  double most = 0;
  int passing = 0;
  for (std::uint64_t pixel = 0; pixel < ready.pixels(); pixel += 5) {
    for (std::uint64_t sample = 0; sample < 4; ++sample) {
      const RandomStream random{3, ready.camera.window.stream(pixel, sample), Domain::pixel_sample};
      const Line line = exact(c, ready.camera, random);
      const double along = glm::dot(glm::dvec3(0.5) - line.position, line.direction);
      const glm::dvec3 there = line.position + along * line.direction;
      if (along < 0 || glm::length(there - glm::dvec3(0.5)) > near) continue;
      ++passing;
      const Ray ray = ready.camera.sample(random, random.block(0, Purpose::emission));
      const glm::dvec3 way = there - to_dvec3(ray.origin), d = to_dvec3(ray.direction);
      EXPECT_GT(glm::dot(way, d), 0) << "it begins in the medium";
      most = std::max(most, glm::length(glm::cross(way, d)));
    }
  }
  EXPECT_GT(passing, 100);
  return most;
}

TEST(FarCamera, rays_are_exact_at_the_medium_whatever_the_distance) {
  for (const double distance : {1e3, 1e6, 1e8, 5e8}) {
    for (const glm::dvec3 direction : directions) {
      SCOPED_TRACE(testing::Message()
                   << distance << " along " << direction.x << " " << direction.y);
      scene::Camera c = distant(direction, distance);
      EXPECT_LT(largest_error(c), 1e-6);
      c.projection = scene::Projection::orthographic;
      EXPECT_LT(largest_error(c), 1e-6);
      c.projection = scene::Projection::perspective;
      c.aperture_radius = 0.3 * distance;
      c.focus_distance = distance * (1 + 1 / distance);  // one box behind the middle
      EXPECT_LT(largest_error(c), 2e-6);
    }
  }
}

// The medium lies in a corner of the image, and in one pixel of it.
TEST(FarCamera, rays_are_exact_off_the_axis) {
  scene::Camera c = distant({0.48, -0.6, 0.64}, 5000);
  c.look_at += 2000.0 * glm::normalize(glm::cross(c.look_at - c.position, c.up));
  c.look_at.y += 100;
  c.fov = 60;
  c.resolution = {65536, 32768};
  const PreparedScene ready = prepared(c);
  ASSERT_TRUE(ready.camera.is_far);
  scene::Camera part = c;
  const int column = ready.camera.far_view.column, row = ready.camera.far_view.row;
  part.crop = {column - 6, row - 6, column + 7, row + 7};
  EXPECT_LT(largest_error(part, 1), 1e-6);
}

TEST(FarCamera, near_ones_stay_as_they_are) {
  for (const glm::dvec3 direction : directions)
    EXPECT_FALSE(prepared(distant(direction, 100)).camera.is_far);
}

TEST(FarCamera, spherical_ones_see_the_medium_in_its_pixel) {
  for (const double distance : {1e3, 1e6, 1e8}) {
    for (const glm::dvec3 direction : directions) {
      scene::Camera c = distant(direction, distance);
      c.projection = scene::Projection::spherical;
      c.look_at += glm::dvec3(0.1, 0.2, 0.3) * distance;
      c.resolution = {65536, 32768};
      const PreparedScene whole = prepared(c);
      ASSERT_TRUE(whole.camera.is_far);
      scene::Camera part = c;
      const FarView& far = whole.camera.far_view;
      part.crop = {far.column - 6, far.row - 6, far.column + 7, far.row + 7};
      // The longitude is a float; its rounding moves the whole image.
      if (distance < 1e4) {
        EXPECT_LT(largest_error(part, 1), 4e-7 * distance);
      }
      const PreparedScene ready = prepared(part);
      const Ray middle = ready.camera.middle(6 + 13 * 6), next = ready.camera.middle(7 + 13 * 6);
      const double width = 2 * 3.14159265358979323846 * distance / c.resolution[0];
      const double latitude = 3.14159265358979323846 * (far.row + 0.5) / c.resolution[1];
      EXPECT_NEAR(glm::length(to_dvec3(next.origin) - to_dvec3(middle.origin)),
                  width * std::sin(latitude), 2e-3 * width);
      EXPECT_LT(glm::length(to_dvec3(middle.origin) - glm::dvec3(0.5)), 2 + 2 * width);
    }
  }
}

// ---- Pictures

/// Mean and second moments of alpha, in widths of the image.
struct Disc {
  double alpha = 0, xx = 0, yy = 0, xy = 0;
};
Disc disc_of(const RenderResult& result) {
  const int width = result.picture.width, height = result.picture.height;
  Disc disc;
  double x1 = 0, y1 = 0, sum = 0;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const double a =
          double{result.picture.rgba[static_cast<std::size_t>(4 * (j * width + i) + 3)]};
      const double x = (i + 0.5) / width, y = (j + 0.5) / width;
      sum += a, x1 += a * x, y1 += a * y;
      disc.xx += a * x * x, disc.yy += a * y * y, disc.xy += a * x * y;
    }
  }
  disc.alpha = sum / (width * height);
  disc.xx = disc.xx / sum - x1 * x1 / (sum * sum);
  disc.yy = disc.yy / sum - y1 * y1 / (sum * sum);
  disc.xy = disc.xy / sum - x1 * y1 / (sum * sum);
  return disc;
}

TEST(FarCamera, a_ball_is_a_round_disc_from_any_distance) {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{glm::dvec3(0.5), 0.4}}, 1000, 0)});
  scene.lights = {};
  scene.background = glm::dvec3(1);
  scene.integrator = scene::Integrator::path;
  scene.samples = 16;
  const double r = 0.4 / 1.4, whole = 48 * 48 * 16;
  const auto backend = make_cpu_backend();
  for (const double distance : {1e6, 1e7, 1e8}) {
    for (const glm::dvec3 direction : directions) {
      for (const bool has_lens : {false, true}) {
        scene.camera = distant(direction, distance);
        scene.camera.resolution = {48, 48};
        if (has_lens) scene.camera.aperture_radius = 0.1 * distance;
        const Disc disc = disc_of(render(scene, *backend));
        SCOPED_TRACE(testing::Message() << distance << " " << direction.x << " " << disc.alpha);
        const double expected = 3.14159265358979323846 * r * r;
        EXPECT_NEAR(disc.alpha, expected, 5 * std::sqrt(expected / whole));
        // The standard errors of the moments are below r^2 / 4 / sqrt(hits).
        const double error = 5 * 0.25 * r * r / std::sqrt(expected * whole);
        EXPECT_NEAR(disc.xx, 0.25 * r * r, has_lens ? 0.02 * r * r : error + 0.002 * r * r);
        EXPECT_NEAR(disc.xx, disc.yy, 2 * error);
        EXPECT_NEAR(disc.xy, 0, error);
      }
    }
  }
}

// Pixels that cannot hit the medium are not gathered if nothing else shines.
TEST(FarCamera, pixels_that_are_left_out_meet_nothing) {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{glm::dvec3(0.5), 0.5}}, 1000, 0.5)});
  scene.lights = {scene::PointLight{{2, 2, 2}, glm::dvec3(1)}};
  scene.integrator = scene::Integrator::path;
  scene.samples = 4;
  const auto backend = make_cpu_backend();
  for (const glm::dvec3 direction : directions) {
    for (const bool orthographic : {false, true}) {
      scene.camera = distant(direction, 1e8, 4);
      if (orthographic) scene.camera.projection = scene::Projection::orthographic;
      scene.background = glm::dvec3(1);
      const double all = mean_of_picture(render(scene, *backend), 3);
      scene.background = glm::dvec3(0);
      const PreparedScene ready = prepare(scene, 1);
      EXPECT_LT(ready.pixels_to_gather(), ready.pixels() / 2);
      EXPECT_GT(ready.pixels_to_gather(), ready.pixels() / 32);
      EXPECT_EQ(mean_of_picture(render(scene, *backend), 3), all);
      EXPECT_GT(all, 0.05);
    }
  }
}

// An infinite layer, seen at any of its periods and from within.
TEST(FarCamera, a_layer_is_as_deep_from_any_distance) {
  Scene scene = furnace({component(scene::Solid{}, 1.5, 0)});
  scene.medium.sides = {scene::Side::periodic, scene::Side::open, scene::Side::periodic};
  scene.lights = {};
  scene.background = glm::dvec3(1);
  scene.integrator = scene::Integrator::path;
  scene.samples = 8;
  const auto backend = make_cpu_backend();
  const auto alpha = [&] { return mean_of_picture(render(scene, *backend), 3); };
  const auto expect = [&](double cosine) {
    const double expected = 1 - std::exp(-1.5 / cosine);
    EXPECT_NEAR(alpha(), expected, 4 * std::sqrt(expected * (1 - expected) / (48 * 32 * 8)));
  };
  for (const double distance : {1e4, 1e8}) {
    for (const glm::dvec3 direction :
         {glm::dvec3(0, 1, 0), {0, -1, 0}, {0.6, 0.8, 0}, {0.48, 0.6, 0.64}}) {
      SCOPED_TRACE(testing::Message()
                   << distance << " along " << direction.x << " " << direction.y);
      scene.camera = distant(direction, distance);
      expect(std::abs(direction.y));
      scene.camera.projection = scene::Projection::orthographic;
      expect(std::abs(direction.y));
      scene.camera.position += glm::dvec3(3e7, 0, -2e7);
      scene.camera.look_at += glm::dvec3(3e7, 0, -2e7);
      expect(std::abs(direction.y));
    }
  }
  scene.camera = distant({0, 1, 0}, 0.5);  // at its upper face
  scene.camera.fov = 1e-3;
  scene.camera.position += glm::dvec3(3e8, 0, 0.25);
  scene.camera.look_at += glm::dvec3(3e8, 0, 0.25);
  expect(1);
}

// If the whole layer is in view, from its near edge to its far one, none of it is cut off.
TEST(FarCamera, the_near_part_of_a_layer_is_not_cut_off) {
  Scene scene = furnace({component(scene::Solid{}, 1000, 0)});
  scene.medium.sides = {scene::Side::periodic, scene::Side::open, scene::Side::periodic};
  scene.lights = {};
  scene.background = glm::dvec3(1);
  scene.integrator = scene::Integrator::path;
  scene.samples = 4;
  scene.camera = distant({0, 0.8, 0.6}, 1e6);
  scene.camera.fov = 60;
  EXPECT_EQ(mean_of_picture(render(scene, *make_cpu_backend()), 3), 1);
}

// ---- Distances from the camera

TEST(FarCamera, depth_is_measured_from_the_camera) {
  Scene scene = furnace({component(scene::Solid{}, 200, 0.5)});
  for (const bool orthographic : {false, true}) {
    scene.camera = distant({0, 0, -1}, 4096);
    scene.camera.resolution = {5, 5};
    scene.samples = 1, scene.photons = 1;
    if (orthographic) scene.camera.projection = scene::Projection::orthographic;
    const RenderResult result = render(scene, *make_cpu_backend());
    EXPECT_NEAR(layer(result, "depth").values[12], 4095.5 + std::log(2.0) / 200, 1e-3);
  }
}

/// The fraction of the image covered by a light of radiance 1, with almost no medium. The
/// background keeps the film's range above 1 even if the light is tiny.
double seen(scene::Light light, const scene::Camera& camera) {
  Scene scene = furnace({component(scene::Solid{}, 1e-9, 0)});
  scene.lights = {std::move(light)};
  scene.background = glm::dvec3(1e-3);
  scene.integrator = scene::Integrator::path;
  scene.camera = camera;
  scene.camera.resolution = {48, 48};
  scene.samples = 16;
  return mean_of_picture(render(scene, *make_cpu_backend())) - 1e-3;
}

TEST(FarCamera, lights_are_seen_wherever_they_are) {
  const scene::Camera c = distant({0, 0, -1}, 1e8);
  const double whole = 48 * 48 * 16;
  const auto expect = [&](const scene::Light& light, double expected) {
    EXPECT_NEAR(seen(light, c), expected, 5 * std::sqrt(expected * (1 - expected) / whole) + 1e-6);
  };
  const double one = 3.14159265358979323846 * 0.04 / (1.4 * 1.4);
  const auto ball = [](double z, double radius) {
    return scene::SphereLight{{0.5, 0.5, z}, radius, glm::dvec3(1)};
  };
  expect(ball(0.5, 0.2), one);   // in the medium
  expect(ball(-3, 0.2), one);    // close in front of it
  expect(ball(10, 0.2), one);    // behind it
  expect(ball(-5e7, 0.1), one);  // half way
  expect(ball(-1.5e8, 0.2), 0);  // behind the camera
  const auto plate = [](double z, double edge) {
    return scene::RectangleLight{
        {0.5, 0.5, z}, {0, edge, 0}, {edge, 0, 0}, glm::dvec3(1)};  // emits towards -z
  };
  const double plate_seen = 0.36 / (1.4 * 1.4);
  const double front = seen(plate(-3, 0.6), c), back = seen(plate(3, 0.6), c);
  EXPECT_NEAR(front, plate_seen, 5 * std::sqrt(plate_seen / whole));
  EXPECT_NEAR(back, plate_seen, 5 * std::sqrt(plate_seen / whole));
  EXPECT_NEAR(seen(plate(-1.5e8, 0.6), c), 0, 1e-6);
}

}  // namespace
}  // namespace tyndall::test
