/// \file
/// The walk of photons: scattering angles, numbers of collisions, lengths of paths, and thin media
/// beside dense ones.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/scenes.h"
#include "tyndall/render/parallel.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

/// Follows a photon of the shoot pass in a medium that only scatters. Calls see(flight, before,
/// path) after every flight, where `before` is the ray at its start.
template <class See>
void follow(const PreparedScene& scene, std::uint64_t index, See&& see) {
  std::visit(
      [&](const auto& medium) {
        const RandomStream random{scene.seed, index, Domain::photon};
        const RandomBlock first = random.block(0, Purpose::emission);
        const Lights lights{scene.emitters.data(), static_cast<int>(scene.emitters.size())};
        Path path{emit(lights, medium.whole.box, first, random.block(0, Purpose::aim)).ray,
                  exponential(first.d),
                  0,
                  {}};
        if (!enter(medium.whole.box, path.ray)) return;
        Audit audit;
        for (;;) {
          const Ray before = path.ray;
          const Flight flight = SuperVoxel{}.fly(medium, path, random, audit);
          if (flight.end == Flight::End::collided) {
            path.ray.direction =
                medium.component(flight.component)
                    .phase.sample(before.direction, uniform_symmetric(path.drawn.c),
                                  uniform_symmetric(path.drawn.d));
          }
          see(flight, before, path);
          if (flight.end != Flight::End::collided) return;
        }
      },
      scene.medium);
}

/// The series of value(photon) for n photons.
template <class Value>
Series measure(std::uint64_t n, Value&& value) {
  std::vector<double> values(n);
  parallel_for(0, n, 256, 0, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) values[i] = value(i);
  });
  Series series;
  for (const double v : values) series.add(v);
  return series;
}

/// A phase function with a peak, a gap and a floor.
scene::Phase table() {
  return scene::TabulatedPhase{std::make_shared<const scene::PhaseTable>(
      scene::PhaseTable{{-1, -0.5, 0, 0.5, 0.99, 1}, {1, 0, 0, 0.5, 8, 100}})};
}

double mean_cosine(const scene::Phase& phase) {
  if (const auto* lobes = std::get_if<scene::TwoLobesPhase>(&phase))
    return lobes->weight * lobes->g1 + (1 - lobes->weight) * lobes->g2;
  if (const auto* tabulated = std::get_if<scene::TabulatedPhase>(&phase)) {
    const auto& [cosines, values] = *tabulated->table;
    double sum = 0, all = 0;
    for (std::size_t i = 1; i < cosines.size(); ++i) {
      const double a = values[i - 1], b = values[i], width = cosines[i] - cosines[i - 1];
      sum += width / 6 * ((2 * a + b) * cosines[i - 1] + (a + 2 * b) * cosines[i]);
      all += width / 2 * (a + b);
    }
    return sum / all;
  }
  const auto* hg = std::get_if<scene::HenyeyGreensteinPhase>(&phase);
  return hg ? hg->g : 0.0;
}

// ---- Angles

TEST(Scattering, has_the_mean_cosine_of_its_phase_function_and_forwards_is_positive) {
  for (const scene::Phase& phase :
       {scene::Phase(scene::HenyeyGreensteinPhase{0.95}),
        scene::Phase(scene::HenyeyGreensteinPhase{-0.95}),
        scene::Phase(scene::HenyeyGreensteinPhase{0.3}), scene::Phase(scene::IsotropicPhase{}),
        scene::Phase(scene::RayleighPhase{}), scene::Phase(scene::TwoLobesPhase{0.9, -0.6, 0.75}),
        table()}) {
    for (const glm::dvec3& direction :
         {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(0.6, -0.3, -0.5)}) {
      Scene scene = slab(50, 1, phase);
      scene.lights = {scene::DirectionalLight{direction, glm::dvec3(1)}};
      const PreparedScene prepared = prepare(scene, 0);
      const Series cosine = measure(100000, [&](std::uint64_t i) {
        double first = 2;
        follow(prepared, i, [&](const Flight&, const Ray& before, const Path& path) {
          if (first == 2) first = dot(before.direction, path.ray.direction);
        });
        return first;
      });
      // With g = 0.95 the spread is small, so a systematic error of half a bit would show.
      EXPECT_GT(cosine.p_of_mean(mean_cosine(phase)), level)
          << "mean cosine " << cosine.mean() << ", expected " << mean_cosine(phase);
    }
  }
}

/// Photons through a slab of thickness 1 by a textbook Monte Carlo that shares no code with
/// Tyndall. It uses double precision, its own generator and its own inversion of Henyey-Greenstein.
struct Textbook {
  std::int64_t reflected = 0, transmitted = 0;

  Textbook(double optical_thickness, double albedo, double g, std::int64_t photons) {
    std::mt19937_64 engine(1);
    const auto uniform_number = [&] {
      return (static_cast<double>(engine() >> 11) + 0.5) * 0x1p-53;
    };
    for (std::int64_t n = 0; n < photons; ++n) {
      double depth = 0, cosine = 1;
      for (;;) {
        depth -= std::log(uniform_number()) * cosine;
        if (depth < 0) ++reflected;
        if (depth > optical_thickness) ++transmitted;
        if (depth < 0 || depth > optical_thickness || uniform_number() >= albedo) break;
        const double x = uniform_number(), s = (1 - g * g) / (1 + g * (2 * x - 1));
        const double turn_cosine = (1 + g * g - s * s) / (2 * g);
        const double turn_sine = std::sqrt(std::max(0.0, 1 - turn_cosine * turn_cosine));
        const double around = std::cos(2 * 3.14159265358979323846 * uniform_number());
        cosine = cosine * turn_cosine
                 + std::sqrt(std::max(0.0, 1 - cosine * cosine)) * turn_sine * around;
      }
    }
  }
};

double shares_p(std::int64_t a, std::int64_t n_a, std::int64_t b, std::int64_t n_b) {
  const double share = static_cast<double>(a + b) / static_cast<double>(n_a + n_b);
  const double difference = static_cast<double>(a) / static_cast<double>(n_a)
                            - static_cast<double>(b) / static_cast<double>(n_b);
  return normal_p(difference
                  / std::sqrt(share * (1 - share)
                              * (1 / static_cast<double>(n_a) + 1 / static_cast<double>(n_b))));
}

TEST(Scattering, sends_strongly_peaked_light_through_a_slab_as_a_textbook_does) {
  for (const double g : {0.95, -0.95, 0.5}) {
    Scene scene = slab(1.5, 0.95, scene::HenyeyGreensteinPhase{g});
    scene.photons = 1000000;
    const Ledger ledger = shoot(scene).account.ledger;
    const Textbook textbook(1.5, 0.95, g, 1000000);
    EXPECT_GT(shares_p(ledger.escaped[4], ledger.shot, textbook.reflected, 1000000), level);
    EXPECT_GT(shares_p(ledger.escaped[5], ledger.shot, textbook.transmitted, 1000000), level);
  }
}

// ---- Numbers of collisions

TEST(Scattering, in_an_endless_medium_ends_after_one_over_one_minus_albedo_collisions) {
  for (const bool noisy : {false, true}) {
    scene::NoiseCloud cloud = low_variation(4);
    cloud.body = scene::Everywhere{};
    cloud.coverage = 0.9;
    for (const double albedo : {0.5, 0.9, 0.99}) {
      Scene scene;
      scene.medium.sides.fill(scene::Side::periodic);
      scene.medium.majorant_resolution = {4, 5, 6};
      scene.medium.components = {
          noisy ? component(cloud, 6, albedo)
                : component(scene::Solid{}, 2, albedo, scene::HenyeyGreensteinPhase{0.4})};
      scene.lights = {scene::PointLight{{0.3, 0.4, 0.5}, glm::dvec3(1)}};
      scene.photons = albedo > 0.95 ? 20000 : 200000;
      const Account account = shoot(scene).account;
      const double mean =
          static_cast<double>(account.audit.real) / static_cast<double>(account.ledger.shot);
      const double spread = std::sqrt(albedo) / (1 - albedo);  // geometric distribution
      const double z =
          (mean - 1 / (1 - albedo)) / spread * std::sqrt(static_cast<double>(account.ledger.shot));
      EXPECT_GT(normal_p(z), level) << "albedo " << albedo << ": " << mean << " collisions";
      EXPECT_EQ(account.ledger.rouletted, account.ledger.shot);
    }
  }
}

// ---- Lengths of paths

/// The lengths of the paths through a box that only scatters, in diffuse light.
Series path_lengths(const Scene& scene, std::uint64_t photons) {
  const PreparedScene prepared = prepare(scene, 0);
  const Box box = std::visit([](const auto& m) { return m.whole.box; }, prepared.medium);
  return measure(photons, [&](std::uint64_t i) {
    double sum = 0;
    follow(prepared, i, [&](const Flight&, const Ray& from, const Path& to) {
      // With periodic axes, the length of a flight follows from its progress along an open axis.
      const double dx = double{to.ray.origin.x} - from.origin.x;
      const double dy = double{to.ray.origin.y} - from.origin.y;
      const double dz = double{to.ray.origin.z} - from.origin.z;
      if (box.periodic_x || box.periodic_y) {
        sum += dz / from.direction.z;
      } else {
        sum += std::sqrt(dx * dx + dy * dy + dz * dz);
      }
    });
    return sum;
  });
}

TEST(Scattering, keeps_the_mean_path_through_a_body_at_four_volumes_over_its_surface) {
  struct Case {
    const char* name;
    std::vector<scene::Component> components;
  };
  const scene::Phase forward = scene::HenyeyGreensteinPhase{0.6};
  const std::vector<Case> cases = {
      {"homogeneous", {component(scene::Solid{}, 4)}},
      {"forward", {component(scene::Solid{}, 8, 1, forward)}},
      {"low variation", {component(low_variation(8), 20)}},
      {"high variation", {component(high_variation(12), 40)}},
      {"grid", {component(random_grid(5, 3, 4, 11), 3, 1, scene::RayleighPhase{})}},
      {"mixed",
       {component(random_grid(3, 4, 5, 12), 2), component(low_variation(4), 8, 1, forward),
        component(scene::Solid{scene::Sphere{{0.3, 0.6, 0.4}, 0.2}}, 20)}}};
  for (const Case& c : cases) {
    Scene scene = furnace(c.components);
    scene.medium.box_min = {0.3, 0.2, 0.4};
    scene.medium.box_max = {0.5, 0.6, 0.7};  // edges 0.2, 0.4, 0.3
    scene.medium.majorant_resolution = {4, 8, 6};
    const double chord = 4 * (0.2 * 0.4 * 0.3) / (2 * (0.2 * 0.4 + 0.4 * 0.3 + 0.2 * 0.3));
    const Series length = path_lengths(scene, 100000);
    EXPECT_GT(length.p_of_mean(chord), level) << c.name << ": " << length.mean() << " +- "
                                              << length.standard_error() << ", expected " << chord;
    EXPECT_LT(length.standard_error(), 0.01 * chord) << c.name;
  }
}

TEST(Scattering, keeps_the_mean_path_through_a_periodic_layer_at_twice_its_thickness) {
  Scene scene = furnace({component(random_grid(4, 4, 4, 13), 2)});
  scene.medium.sides = {scene::Side::periodic, scene::Side::periodic, scene::Side::open};
  scene.medium.majorant_resolution = {3, 4, 5};
  const Series length = path_lengths(scene, 200000);
  EXPECT_GT(length.p_of_mean(2.0), level) << length.mean() << " +- " << length.standard_error();
}

// ---- Thin media beside dense ones

constexpr double fog = 1e-3, body = 1e4;

Scene fog_and_body(int resolution) {
  scene::Component fog_component = component(scene::Solid{}, fog, 1);
  Scene scene = furnace(
      {component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.25}}, body, 0), fog_component});
  scene.medium.majorant_resolution = {resolution, resolution, resolution};
  return scene;
}

// Tests all decisions: every accept word up to 2^16, and a sample of the larger ones, of which none
// may hit the fog.
TEST(ThinBesideDense, the_right_share_of_all_accept_words_hits_the_fog) {
  const Scene scene = fog_and_body(1);
  const PreparedScene prepared = prepare(scene, 0);
  const auto& medium = std::get<MixedMedium>(prepared.medium);
  const int fog_index = prepared.scene_component[0] == 1 ? 0 : 1;
  const MajorantGrid& grid = medium.super_voxels;
  Lookups count;
  const auto hit = [&](std::uint64_t word, Vec3f p) {
    const float v = uniform(static_cast<std::uint32_t>(word)) * grid.total[0];
    return medium.collide(grid, 0, v, p, count);
  };
  for (const Vec3f& p : {Vec3f{0.1f, 0.1f, 0.1f}, Vec3f{0.5f, 0.5f, 0.5f}}) {
    std::int64_t hits = 0;
    for (std::uint64_t word = 0; word < 65536; ++word) hits += hit(word, p) == fog_index;
    for (std::uint64_t word = 65536; word <= 0xffffffffu; word += 9973) {
      ASSERT_NE(hit(word, p), fog_index);
    }
    const double share = static_cast<double>(hits) * 0x1p-32;
    EXPECT_NEAR(share / (fog / (fog + body)), 1, 2.5e-3);  // of 429 words, half a word is 0.0012
  }
}

TEST(ThinBesideDense, fog_collides_at_its_rate_within_the_super_voxel_of_the_body_and_elsewhere) {
  for (const auto& [resolution, flights] : {std::pair{1, 40000}, std::pair{16, 4000000}}) {
    const Scene scene = fog_and_body(resolution);
    const PreparedScene prepared = prepare(scene, 0);
    const Ray past_the_body{{0, 0.1f, 0.15f}, {1, 0, 0}};
    const auto n = static_cast<std::uint64_t>(flights);
    std::int64_t hits = 0;
    for (const FreePath& path : fly(prepared, SuperVoxel{}, past_the_body, n, 3)) {
      hits += path.collided;
    }
    const double p = -std::expm1(-fog);
    EXPECT_GT(proportion_p(hits, flights, p), level) << hits << " of " << flights;
  }
}

// Tests the fractions of the component hit first, at extinctions that collide often.
TEST(ThinBesideDense, components_are_hit_in_proportion_to_their_extinctions) {
  Scene scene = furnace({component(scene::Solid{}, 3), component(scene::Solid{}, 1),
                         component(random_grid(1, 1, 1, 1), 0), component(scene::Solid{}, 0.02)});
  const PreparedScene prepared = prepare(scene, 0);
  std::vector<std::int64_t> hits(4, 0);
  for (const AnySampler& sampler :
       {AnySampler(SuperVoxel{}), AnySampler(Woodcock{}), AnySampler(RayMarching{0.1f})}) {
    hits.assign(4, 0);
    for (const FreePath& path : fly(prepared, sampler, {{0, 0.5f, 0.5f}, {1, 0, 0}}, 300000, 4)) {
      if (path.collided)
        ++hits[static_cast<std::size_t>(
            prepared.scene_component[static_cast<std::size_t>(path.component)])];
    }
    EXPECT_GT(chi_square_test(hits, {3, 1, 0, 0.02}).p, level);
  }
}

}  // namespace
}  // namespace tyndall::test
