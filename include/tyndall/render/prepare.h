/// \file
/// Prepares a scene for the walks: bounds, emitters, camera, scales. All are in local space: world
/// space moved so that the corner of the medium's box is the origin, which keeps float positions
/// exact far from 0.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "tyndall/render/parallel.h"
#include "tyndall/render/resolved_scene.h"
#include "tyndall/transport/passes.h"

namespace tyndall {

#define TYN_SINGLE(Field, name) SingleMedium<Field>,
using AnyMedium = std::variant<TYN_FOR_EACH_FIELD(TYN_SINGLE) MixedMedium>;
#undef TYN_SINGLE
using AnySampler = std::variant<SuperVoxel, Woodcock, RayMarching>;

/// Bounds of all components over the super-voxels of one grid, and over all of them.
struct MajorantTables : Cells {
  std::vector<float> total, upper, lower;                    ///< see MajorantGrid
  std::vector<float> whole_total, whole_upper, whole_lower;  ///< see MajorantGrid, for one cell
};

/// A scene ready to render. The views (medium, emitters, ...) point into its own storage and into
/// the grids of `source`.
struct PreparedScene {
  std::shared_ptr<const Scene> source;
  AnyMedium medium;
  AnySampler sampler;
  std::vector<Emitter> emitters;
  Camera camera;
  std::vector<DirectLight> direct_lights;  ///< sorted: see DirectLights
  std::vector<std::string> light_groups;   ///< names, in the order of the scene's lights
  Vec3f background{0, 0, 0};               ///< [W/(area sr)] seen by the camera behind everything
  std::vector<std::string> groups;         ///< with separately stored light: light_groups, the
                                    ///< medium's emission, if any, and the background; or none
  bool has_grid = true;                 ///< false: path integrator
  bool is_apart = true;                 ///< the grid lacks singly scattered light of direct_lights
  int bounces = 0;                      ///< before the grid is read
  int film_width = 1, film_height = 1;  ///< of the crop
  /// Pixels that are not proven to be black, whatever their samples; in order; empty: all pixels.
  std::vector<std::uint32_t> bright_pixels;
  float film_unit = 1;
  IlluminationCells cells;
  Vec3f cell_size{1, 1, 1};
  std::vector<CellBricks::Entry> brick_table;  ///< of `cells`, if not all are stored
  std::vector<std::uint64_t> brick_places;     ///< of `cells`, if not all are stored
  std::vector<Clump> clumps;                   ///< targets of light from far away; or none
  int strata = 1;
  float matter_scale = 1;
  std::uint64_t seed = 1;
  std::uint64_t gather_seed = 1;  ///< of camera paths
  std::uint64_t hash = 0;         ///< see scene_hash()
  Detectors detectors;            ///< without memory

  Lights lights() const {
    return {emitters.data(), static_cast<int>(emitters.size()), clumps.data(),
            static_cast<int>(clumps.size())};
  }

  /// The film of the scene, in the memory of a backend.
  Film film(PixelTally* tallies, std::int64_t* clamped, std::int64_t* group_sums) const {
    return {.width = film_width,
            .height = film_height,
            .unit = film_unit,
            .pixels = tallies,
            .clamped = clamped,
            .groups = groups.empty() ? nullptr : group_sums,
            .group_count = static_cast<int>(groups.size())};
  }

  std::size_t pixels() const {
    return static_cast<std::size_t>(film_width) * static_cast<std::size_t>(film_height);
  }

  /// The number of pixels to gather.
  std::size_t pixels_to_gather() const {
    return bright_pixels.empty() ? pixels() : bright_pixels.size();
  }

  double shot_power = 0;                ///< [W] total of all photons, each of weight 1
  glm::dvec3 unshot_power{0};           ///< [W] that misses all receivers: never traced
  std::vector<std::string> warnings;    ///< about lights and emissions that give nothing
  std::vector<std::string> dim_lights;  ///< see Frame
  std::vector<int>
      scene_component;  ///< of each component of `medium`, which are sorted by their majorants

  MajorantTables tables;
  std::vector<Component<AnyField>> components;
  std::vector<std::vector<std::int8_t>> noise_tables;   ///< of components
  std::vector<std::vector<std::uint8_t>> bound_tables;  ///< of components
  std::vector<Emission> emissions;                      ///< of components; never resized
  std::vector<std::vector<std::uint32_t>> glow_tables;  ///< of emitters
  std::vector<std::vector<std::uint32_t>> sky_tables;   ///< of lights
  std::vector<std::vector<PhaseKnot>> phase_tables;     ///< of components
  std::vector<float> filter_quantiles;                  ///< of the camera
};

/// \param threads for the bounds \param progress called by the calling thread with the fraction
/// done \param table_points of each noise: see NoiseTable \throws Stopped
PreparedScene prepare(const ResolvedScene& scene, int threads,
                      const std::function<void(double)>& progress = {}, const Stop& stop = {},
                      double table_points = NoiseTable::processor_points);

/// \return PreparedScene::warnings of a scene that is not rendered. check() cannot find these,
/// because they need the bounds of the medium. Scenes that cannot have any return at once.
std::vector<std::string> lights_that_give_nothing(const ResolvedScene& scene, int threads = 0);

/// Replaces the camera by that of `scene`. \pre `prepared` is of a scene that differs in nothing
/// else
void prepare_view(const ResolvedScene& scene, PreparedScene& prepared);

/// Builds the bounds alone. `components` are in the order of the tables; for `resolution` see
/// scene::Medium::majorant_resolution.
MajorantTables build_majorants(const std::vector<Component<AnyField>>& components, const Box& box,
                               std::array<int, 3> resolution, int threads,
                               const std::function<void(double)>& progress = {},
                               const Stop& stop = {});

template <class Copy>
void MixedMedium::relocate(Copy&& copy) {
  super_voxels.relocate(copy);
  whole.relocate(copy);
  std::vector<Component<AnyField>> moved(components, components + component_count);
  for (Component<AnyField>& component : moved) component.relocate(copy);
  components = copy(static_cast<const Component<AnyField>*>(moved.data()), moved.size());
}

}  // namespace tyndall
