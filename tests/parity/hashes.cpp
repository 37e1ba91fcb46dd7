/// \file
/// Renders small scenes that together cover every field, phase function, light, sampler and kind
/// of side, and prints a line per scene: its name, the hash of its tallies, the hash of its pixels.
/// same_bits.sh compares the lines of differently compiled copies of this program.
///
///   hashes [--threads N] [--batch N] [--device cpu|cuda] [--hostile] [SCENE...]
///
/// --hostile renders with rounding upwards and denormals flushed to zero in the caller. The
/// computations below are exact in double precision, so all copies render the same scenes.
#include <cfenv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include <nanovdb/util/GridBuilder.h>

#include "tyndall/base/hash.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/image.h"
#include "tyndall/render/render.h"
#include "tyndall/render/volume.h"

namespace tyndall::scene {  // hides names of the core: Component, NoiseCloud, ...
namespace {

// ---- Scenes

/// A small, fast scene; each function below changes the parts that it tests.
Scene small() {
  Scene s;
  s.medium.majorant_resolution = {5, 4, 6};
  s.camera.position = {0.75, 1.0, -2.0};
  s.camera.look_at = {0.5, 0.4375, 0.5};
  s.camera.resolution = {20, 14};
  s.photons = 1500;
  s.illumination_resolution = {6, 5, 4};
  s.samples = 4;
  s.seed = 20110101;
  return s;
}

Component component(Field field, double extinction, glm::dvec3 albedo, Phase phase = {},
                    glm::dmat4 transform = glm::dmat4(1.0)) {
  return {std::move(field), extinction, albedo, phase, NoEmission{}, transform};
}

/// Rotation by 3-4-5 and 5-12-13 triangles, shear, non-uniform scale and a shift; takes the unit
/// cube to about [0.1, 0.9]^3.
glm::dmat4 sheared() {
  glm::dmat4 m(1.0);
  m[0] = {0.48, 0.36, 0.0625, 0.0};
  m[1] = {-0.3, 0.46, 0.1875, 0.0};
  m[2] = {0.125, -0.25, 0.60, 0.0};
  m[3] = {0.32, 0.21, 0.08, 1.0};
  return m;
}

/// A small part of field space: many octaves, few of them larger than the box.
glm::dmat4 zoomed(double scale, glm::dvec3 shift) {
  glm::dmat4 m(scale);
  m[3] = glm::dvec4(shift, 1.0);
  return m;
}

DenseGrid grid(std::array<int, 3> size, Interpolation interpolation) {
  DenseGrid g;
  g.size = size;
  g.interpolation = interpolation;
  const int count = size[0] * size[1] * size[2];
  for (int i = 0; i < count; ++i) {
    const auto word = static_cast<std::uint32_t>(mix64(static_cast<std::uint64_t>(i)) >> 48);
    g.values.push_back((word & 3u) == 0 ? 0.0f : static_cast<float>(word) / 32768.0f);
  }
  return g;
}

/// A plane-parallel layer under an oblique sun.
Scene slab() {
  Scene s = small();
  s.medium.box_max = {3.0, 2.0, 0.7};
  s.medium.sides = {Side::periodic, Side::periodic, Side::open};
  s.medium.components = {component(Solid{}, 4.0, {0.9, 0.95, 0.8}, HenyeyGreensteinPhase{0.75})};
  s.lights = {DirectionalLight{{0.3, -0.2, 0.9}, {10, 9, 8}}};
  s.background = {0.125, 0.25, 0.5};
  return s;
}

/// A box that is periodic along all axes: only absorption ends photons.
Scene endless() {
  Scene s = small();
  s.medium.box_max = {1.0, 0.5, 0.75};
  s.medium.sides = {Side::periodic, Side::periodic, Side::periodic};
  s.medium.components = {component(Solid{}, 3.0, {0.7, 0.5, 0.9})};
  s.lights = {PointLight{{0.25, 0.125, 0.375}, {3, 2, 1}}};
  s.bounces = 0;  // the light has infinitely many images
  s.camera.position = {0.5, 0.25, 0.125};
  return s;
}

/// Every body, coloured and black, in every phase function.
Scene solids() {
  Scene s = small();
  s.medium.components = {
      component(Solid{Sphere{{0.3, 0.3, 0.4}, 0.25}}, 30.0, {0.99, 0.5, 0.25}),
      component(Solid{Cuboid{{0.55, 0.1, 0.2}, {0.9, 0.45, 0.6}}}, 12.0, glm::dvec3(0.9),
                HenyeyGreensteinPhase{-0.95}),
      component(Solid{Torus{{0.5, 0.7, 0.5}, 0.3, 0.11}}, 400.0, glm::dvec3(0.0)),
      component(Solid{Capsule{{0.2, 0.6, 0.8}, {0.7, 0.8, 0.7}, 0.1}}, 25.0, {0.2, 0.4, 0.99},
                RayleighPhase{}, sheared()),
      component(Solid{}, 0.01, glm::dvec3(1.0), HenyeyGreensteinPhase{0.95})};
  s.lights = {PointLight{{1.5, 1.8, -0.5}, {100, 90, 80}}};
  s.bounces = 3;  // the default is 16: the cells are wide
  return s;
}

Scene cloud_sphere() {
  Scene s = small();
  s.medium.components = {component(NoiseCloud{}, 60.0, glm::dvec3(0.99))};
  std::get<NoiseCloud>(s.medium.components[0].field).octaves = 5;
  s.lights = {PointLight{{1.5, 1.8, -0.5}, glm::dvec3(100)}};
  return s;
}

/// Far from the origin, where float has few bits left: local space keeps them.
Scene cloud_ellipsoid() {
  Scene s = small();
  const glm::dvec3 origin(700.0, -300.0, 1000.0);
  glm::dmat4 m = sheared();
  m[3] += glm::dvec4(origin, 0.0);
  NoiseCloud cloud;
  cloud.octaves = 5;
  cloud.gain = 0.6;
  cloud.seed = 99;
  cloud.contrast = 4.0;
  cloud.coverage = 1.25;
  cloud.falloff = 1.5;
  cloud.body = Ellipsoid{{0.5, 0.4, 0.5}, {0.6, 0.45, 0.7}};
  s.medium.box_min = origin;
  s.medium.box_max = origin + glm::dvec3(1.0, 1.1, 1.25);
  s.medium.components = {component(cloud, 40.0, {0.9, 0.99, 0.95}, RayleighPhase{}, m)};
  s.lights = {EnvironmentLight{{1.0, 2.0, 3.0}}};
  s.camera.position += origin;
  s.camera.look_at += origin;
  s.sampler = Sampler::woodcock;
  return s;
}

/// All 15 octaves.
Scene cloud_layer() {
  Scene s = small();
  NoiseCloud cloud;
  cloud.octaves = 15;
  cloud.coverage = 0.9;
  cloud.body = Layer{0.5, 0.05};
  s.medium.sides = {Side::periodic, Side::open, Side::open};
  s.medium.components = {component(cloud, 20.0, glm::dvec3(1.0), HenyeyGreensteinPhase{-0.6},
                                   zoomed(16.0, {-3.0, -7.5, -5.0}))};
  s.lights = {DirectionalLight{{0.1, -1.0, 0.3}, glm::dvec3(5)}};
  s.illumination_resolution = {33, 1, 2};
  s.illumination_order = 1;
  return s;
}

Scene cloud_everywhere() {
  Scene s = small();
  NoiseCloud cloud;
  cloud.octaves = 4;
  cloud.coverage = 0.25;
  cloud.contrast = 1.5;
  cloud.body = Everywhere{};
  s.medium.components = {component(cloud, 8.0, {0.8, 0.9, 1.0})};
  s.lights = {PointLight{{0.5, 0.625, 0.375}, {1, 2, 3}}};
  s.photons = 700;
  s.samples = 2;
  s.sampler = Sampler::ray_marching;
  return s;
}

Scene plume() {
  Scene s = small();
  NoiseCloud cloud;
  cloud.octaves = 6;
  cloud.contrast = 2.0;
  cloud.body = Plume{{0.5, 0.0, 0.5}, 1.0, 0.125, 0.4, {0.2, -0.15}};
  s.medium.box_max = {1.0, 1.5, 1.0};
  s.medium.majorant_resolution = {6, 9, 6};
  s.medium.components = {component(cloud, 35.0, {0.85, 0.8, 0.75}, HenyeyGreensteinPhase{0.4},
                                   zoomed(1.5, {-0.25, 0.0, -0.25}))};
  s.lights = {PointLight{{0.5, -0.5, 0.5}, {50, 30, 10}},
              DirectionalLight{{1.0, -0.5, 0.25}, {1, 1, 2}}};
  return s;
}

Scene grid_trilinear() {
  Scene s = small();
  s.medium.components = {component(grid({7, 5, 3}, Interpolation::trilinear), 6.0,
                                   {0.95, 0.9, 0.85}, RayleighPhase{}, sheared())};
  s.lights = {EnvironmentLight{glm::dvec3(1.0)}, PointLight{{-1.0, 0.5, 0.5}, {20, 0, 0}}};
  return s;
}

/// A grid like one from a file: a block of integer values, a tile beside it, empty space between.
template <class Build>
SparseGrid sparse(double voxel, glm::dvec3 place) {
  nanovdb::GridBuilder<float, Build> builder(0.0f, nanovdb::GridClass::FogVolume);
  auto voxels = builder.getAccessor();
  for (int i = -5; i < 12; ++i)
    for (int j = 0; j < 10; ++j)
      for (int k = 3; k < 14; ++k)
        voxels.setValue(nanovdb::Coord(i, j, k),
                        static_cast<float>((7 * i * i + 5 * j + 3 * k) % 16));
  const auto handle = std::make_shared<nanovdb::GridHandle<>>(
      builder.template getHandle<>(voxel, nanovdb::Vec3d(place.x, place.y, place.z), "density"));
  SparseGrid field;
  field.volume = std::make_shared<const Volume>(
      std::shared_ptr<std::byte>(handle, reinterpret_cast<std::byte*>(handle->data())),
      handle->size());
  return field;
}

Scene sparse_float() {
  Scene s = small();
  SparseGrid field = sparse<float>(0.0625, {0.375, 0.125, -0.125});
  field.remap = {0.25, -0.125, 0.0, 3.0, 0.75};
  s.medium.components = {
      component(field, 6.0, {0.9, 0.8, 0.95}, HenyeyGreensteinPhase{0.3}, sheared())};
  s.lights = {EnvironmentLight{glm::dvec3(1.0)}};
  return s;
}

Scene sparse_quantised() {
  Scene s = small();
  SparseGrid field = sparse<nanovdb::Fp8>(1.0, {0, 0, 0});
  field.fit = SparseGrid::Fit::unit_cube;
  field.interpolation = Interpolation::nearest;
  s.medium.components = {component(field, 1.5, glm::dvec3(0.97))};
  s.lights = {PointLight{{-1.0, 0.5, 0.5}, {20, 10, 5}}};
  return s;
}

/// Fire: black bodies, colours, and fog that they light.
Scene glowing() {
  Scene s = small();
  SparseGrid field = sparse<float>(0.0625, {0.375, 0.125, -0.125}), heat = field;
  heat.remap = {60.0, 900.0, 0.0, 2500.0, 1.0};
  s.medium.components = {component(field, 0.5, {0.5, 0.25, 0.125}),
                         component(grid({4, 3, 5}, Interpolation::trilinear), 2.0, glm::dvec3(0.5)),
                         component(Solid{}, 0.5, glm::dvec3(0.9))};
  s.medium.components[0].emission = BlackbodyEmission{heat, 0.125};
  s.medium.components[1].emission =
      ColorEmission{{1.0, 2.0, 4.0}, grid({2, 2, 3}, Interpolation::trilinear)};
  return s;
}

Scene grid_nearest() {
  Scene s = small();
  s.medium.majorant_resolution = {1, 1, 1};
  s.medium.components = {component(grid({4, 9, 6}, Interpolation::nearest), 9.0, glm::dvec3(0.97))};
  s.lights = {DirectionalLight{{0.0, 0.0, 1.0}, {3, 3, 3}}};
  s.illumination_order = 2;
  return s;
}

/// Fog of 1e-3 and a body of 1e4, smoke and a grid, under every light at once.
Scene mixed() {
  Scene s = small();
  NoiseCloud cloud;
  cloud.octaves = 4;
  s.medium.box_min = {-0.25, 0.0, -0.5};
  s.medium.box_max = {1.25, 1.0, 1.5};
  s.medium.components = {
      component(Solid{Sphere{{0.25, 0.5, 0.5}, 0.125}}, 1e4, glm::dvec3(0.0)),
      component(cloud, 30.0, {0.99, 0.9, 0.8}, HenyeyGreensteinPhase{0.85}),
      component(grid({5, 5, 5}, Interpolation::trilinear), 2.0, {0.5, 0.75, 1.0}, RayleighPhase{}),
      component(Solid{}, 1e-3, glm::dvec3(1.0))};
  s.lights = {PointLight{{0.5, 0.9375, 0.5}, {5, 6, 7}},
              DirectionalLight{{-1.0, -1.0, 1.0}, {1, 2, 3}}, EnvironmentLight{{0.25, 0.5, 0.75}}};
  s.background = {1.0, 0.5, 0.25};
  return s;
}

/// Under a sun and a sky, over a coloured ground and beside a black one.
Scene ground() {
  Scene s = cloud_sphere();
  s.medium.ground[1] = glm::dvec3(0);
  s.medium.ground[2] = {0.75, 0.5, 0.25};
  s.lights = {DirectionalLight{{0.3, -1.0, 0.4}, {3, 3, 2}}, EnvironmentLight{{0.25, 0.5, 1}},
              SphereLight{{0.25, 0.125, 0.25}, 0.125, {2, 4, 8}}};
  return s;
}

Scene ground_path() {
  Scene s = ground();
  s.integrator = Integrator::path;
  s.sampler = Sampler::woodcock;
  return s;
}

/// Local lights outside and inside the box, a sun's disc and an image of the sky, in groups.
Scene all_lights() {
  Scene s = small();
  NoiseCloud cloud;
  cloud.octaves = 5;
  s.medium.components = {component(cloud, 12.0, {0.95, 0.9, 0.8}, HenyeyGreensteinPhase{0.5}),
                         component(Solid{}, 0.5, glm::dvec3(0.9))};
  std::vector<Vec3f> texels;
  for (int i = 0; i < 9 * 5; ++i) {
    const auto k = static_cast<float>(i * 7 % 16);
    texels.push_back({0.125f * k, 0.0625f * k + 0.25f, i == 13 ? 40.0f : 1.0f});
  }
  EnvironmentLight sky;
  sky.image = std::make_shared<const Image>(9, 5, std::move(texels));
  sky.scale = 0.25;
  sky.rotation = 77.0;
  sky.group = "sky";
  s.lights = {sky,
              PointLight{{0.25, 0.75, 0.5}, {1, 2, 3}},
              DirectionalLight{{0.5, -1.0, 0.25}, {2, 1.5, 1}, 0.53, "sun"},
              DirectionalLight{{-0.5, -1.0, 0.25}, {0.5, 0.5, 1}},
              SpotLight{{1.5, 2.0, -0.5}, {-1.0, -1.5, 1.0}, 35.0, 0.5, {20, 15, 10}, "lamps"},
              RectangleLight{{0.5, 1.5, 0.5}, {0.5, 0, 0}, {0.125, 0, 0.5}, {4, 2, 1}, "lamps"},
              RectangleLight{{0.5, 0.5, 0.0625}, {0.25, 0, 0}, {0, 0.25, 0}, {1, 4, 1}},
              SphereLight{{-1.0, 0.5, 0.5}, 0.25, {8, 8, 4}, "lamps"},
              SphereLight{{0.75, 0.25, 0.75}, 0.0625, {2, 2, 8}},
              EnvironmentLight{{0.125, 0.125, 0.25}}};
  s.background = {0.0, 0.0, 0.125};
  return s;
}

Scene all_lights_path() {
  Scene s = all_lights();
  s.integrator = Integrator::path;
  return s;
}

Scene mixed_woodcock() {
  Scene s = mixed();
  s.medium.components.erase(s.medium.components.begin());
  s.sampler = Sampler::woodcock;
  s.seed = std::numeric_limits<std::uint64_t>::max();
  return s;
}

Scene mixed_marching() {
  Scene s = mixed();
  s.sampler = Sampler::ray_marching;
  s.marching_step = 0.0625;
  s.photons = 700;
  return s;
}

Scene mixed_bounces() {
  Scene s = mixed();
  s.bounces = 2;
  return s;
}

Scene mixed_in_grid() {
  Scene s = mixed();
  s.single_scattering = SingleScattering::grid;
  return s;
}

Scene mixed_path() {
  Scene s = mixed();
  s.integrator = Integrator::path;
  return s;
}

/// A crop of a picture with depth of field.
Scene lens() {
  Scene s = cloud_sphere();
  s.medium.components[0].extinction = 20.0;
  s.camera.focal_length = 40.0;
  s.camera.aperture_radius = 0.25;
  s.camera.focus_distance = 2.25;
  s.camera.crop = {3, 2, 17, 12};
  s.filter = Filter::gaussian;
  s.samples = 8;
  return s;
}

/// Two lobes, seen by an orthographic camera.
Scene two_lobes() {
  Scene s = grid_trilinear();
  s.medium.components[0].phase = TwoLobesPhase{0.85, -0.35, 0.875};
  s.camera.projection = Projection::orthographic;
  s.camera.width = 1.25;
  glm::dmat4 m(1.0);  // from 3-4-5 triangles
  m[0] = {0.6, 0.0, 0.8, 0.0};
  m[1] = {-0.64, 0.6, 0.48, 0.0};
  m[2] = {-0.48, -0.8, 0.36, 0.0};
  m[3] = {-0.25, -0.75, 1.0, 1.0};
  s.camera.matrix = m;
  return s;
}

/// A tabulated phase function, seen by a spherical camera inside the box.
Scene tabulated() {
  Scene s = mixed();
  const PhaseTable table{{-1.0, -0.875, 0.0, 0.75, 0.96875, 0.9999, 1.0},
                         {2.0, 0.5, 0.125, 1.0, 7.0, 300.0, 310.0}};
  for (scene::Component& c : s.medium.components)
    c.phase = TabulatedPhase{std::make_shared<const PhaseTable>(table)};
  s.camera.projection = Projection::spherical;
  s.camera.position = {0.75, 0.5, 0.25};
  s.camera.look_at = {0.25, 0.5, 0.5};
  s.filter = Filter::blackman_harris;
  s.filter_radius = 2.0;
  return s;
}

struct Named {
  const char* name;
  Scene (*make)();
};

constexpr Named scenes[] = {
    {"slab", slab},
    {"endless", endless},
    {"solids", solids},
    {"cloud_sphere", cloud_sphere},
    {"cloud_ellipsoid", cloud_ellipsoid},
    {"cloud_layer", cloud_layer},
    {"cloud_everywhere", cloud_everywhere},
    {"plume", plume},
    {"grid_trilinear", grid_trilinear},
    {"grid_nearest", grid_nearest},
    {"sparse_float", sparse_float},
    {"sparse_quantised", sparse_quantised},
    {"glowing", glowing},
    {"ground", ground},
    {"ground_path", ground_path},
    {"all_lights", all_lights},
    {"all_lights_path", all_lights_path},
    {"mixed", mixed},
    {"mixed_woodcock", mixed_woodcock},
    {"mixed_marching", mixed_marching},
    {"mixed_bounces", mixed_bounces},
    {"mixed_in_grid", mixed_in_grid},
    {"mixed_path", mixed_path},
    {"lens", lens},
    {"two_lobes", two_lobes},
    {"tabulated", tabulated},
};

// ---- The caller's floating-point environment

/// Sets a floating-point environment as a host program might before it calls render().
void make_hostile() {
  std::fesetround(FE_UPWARD);
#if defined(__SSE__)
  _mm_setcsr(_mm_getcsr() | 0x8040u);  // flush to zero, denormals are zero
#elif defined(__aarch64__)
  std::uint64_t fpcr;
  __asm__ volatile("mrs %0, fpcr" : "=r"(fpcr));
  fpcr |= std::uint64_t{1} << 24;  // flush to zero
  __asm__ volatile("msr fpcr, %0" : : "r"(fpcr));
#endif
}

/// \return whether this thread rounds up and flushes denormals. `volatile` keeps the compiler from
/// folding the arithmetic.
bool is_hostile() {
  volatile float one = 1.0f, tiny = 1e-30f, smallest = std::numeric_limits<float>::min();
  const volatile float sum = one + tiny, half = smallest * 0.5f;
#if defined(__SSE__) || defined(__aarch64__)
  return sum > 1.0f && half == 0.0f;
#else
  return sum > 1.0f && half > 0.0f;
#endif
}

// ---- Program

struct Options {
  int threads = 0;
  std::uint64_t batch = 0;
  bool cuda = false, hostile = false;
  std::vector<std::string> names;
};

Options parse(int argc, char** argv) {
  Options options;
  const auto value = [&](int& i) -> const char* {
    if (++i < argc) return argv[i];
    std::fprintf(stderr, "%s needs a value\n", argv[i - 1]);
    std::exit(2);
  };
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--threads") {
      options.threads = std::atoi(value(i));
    } else if (argument == "--batch") {
      options.batch = std::strtoull(value(i), nullptr, 10);
    } else if (argument == "--device") {
      options.cuda = std::string(value(i)) == "cuda";
    } else if (argument == "--hostile") {
      options.hostile = true;
    } else if (argument[0] == '-') {
      std::fprintf(stderr, "unknown option %s\n", argument.c_str());
      std::exit(2);
    } else {
      options.names.push_back(argument);
    }
  }
  return options;
}

std::unique_ptr<Backend> make_backend(const Options& options) {
#if defined(TYNDALL_CUDA)
  if (options.cuda) return make_cuda_backend();
#endif
  if (options.cuda) throw std::runtime_error("this program was built without CUDA");
  return make_cpu_backend(options.threads);
}

bool wanted(const Options& options, const char* name) {
  if (options.names.empty()) return true;
  for (const std::string& n : options.names)
    if (n == name) return true;
  return false;
}

int run(const Options& options) {
  int faults = 0;
  std::printf("arithmetic_version %d\n", arithmetic_version);
  const auto backend = make_backend(options);
  for (const Named& named : scenes) {
    if (!wanted(options, named.name)) continue;
    const Scene scene = named.make();
    RenderOptions render_options;
    render_options.batch = options.batch;

    std::fenv_t before;
    std::fegetenv(&before);
    if (options.hostile) make_hostile();
    const RenderResult result = render(scene, *backend, render_options);
    const bool kept = !options.hostile || is_hostile();
    std::fesetenv(&before);

    std::printf("%s %016llx %016llx\n", named.name,
                static_cast<unsigned long long>(result.hashes.tallies),
                static_cast<unsigned long long>(result.hashes.pixels));
    std::fflush(stdout);
    if (!kept) {
      std::fprintf(stderr, "%s: render() did not restore its caller's rounding\n", named.name);
      ++faults;
    }
    // A scene with too few collisions would agree everywhere and prove nothing.
    const bool shoots = scene.integrator == tyndall::scene::Integrator::photons;
    if ((shoots && result.shoot.real < 100) || result.gather.real < 100
        || result.shoot.violations != 0) {
      std::fprintf(stderr, "%s: %lld and %lld real collisions, %lld violations of a majorant\n",
                   named.name, static_cast<long long>(result.shoot.real),
                   static_cast<long long>(result.gather.real),
                   static_cast<long long>(result.shoot.violations));
      ++faults;
    }
  }
  return faults == 0 ? 0 : 1;
}

}  // namespace
}  // namespace tyndall::scene

int main(int argc, char** argv) {
  try {
    return tyndall::scene::run(tyndall::scene::parse(argc, argv));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
