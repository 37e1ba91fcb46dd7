/// \file
/// A resolved scene computes its derived values once.
#include <gtest/gtest.h>

#include <string>

#include "support/scenes.h"
#include "tyndall/render/error.h"

namespace tyndall::test {
namespace {

TEST(ResolvedScene, ThrowsEveryError) {
  Scene scene = furnace({component(scene::Solid{}, -1)});
  scene.camera.fov = 180;
  try {
    ResolvedScene{scene};
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::scene_invalid);
    const std::string text = error.what();
    EXPECT_NE(text.find("medium.components[0].extinction: expected"), text.npos) << text;
    EXPECT_NE(text.find("\ncamera.fov: expected"), text.npos) << text;
  }
}

TEST(ResolvedScene, MeasuresTheVoxelsOfADenseGrid) {
  scene::DenseGrid grid;
  grid.size = {4, 4, 4};
  grid.values.assign(64, 0.0f);
  for (std::size_t i = 0; i < 32; ++i) grid.values[i] = 1.5f;
  grid.values[0] = 20;
  grid.remap.scale = 2;
  Scene scene = furnace({component(grid, 1)});
  scene.medium.components[0].transform[0][0] = 0.5;
  const Densities found = ResolvedScene(scene).densities.at(0);
  EXPECT_EQ(found.largest, 40);
  EXPECT_NEAR(found.typical, 3, 0.5) << "half of 94 + 40 is below";
  EXPECT_EQ(found.filled, 0.25);
}

TEST(ResolvedScene, SharesTheSceneWithWhatIsMadeOfIt) {
  PreparedScene prepared;
  {
    const ResolvedScene scene(furnace({component(random_grid(3, 3, 3, 5), 1)}));
    const ResolvedScene copy = scene;
    EXPECT_EQ(&*copy, &*scene);
    prepared = tyndall::prepare(scene, 1);
    EXPECT_EQ(prepared.source, scene.share());
  }
  EXPECT_EQ(prepared.source.use_count(), 1);
}

TEST(ResolvedScene, WarningsComeFirstInAResult) {
  Scene scene = furnace({component(scene::Solid{}, 1), component(scene::Solid{}, 0)});
  scene.photons = 100;
  const ResolvedScene resolved(scene);
  ASSERT_EQ(resolved.warnings.size(), 1u);
  const RenderResult result = render(resolved, *make_cpu_backend());
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_EQ(result.warnings[0], resolved.warnings[0].path + ": " + resolved.warnings[0].message);
}

TEST(ResolvedScene, TheCameraIsNoPartOfTheLight) {
  const Scene scene = furnace({component(scene::Solid{}, 1)});
  Scene seen = scene, dense = scene;
  seen.camera.fov = 20;
  seen.gather_seed = 5;
  dense.medium.components[0].extinction = 2;
  EXPECT_EQ(light_hash(seen), light_hash(scene));
  EXPECT_NE(scene_hash(seen), scene_hash(scene));
  EXPECT_NE(light_hash(dense), light_hash(scene));
}

}  // namespace
}  // namespace tyndall::test
