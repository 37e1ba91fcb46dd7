/// \file
/// Grids of several files in one medium, each with its own transform: free paths against the
/// transmittance from a quadrature of the densities.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/scenes.h"
#include "support/volumes.h"

namespace tyndall::test {
namespace {

scene::Component from_file(const char* name, double extinction,
                           const std::optional<std::string>& grid = {}) {
  scene::SparseGrid field;
  field.volume = load(name, grid).volume;
  return component(field, extinction);
}

TEST(Volumes, of_several_files_add_up) {
  TYNDALL_NEEDS_VOLUMES();
  Scene scene =
      furnace({from_file("rotated.vdb", 0.2), from_file("uniform.vdb", 0.3),
               from_file("misaligned.vdb", 0.1, "temperature"),
               from_file("level_set.vdb", 0.02, "surface"), from_file("background.vdb", 0.05)});
  scene.medium.box_min = glm::dvec3(-12);
  scene.medium.box_max = glm::dvec3(18);
  scene.medium.majorant_resolution = {0, 0, 0};
  const PreparedScene prepared = prepare(scene, 0);
  const struct {
    Vec3f from, to;
  } rays[] = {{{0, 12, 12}, {30, 13, 13}},
              {{30, 20, 9}, {0, 8, 14}},
              {{12, 12, 0}, {13, 15, 30}},
              {{1, 2, 3}, {29, 22, 21}}};
  for (const auto& r : rays) {
    const Ray ray{r.from, normalize(r.to - r.from)};
    const double escapes = std::exp(-OpticalDepth(prepared, ray, 400000).total());
    for (const AnySampler& sampler : {AnySampler(SuperVoxel{}), AnySampler(Woodcock{})}) {
      constexpr std::uint64_t n = 60000;
      double escaped = 0;
      for (const FreePath& path : fly(prepared, sampler, ray, n, 5)) escaped += !path.collided;
      const double z = (escaped / n - escapes) / std::sqrt(escapes * (1 - escapes) / n);
      std::printf("transmittance %.4f, z = %.2f\n", escapes, z);
      EXPECT_LT(std::abs(z), 4.2);
      EXPECT_GT(escapes, 0.01);
      EXPECT_LT(escapes, 0.99);
    }
  }
}

}  // namespace
}  // namespace tyndall::test
