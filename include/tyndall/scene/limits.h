/// \file
/// The ranges of a scene's numbers.
#pragma once

#include <limits>
#include <string>

namespace tyndall {

/// An interval of numbers, and a name for a number in it.
struct Range {
  const char* what;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open = false;  ///< it excludes both ends

  constexpr bool contains(double x) const {  // false for NaN
    return open ? low < x && x < high : low <= x && x <= high;
  }
};

/// \return e.g. "degrees in (0, 180)": completes "expected ..."
std::string describe(const Range& range);

/// The ranges of a scene's numbers, for the keys of the scene file and for check(). They keep
/// single precision finite: squares and quotients of lengths stay below 1e38.
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
inline constexpr Range light{"a number", 0, 1e18};        // power, irradiance and radiance
inline constexpr Range spot_angle{"degrees", 0.01, 360};  // of the whole cone
inline constexpr Range spot_edge{"a number", 0, 1};       // fraction of the half angle
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

/// A box is far from the origin if its extent is below this fraction of its distance. Solids are
/// then moved to the box in double precision.
inline constexpr double nearest_far = 1e-3;

/// The most steps of ray marching across the medium: single precision does not resolve shorter
/// steps.
inline constexpr double most_steps = 1 << 22;

}  // namespace tyndall
