/// \file
/// What is wrong with a scene, in the words of its file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "tyndall/scene/scene.h"

namespace tyndall {

struct Problem {
  std::string path;     ///< of the offending key, e.g. "medium.components[0].extinction"
  std::string message;  ///< what was expected, what was found, what to write
  std::vector<std::string> depends_on = {};  ///< other keys that could make it none
};

struct Problems {
  std::vector<Problem> errors;
  std::vector<Problem> warnings;
};

/// Every problem of `scene` at once; a scene without errors renders. Needs no files and builds
/// nothing.
Problems check(const Scene& scene);

/// \return what is wrong with the size or the values of `grid`; empty if nothing is.
std::string grid_problem(const scene::DenseGrid& grid);

/// What is wrong with a table, and at which of its rows; an empty message if nothing is.
struct PhaseTableProblem {
  std::size_t row = 0;
  std::string message;
};
PhaseTableProblem phase_table_problem(const scene::PhaseTable& table);

/// \return whether `scene` has any detector that counts: paths alone shoot no photons.
bool detects(const Scene& scene);

/// \return order of the spherical harmonics that the phase functions of `scene` need: isotropic 0,
/// Henyey-Greenstein 1, others 2.
int needed_illumination_order(const Scene& scene);

/// \return Scene::bounces, and where that is left out 1, or as many as keep a picture within 1 % of
/// the truth where cells are wider than 0.9 or 1.25 transport mean free paths (docs/light.md). For
/// a scene that check() has passed.
int gather_bounces(const Scene& scene);

/// \return cells of an illumination grid over all the box: the scene's, and where these are 0 as
/// many as make them cells_in_free_paths wide, but 64 to 128 along the longest edge.
std::array<int, 3> dense_illumination_resolution(const Scene& scene);
/// [mean free path] of the densest matter: the width of a cell whose light is 1 % off over a cloud,
/// after one bounce (docs/light.md).
inline constexpr double cells_in_free_paths = 1.75;

/// Cells of the illumination grid.
struct IlluminationPlan {
  std::array<int, 3> cells{1, 1, 1};  ///< over the box
  bool is_sparse = false;             ///< only those in bricks with matter are stored
  std::uint64_t stored = 1;           ///< how many; of a sparse grid about, and no fewer
};
/// A sparse grid is for media that are nearly empty, where the scene says no resolution. Its cells
/// are cells_in_free_paths mean free paths wide, of where half of the extinction is, but from 64^3
/// to 128^3 for what the components fill. Where these fill less than an eighth of the box, it is
/// taken if cells of the dense grid would be more than twice as wide as the mean free path asks
/// for; where they fill less than a 64th, if they would be more than twice as wide as its own.
IlluminationPlan plan_illumination(const Scene& scene);
/// The most cells that a sparse grid stores.
inline constexpr std::uint64_t most_stored_cells = std::uint64_t{1} << 22;

/// \return IlluminationPlan::cells.
std::array<int, 3> stored_illumination_resolution(const Scene& scene);

/// \return the order that is stored: the scene's, or for -1 the highest where any is needed.
int stored_illumination_order(const Scene& scene);

/// The share of its distance from the origin below which a box is far from it: there solids are
/// brought to the box in double precision.
inline constexpr double nearest_far = 1e-3;

/// Ray marching takes no more steps across the medium: single precision resolves no shorter ones.
inline constexpr double most_steps = 1 << 22;

/// \return [byte] that rendering `scene` takes: film, illumination, bounds and grids.
std::uint64_t memory_needed(const Scene& scene);

/// An interval of numbers, and what a number in it is called.
struct Range {
  const char* what;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open = false;  ///< neither end belongs to it

  constexpr bool contains(double x) const {  // false for NaN
    return open ? low < x && x < high : low <= x && x <= high;
  }
};

/// \return e.g. "degrees in (0, 180)": completes "expected ..."
std::string describe(const Range& range);

/// The ranges of a scene's numbers: check() and the table of keys of the scene file share them.
/// They keep single precision finite: squares and quotients of lengths stay below 1e38.
namespace limits {
inline constexpr Range coordinate{"a number", -1e9, 1e9};  // [length]
inline constexpr Range size{"a number", 1e-9, 1e9};        // [length]
inline constexpr Range extinction{"a number", 0, 1e12};    // [1/length]
inline constexpr Range density{"a number", 0, 1e12};       // of grids
inline constexpr Range remap{"a number", -1e12, 1e12};     // scale and offset of values
inline constexpr Range gamma{"a number", 0.01, 100};
inline constexpr Range albedo{"a number", 0, 1};
inline constexpr Range g{"a number", -0.999, 0.999};
inline constexpr Range lobe_weight{"a number", 0, 1};
inline constexpr Range phase_rows{"a number", 2, 65536};
inline constexpr Range phase_value{"a number", 0, 1e30};
inline constexpr Range light{"a number", 0, 1e18};        // of power, irradiance and radiance
inline constexpr Range spot_angle{"degrees", 0.01, 360};  // of the whole cone
inline constexpr Range spot_edge{"a number", 0, 1};       // share of the half angle
inline constexpr Range sun_angle{"degrees", 0, 170};      // 0: parallel
inline constexpr Range image_scale{"a number", 0, 1e6};
inline constexpr Range fov{"degrees", 0, 180, true};
inline constexpr Range angle{"a number of degrees", -1e6, 1e6};
inline constexpr Range factor{"a number", -1e9, 1e9};  // of scales and matrices
inline constexpr Range octaves{"an integer", 1, 15};
inline constexpr Range gain{"a number", 0, 1, true};
inline constexpr Range contrast{"a number", 1e-6, 1e6};
inline constexpr Range coverage{"a number", -1000, 1000};
inline constexpr Range falloff{"a number", 0, 1e6};
inline constexpr Range voxels{"an integer", 1, 32768};       // per axis
inline constexpr Range mesh_voxels{"an integer", 8, 4096};   // along the longest side
inline constexpr Range majorants{"an integer", 0, 256};      // per axis
inline constexpr Range illumination{"an integer", 0, 1024};  // per axis
inline constexpr Range order{"an integer", -1, 2};
inline constexpr Range lens{"a number", 0, 1e9};        // [length] radius and distance of focus
inline constexpr Range pixels{"an integer", 1, 65536};  // per axis
inline constexpr Range crop{"an integer", 0, 65536};
inline constexpr Range filter_radius{"a number of pixels", 0, 16};
inline constexpr Range photons{"an integer", 1, 1e11};  // 64-bit tallies hold 2^39 initial powers
inline constexpr Range samples{"an integer", 1, 1e6};   // per pixel
inline constexpr Range bounces{"an integer", 0, 1e6};
inline constexpr Range marching_step{"a number", 0, 1e9};  // [length]
inline constexpr Range exposure{"a number", -100, 100};    // [EV]
inline constexpr Range flux{"an integer", 0, 4096};        // per axis
inline constexpr Range bins{"an integer", 0, 1e6};
inline constexpr Range path_length{"a number", 0, 1e9};         // [length]
inline constexpr Range voxels_absorbed{"an integer", 0, 1024};  // per axis
inline constexpr Range seed{"an integer below 2^64", 0};
inline constexpr Range noise_seed{"an integer", 0, 4294967295.0};
}  // namespace limits

}  // namespace tyndall
