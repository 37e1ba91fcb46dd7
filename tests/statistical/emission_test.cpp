/// \file
/// Emissive media against closed forms. A medium in thermal equilibrium with the light around it is
/// invisible, for any scattering. An isothermal layer has 1 - exp(-tau) of the radiance of an
/// opaque one. The power and the origins of photons agree with a quadrature of the emission.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/random.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

scene::Component shining(scene::Component c, scene::Emission emission) {
  c.emission = std::move(emission);
  return c;
}

struct Oven {
  const char* name;
  scene::Component matter;
};
void PrintTo(const Oven& oven, std::ostream* out) { *out << oven.name; }

class IsothermalOven : public testing::TestWithParam<Oven> {};

/// Kirchhoff's law: a medium is invisible in light of its own radiance.
TEST_P(IsothermalOven, hides_matter_of_its_own_temperature) {
  Scene scene =
      furnace({shining(GetParam().matter, scene::ColorEmission{glm::dvec3(1), scene::Solid{}})});
  scene.medium.majorant_resolution.fill(4);
  scene.photons = 150000;
  scene.samples = 256;
  scene.single_scattering = scene::SingleScattering::grid;  // see WhiteFurnace
  const std::vector<RenderResult> results = replicates(scene, 12);
  for (int channel = 0; channel < 3; ++channel) {
    const Series mean =
        series(results, [&](const RenderResult& r) { return mean_of_picture(r, channel); });
    std::printf("%-24s %d %.5f +- %.5f\n", GetParam().name, channel, mean.mean(),
                mean.standard_error());
    EXPECT_GT(replicates_p(mean, 1), level);
    EXPECT_LT(mean.standard_error(), 0.004) << "too noisy to tell";
  }
}

scene::Component tinted(scene::Component c) {
  c.albedo = {0.1, 0.5, 0.9};
  return c;
}

INSTANTIATE_TEST_SUITE_P(
    , IsothermalOven,
    testing::Values(Oven{"black_fog", component(scene::Solid{}, 3, 0)},
                    Oven{"grey_fog", component(scene::Solid{}, 3, 0.6)},
                    Oven{"tinted_cloud", tinted(component(high_variation(6), 30))},
                    Oven{"forward",
                         component(low_variation(6), 20, 0.5, scene::HenyeyGreensteinPhase{0.5})}),
    testing::PrintToStringParamName());

TEST(Emission, of_an_isothermal_layer_is_that_of_an_opaque_one_times_its_opacity) {
  const double depth = 0.7;
  Scene scene = slab(depth, 0);
  scene.lights.clear();
  scene.medium.components[0] =
      shining(scene.medium.components[0], scene::ColorEmission{{3, 2, 1}, scene::Solid{}});
  // A distant camera looks straight through a spot of the layer.
  scene.camera.position = {0.5, 0.5, -1000};
  scene.camera.look_at = {0.5, 0.5, 0.5};
  scene.camera.up = {0, 1, 0};
  scene.camera.fov = 0.01;
  scene.camera.resolution = {16, 16};
  scene.samples = 4000;
  scene.photons = 1000;
  const RenderResult result = render(scene, *make_cpu_backend(0));
  const double n = 16 * 16 * 4000, opacity = 1 - std::exp(-depth);
  for (int channel = 0; channel < 3; ++channel) {
    const double source = 3 - channel;
    const double z = (mean_of_picture(result, channel) / source - opacity)
                     / std::sqrt(opacity * (1 - opacity) / n);
    EXPECT_LT(std::abs(z), 4) << channel;
  }
}

/// Compares the power [W] of all channels with a quadrature at random points.
TEST(Emission, photons_carry_the_power_of_the_matter) {
  scene::Component hot = component(high_variation(5), 25, 0.3);
  hot.albedo = {0.3, 0.6, 0.8};
  scene::NoiseCloud warm = low_variation(3, 11);
  scene::DenseGrid temperatures = random_grid(4, 4, 4, 5);
  temperatures.remap = {.scale = 800, .offset = 900, .low = 0, .high = 3000, .gamma = 1};
  for (const scene::Emission& emission :
       {scene::Emission(scene::ColorEmission{{1, 2, 0.5}, warm}),
        scene::Emission(scene::BlackbodyEmission{temperatures, 0.01})}) {
    Scene scene = furnace({shining(hot, emission)});
    scene.lights.clear();
    scene.medium.majorant_resolution.fill(8);
    scene.photons = 400000;
    const PreparedScene prepared = prepare(scene, 0);
    ASSERT_EQ(prepared.emitters.size(), 1u);
    const Component<AnyField>& c = prepared.components[0];
    Random random(17);
    Series power[3];
    for (int i = 0; i < 400000; ++i) {
      const Vec3f p{static_cast<float>(random()), static_cast<float>(random()),
                    static_cast<float>(random())};
      const Vec3f j = 4 * pi * c.sigma_t(p) * c.emitted(p);
      power[0].add(j.x), power[1].add(j.y), power[2].add(j.z);
    }
    const Tallies tallies = shoot(scene);
    const double unit =
        prepared.shot_power / static_cast<double>(scene.photons) / double{weight_units};
    for (int channel = 0; channel < 3; ++channel) {
      const double shot = unit * static_cast<double>(tallies.account.ledger.shot_power[channel]);
      // A photon is born or not, so the number of born photons is binomial.
      const double share =
          1
          - static_cast<double>(tallies.account.ledger.missed) / static_cast<double>(scene.photons);
      const double error = std::hypot(
          power[channel].standard_error(),
          shot * std::sqrt((1 - share) / share / static_cast<double>(scene.photons)) * 2);
      std::printf("channel %d: %.5g W shot, %.5g W by quadrature, +- %.2g\n", channel, shot,
                  power[channel].mean(), error);
      EXPECT_LT(std::abs(shot - power[channel].mean()), 4 * error) << channel;
      EXPECT_LT(error, 0.02 * shot);
    }
    EXPECT_EQ(tallies.account.audit.violations, 0);
  }
}

/// Compares the origins of photons along x with the quadrature: chi-square over 16 slices.
TEST(Emission, photons_start_where_the_matter_shines) {
  scene::Component hot = component(high_variation(5), 25, 0);
  hot.emission = scene::ColorEmission{glm::dvec3(1), low_variation(3, 11)};
  Scene scene = furnace({hot});
  scene.lights.clear();
  scene.medium.majorant_resolution.fill(8);
  const PreparedScene prepared = prepare(scene, 0);
  const auto& medium = std::get<SingleMedium<NoiseCloud>>(prepared.medium);
  constexpr int slices = 16;
  double expected[slices] = {}, counted[slices] = {}, sum = 0, born = 0;
  Random random(17);
  for (int i = 0; i < 1000000; ++i) {
    const Vec3f p{static_cast<float>(random()), static_cast<float>(random()),
                  static_cast<float>(random())};
    const double j = prepared.components[0].sigma_t(p) * prepared.components[0].emitted(p).x;
    expected[static_cast<int>(p.x * slices)] += j;
    sum += j;
  }
  for (std::uint64_t i = 0; i < 60000; ++i) {
    const RandomStream stream{1, i, Domain::photon};
    const Photon photon = prepared.emitters[0].medium.emit(
        medium, stream.block(0, Purpose::emission), stream.block(0, Purpose::aim),
        stream.block(0, Purpose::place));
    if (largest(photon.weight) == 0) continue;
    ++counted[static_cast<int>(photon.ray.origin.x * slices)];
    ++born;
  }
  ASSERT_GT(born, 5000);
  double chi_square = 0;
  int cells = 0;
  for (int s = 0; s < slices; ++s) {
    const double e = expected[s] / sum * born;
    if (e < 20) continue;
    chi_square += (counted[s] - e) * (counted[s] - e) / e;
    ++cells;
  }
  ASSERT_GT(cells, 6);
  // 1e-4 of chi-square with 15 degrees of freedom lies above 45; the quadrature adds a tenth.
  EXPECT_LT(chi_square, 50) << cells << " slices";
}

}  // namespace
}  // namespace tyndall::test
