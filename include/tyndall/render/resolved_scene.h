/// \file
/// A checked scene, and the values derived from it.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "tyndall/render/check.h"
#include "tyndall/render/illumination_plan.h"

namespace tyndall {

/// A scene that passed check(), and the sizes and densities derived from it, each computed once.
/// Copies share the scene, which never changes.
class ResolvedScene {
 public:
  /// Implicit: a Scene may be passed wherever a ResolvedScene is expected, and is checked there.
  /// \throws Error(scene_invalid) with every error of the scene, one per line
  ResolvedScene(Scene scene);
  /// Reports problems instead of throwing. If there are errors, the result must not be used.
  ResolvedScene(Scene scene, Problems& problems);
  /// Skips check(): for tests and benchmarks, whose scenes need no light and no camera.
  static ResolvedScene unchecked(Scene scene);

  const Scene& operator*() const { return *scene_; }
  const Scene* operator->() const { return scene_.get(); }
  operator const Scene&() const { return *scene_; }
  const std::shared_ptr<const Scene>& share() const { return scene_; }

  std::vector<Problem> warnings;
  std::vector<Densities> densities;  ///< of the components
  IlluminationPlan illumination;
  int illumination_order = 0;  ///< the scene's; for -1 the highest if any order is needed
  /// Scene::bounces. If that is not given: 1, or as many as keep a picture within 1 % of the truth:
  /// 2 or 3 if cells are wider than 0.9 or 1.25 transport mean free paths, up to 16 in solids,
  /// whose dark sides need them (docs/light.md).
  int bounces = 1;

  /// \return [byte] memory of a render for film, illumination, bounds and grids. \param lights
  /// replicates whose light is in memory at once
  std::uint64_t memory(int lights = 1) const;

 private:
  explicit ResolvedScene(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {}
  void resolve();

  std::shared_ptr<const Scene> scene_;
};

}  // namespace tyndall
