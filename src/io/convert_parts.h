/// \file
/// Common parts of the converters: a single medium, since other renderers have one medium in one
/// place, and the list of features that they lack.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "io/convert.h"

namespace tyndall::io {

/// Collects all that cannot be converted into one error.
class Refusals {
 public:
  /// \param why completes a sentence that begins with the name of the renderer.
  Refusals(std::string scene, std::string renderer)
      : scene_(std::move(scene)), renderer_(std::move(renderer)) {}

  void add(const std::string& key, const std::string& why);
  /// \throws Error(scene_invalid)
  void throw_if_any() const;

 private:
  std::string scene_, renderer_, lines_;
};

/// A constant extinction coefficient.
struct Homogeneous {
  double sigma_t = 0;  ///< [1/length]
};
/// Extinction coefficients at the voxel centres of an axis-aligned box, x fastest, with trilinear
/// interpolation.
struct Sampled {
  std::array<int, 3> size{1, 1, 1};
  glm::dvec3 low{0.0}, high{1.0};
  std::vector<float> sigma_t;  ///< [1/length]
};
/// A grid of a file, unchanged.
struct Stored {
  std::shared_ptr<const Volume> volume;
  glm::dmat4 to_world{1.0};  ///< from the grid's own world space
  double sigma_t = 0;        ///< [1/length] at value 1
};

/// The sum of the components of a scene, which all have the same albedo and phase function.
struct OneMedium {
  glm::dvec3 low{0.0}, high{1.0};  ///< its bounding box in world space
  glm::dvec3 albedo{1.0};
  std::string phase;  ///< in the syntax of the other renderer
  std::variant<Homogeneous, Sampled, Stored> matter;

  bool contains(glm::dvec3 p) const {
    return p.x > low.x && p.y > low.y && p.z > low.z && p.x < high.x && p.y < high.y
           && p.z < high.z;
  }
};

/// Calls at(n, p) for each voxel n of a box, x fastest; p is its centre, in the space of `low` and
/// `high`. Rows are distributed over `threads`.
void for_each_voxel(const std::array<int, 3>& size, glm::dvec3 low, glm::dvec3 high, int threads,
                    const std::function<void(std::size_t n, glm::dvec3 p)>& at);

struct SampledAt {
  int voxels = default_voxels;  ///< along the longest side
  int threads = 0;
};

/// Adds to `refusals` the features of the medium that can be checked before sampling it.
/// \param phases one per component, in the syntax of the other renderer
void refuse_media(const Scene& scene, const std::vector<std::string>& phases, Refusals& refusals);

/// Refuses sun discs and filters other than the box, which neither renderer has.
void refuse_suns_and_filters(const Scene& scene, Refusals& refusals);

/// \return whether the camera's rays begin within the medium.
/// \throws Error(scene_invalid) if only some of them do: renderers set the medium of all rays once.
bool starts_within(const OneMedium& medium, const scene::Camera& camera, Refusals& refusals);

/// \return the horizontal field of view [degree].
double field_of_view(const scene::Camera& camera);

/// \return a point on the camera's axis.
glm::dvec3 look_at(const Scene& scene);

/// \pre refuse_media() refused nothing. \param reads_volumes whether the renderer reads grids of
/// floats from NanoVDB files.
OneMedium one_medium(const ResolvedScene& scene, const std::vector<std::string>& phases,
                     const SampledAt& sampling, bool reads_volumes);

/// \return the name as a string literal for C, Python and pbrt.
std::string quoted(const std::string& name);
/// \return e.g. "0.5, 1, 2".
std::string listed(glm::dvec3 v, const char* separator = ", ");
/// \return `path` with another extension.
std::string beside(const std::string& path, const char* extension);

std::vector<ConvertedFile> convert_to_pbrt(const SceneFile& file, const std::string& path,
                                           const SampledAt& sampling);
std::vector<ConvertedFile> convert_to_mitsuba(const SceneFile& file, const std::string& path,
                                              const SampledAt& sampling);

}  // namespace tyndall::io
