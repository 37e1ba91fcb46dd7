/// \file
/// A scene as a person describes it: plain values in world space, double precision, no pointers
/// into other parts of the program. `tyndall/render/prepare.h` turns it into what the walks read.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tyndall {
class Image;
class Volume;
}  // namespace tyndall

namespace tyndall::scene {

// ---- Shapes: the bodies of solids, and what a noise cloud is wrapped around. Lengths in field
// units. ----

struct Sphere {
  glm::dvec3 center{0.5};
  double radius = 0.5;
};
struct Ellipsoid {
  glm::dvec3 center{0.5};
  glm::dvec3 radii{0.5};
};
/// A horizontal slab, unbounded in x and z.
struct Layer {
  double height = 0.5;     ///< y of its middle plane
  double thickness = 0.5;  ///< from face to face
};
/// No shape at all: the field fills the whole medium box.
struct Everywhere {};
/// A leaning cone around an axis that rises from `base`: the body of rising smoke.
struct Plume {
  glm::dvec3 base{0.5, 0.0, 0.5};
  double height = 1.0;
  double radius_base = 0.1;
  double radius_top = 0.35;
  glm::dvec2 lean{0.0};  ///< (x, z) the axis moves by between base and top
};
struct Cuboid {
  glm::dvec3 min{0.25}, max{0.75};
};
/// Around an axis along y.
struct Torus {
  glm::dvec3 center{0.5};
  double ring_radius = 0.3;  ///< from the centre to the middle of the tube
  double tube_radius = 0.1;
};
struct Capsule {
  glm::dvec3 a{0.5, 0.25, 0.5}, b{0.5, 0.75, 0.5};
  double radius = 0.1;
};

using CloudBody = std::variant<Sphere, Ellipsoid, Layer, Everywhere, Plume>;
using SolidBody = std::variant<Everywhere, Sphere, Cuboid, Torus, Capsule>;

// ---- Fields: density [-], 0 to 1 unless a grid says otherwise, over field space. ----

/// density(p) = clamp(contrast (F(p) + coverage - falloff q(p)), 0, 1), where F is the sum of
/// `octaves` octaves of gradient noise, octave k with lattice 2^k over the unit cube and amplitude
/// gain^(k-1), and q is 0 on the axis of the body and 1 on its surface (the square of the relative
/// distance). The defaults are the preset low_variation; octaves = 8, 12, 15 mean 256^3, 4096^3,
/// 32768^3 effective voxels.
struct NoiseCloud {
  int octaves = 8;
  double gain = 0.5;
  std::uint32_t seed = 0;
  double contrast = 0.5;
  double coverage = 1.4;
  double falloff = 1.8;
  CloudBody body = Sphere{};
};

enum class Interpolation { trilinear, nearest };

/// What grids make of their values: density = clamp(scale value + offset, low, high)^gamma.
struct Remap {
  double scale = 1, offset = 0;
  double low = 0, high = 1e12;
  double gamma = 1;
};

/// Voxel (i, j, k) covers [i/nx, (i+1)/nx] x ... of the unit cube of field space, its value sits at
/// its centre, x runs fastest. Outside the unit cube the density is 0.
struct DenseGrid {
  std::array<int, 3> size{1, 1, 1};
  std::vector<float> values;
  Interpolation interpolation = Interpolation::trilinear;
  Remap remap;
};

/// A grid of a file (tyndall/render/volume.h), outside of whose voxels its background counts. The
/// values of level sets are distances, which make a solid of density 1; others are remapped.
struct SparseGrid {
  /// Field space is the grid's own world space; or that, moved and scaled so that the box of its
  /// active voxels lies in the middle of the unit cube.
  enum class Fit { none, unit_cube };
  struct Bounds {
    glm::dvec3 low, high;
  };

  std::shared_ptr<const Volume> volume;
  Interpolation interpolation = Interpolation::trilinear;
  Remap remap;
  Fit fit = Fit::none;
  /// What `fit` takes for that box, in the grid's own world space: the frames of a sequence are all
  /// placed as one of them is. None: the volume's own.
  std::optional<Bounds> fit_box;
};

/// Density 1 inside the body, 0 outside.
struct Solid {
  SolidBody body = Everywhere{};
};

using Field = std::variant<Solid, NoiseCloud, DenseGrid, SparseGrid>;

// ---- Medium: the sum of its components. ----

struct IsotropicPhase {};
struct HenyeyGreensteinPhase {
  double g = 0.0;  ///< mean cosine, in (-1, 1)
};
struct RayleighPhase {};
/// Two lobes of Henyey and Greenstein's together.
struct TwoLobesPhase {
  double g1 = 0.8, g2 = -0.3;  ///< mean cosines, in (-1, 1)
  double weight = 0.9;         ///< share of the first, in [0, 1]
};
/// Linear in the cosine between its rows, in any unit.
struct PhaseTable {
  std::vector<double> cosines;  ///< ascending from -1 to 1
  std::vector<double> values;   ///< [any] of as many, 0 or above
};
struct TabulatedPhase {
  std::shared_ptr<const PhaseTable> table;
};
using Phase = std::variant<IsotropicPhase, HenyeyGreensteinPhase, RayleighPhase, TwoLobesPhase,
                           TabulatedPhase>;

/// Matter emits as it absorbs: per length, extinction (1 - albedo) times these radiances
/// [W/(area sr)]. The fields are in the space of the component's own; where that is a grid of a
/// file, so are theirs, whatever their `fit`.
struct NoEmission {};
/// Radiance times the field, whose grid may be one of colours.
struct ColorEmission {
  glm::dvec3 radiance{1.0};
  Field field = Solid{};
};
/// That of a black body at the field's temperature [K], in W/(m^2 sr), as bright as the eye sees it
/// (luminance / (683 lm/W)), times the intensity.
struct BlackbodyEmission {
  Field temperature = Solid{};
  double intensity = 1.0;
};
using Emission = std::variant<NoEmission, ColorEmission, BlackbodyEmission>;

struct Component {
  Field field = Solid{};
  double extinction = 1.0;  ///< [1/length] at density 1, grey
  glm::dvec3 albedo{1.0};   ///< scattered share of the extinction, linear RGB, in [0, 1]
  Phase phase = IsotropicPhase{};
  Emission emission = NoEmission{};
  glm::dmat4 transform{1.0};  ///< field space to world space, affine; glm's column order
};

enum class Side { open, periodic };

inline constexpr std::array<const char*, 6> face_names{"-x", "+x", "-y", "+y", "-z", "+z"};

struct Medium {
  glm::dvec3 box_min{0.0}, box_max{1.0};  ///< [length] nothing exists outside
  std::array<Side, 3> sides{Side::open, Side::open, Side::open};
  /// Albedos of the faces -x +x -y +y -z +z that are grounds: opaque, seen from inside they reflect
  /// evenly in all directions. What they do not reflect, they take.
  std::array<std::optional<glm::dvec3>, 6> ground{};
  /// Super-voxels along x, y, z, to 256 each; 0: as many as pay, a choice that the scene alone
  /// makes (docs/resolution.md).
  std::array<int, 3> majorant_resolution{0, 0, 0};
  std::vector<Component> components;
};

// ---- Light, camera, work. ----

/// Each light belongs to a group, by name; those of no name are one group together. Area lights
/// emit and are seen, but block nothing.
struct PointLight {
  glm::dvec3 position{0.0};
  glm::dvec3 power{1.0};  ///< [W] into all directions
  std::string group{};
};
/// Parallel light, seen by no camera; or a sun, a disc in the sky whose light differs in direction
/// by no more than `angle`.
struct DirectionalLight {
  glm::dvec3 direction{0.0, -1.0, 0.0};  ///< the way it travels, from the middle of the disc
  glm::dvec3 irradiance{1.0};            ///< [W/area] on a plane across that
  double angle = 0;                      ///< [degree] across the disc; 0: parallel
  std::string group{};
};
/// Radiance from everywhere; the camera sees it. How an image lies around the scene is said at
/// SkyImage (tyndall/transport/light.h): with +y up its middle is at +z, its left half at +x.
struct EnvironmentLight {
  glm::dvec3 radiance{1.0};              ///< [W/(area sr)] without an image
  double scale = 1;                      ///< times that, or times the image
  std::shared_ptr<const Image> image{};  ///< in longitude and latitude, the top row at +y
  double rotation = 0;                   ///< [degree] of the image about +y: 90 takes +z to +x
  std::string group{};
};
/// A point light within a cone. It fades from the bright middle to the cone's edge by a cubic of
/// the cosine (smoothstep), as pbrt's does.
struct SpotLight {
  glm::dvec3 position{0.0};
  glm::dvec3 direction{0.0, -1.0, 0.0};
  double angle = 60;          ///< [degree] of the whole cone
  double edge = 0.2;          ///< share of the half angle over which it fades
  glm::dvec3 intensity{1.0};  ///< [W/sr] along the direction
  std::string group{};
};
/// A parallelogram that shines alike from every point into every direction of the side to which
/// cross(edge_u, edge_v) points.
struct RectangleLight {
  glm::dvec3 center{0.0};
  glm::dvec3 edge_u{1.0, 0.0, 0.0}, edge_v{0.0, 0.0, 1.0};  ///< [length] from end to end
  glm::dvec3 radiance{1.0};                                 ///< [W/(area sr)]
  std::string group{};
};
/// Shines outwards, alike from every point into every direction.
struct SphereLight {
  glm::dvec3 center{0.0};
  double radius = 0.1;
  glm::dvec3 radiance{1.0};  ///< [W/(area sr)]
  std::string group{};
};
using Light = std::variant<PointLight, DirectionalLight, EnvironmentLight, SpotLight,
                           RectangleLight, SphereLight>;

enum class Projection {
  perspective,
  orthographic,  ///< parallel rays from the plane through the camera
  spherical,     ///< all directions: longitude across, latitude down
};

struct Camera {
  Projection projection = Projection::perspective;
  glm::dvec3 position{0.5, 0.5, -2.0};
  glm::dvec3 look_at{0.5, 0.5, 0.5};
  glm::dvec3 up{0.0, 1.0, 0.0};
  /// Instead of the three: camera to world, no scale. The camera looks along -z, x is to the right,
  /// y upwards; glm's column order.
  std::optional<glm::dmat4> matrix;

  // Perspective:
  double fov = 45.0;          ///< [degree] full angle across the picture's width
  double focal_length = 0.0;  ///< instead of `fov`, where above 0, in the unit of film_width
  double film_width = 36.0;
  double aperture_radius = 0.0;  ///< [length] of the thin lens; 0: a pinhole
  double focus_distance = 0.0;   ///< [length] along the view to the plane in focus; 0: look_at's

  double width = 1.0;  ///< [length] orthographic: across the picture

  std::array<int, 2> resolution{512, 512};
  /// x0, y0, x1, y1 [pixel] of the part that is rendered, without x1 and y1; all 0: the whole.
  std::array<int, 4> crop{0, 0, 0, 0};
};

/// How a pixel weighs the light around its middle: a product of the same function of x and of y,
/// from -radius to radius.
enum class Filter {
  box,
  gaussian,         ///< the radius is 3 standard deviations
  blackman_harris,  ///< 4 terms [Harris1978]
};

/// How light gets into the picture.
enum class Integrator {
  photons,  ///< photons leave light in a grid; a gather reads it
  path,     ///< paths from the camera alone: no bias but noise
};

/// Where the gather finds light that is scattered once.
enum class SingleScattering {
  apart,  ///< by shadow walks to the lights: shadows and edges are as sharp as the matter
  grid,   ///< with all other light in the grid: fast, and blurred by its cells
};

enum class Sampler { super_voxel, woodcock, ray_marching };

/// What is counted of the photons, for researchers (docs/detectors.md); 0: not counted.
struct Detectors {
  std::array<int, 2> flux{0, 0};  ///< cells of each face
  int path_length_bins = 0;
  double path_length_max = 0.0;  ///< [length] end of the last bin, which takes the rest, too
  int scattering_bins = 0;       ///< the last one takes the rest
  int exit_angle_bins = 0;
  std::array<int, 3> absorbed{0, 0, 0};  ///< voxels
};

struct Scene {
  Medium medium;
  std::vector<Light> lights;
  Camera camera;
  glm::dvec3 background{0.0};  ///< radiance [W/(area sr)] behind everything; lights nothing, adds
                               ///< to the environment's
  Sampler sampler = Sampler::super_voxel;
  double marching_step = 0.0;  ///< [length] of ray_marching; 0: one finest voxel of the components
  Integrator integrator = Integrator::photons;
  std::uint64_t photons = 1000000;
  std::array<int, 3> illumination_resolution{0, 0, 0};  ///< 0: chosen from the medium
  int illumination_order =
      -1;  ///< of the spherical harmonics, 0 to 2; -1: 2 unless all scattering is isotropic
  std::uint64_t samples = 16;  ///< per pixel
  std::optional<int> bounces;  ///< of the camera's paths before they read the grid; none: 1 to 3,
                               ///< see gather_bounces()
  SingleScattering single_scattering = SingleScattering::apart;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> gather_seed;  ///< of the camera's paths; none: `seed`
  Filter filter = Filter::box;
  double filter_radius = 0.0;  ///< [pixel] 0: 0.5 of a box, 1.5 of the others
  double exposure = 0.0;       ///< [EV] of the PNG preview only
  Detectors detectors;
};

}  // namespace tyndall::scene

namespace tyndall {
using scene::Scene;
}
