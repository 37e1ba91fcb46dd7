// The table of keys of the scene file, and its use. A new key is a new row of the table; nothing
// else needs to know.
#include "io/scene_json.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/image_file.h"
#include "io/json_table.h"
#include "io/json_text.h"
#include "io/phase_file.h"
#include "io/sha256.h"
#include "io/volume_file.h"
#include "tyndall/render/check.h"
#include "tyndall/render/error.h"
#include "tyndall/render/huge_pages.h"
#include "tyndall/render/lights.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {
namespace {

using namespace scene;
using scene::Camera;
using scene::Component;
using scene::DenseGrid;
using scene::Detectors;
using scene::NoiseCloud;
using scene::Remap;
using scene::Solid;
namespace fs = std::filesystem;

// ---- The table. Defaults are those of the structs (scene.h), ranges those of check(). ----

const char* const field_unit = "field unit";

std::vector<Key<Sphere>> sphere() {
  return {key("center", &Sphere::center, vector(limits::coordinate), field_unit, "centre"),
          key("radius", &Sphere::radius, number(limits::size), field_unit, "radius")};
}

std::vector<Key<Ellipsoid>> ellipsoid() {
  return {
      key("center", &Ellipsoid::center, vector(limits::coordinate), field_unit, "centre"),
      key("radii", &Ellipsoid::radii, vector(limits::size), field_unit, "radii along x, y and z")};
}

std::vector<Key<Layer>> layer() {
  return {
      key("height", &Layer::height, number(limits::coordinate), field_unit,
          "y of the middle plane"),
      key("thickness", &Layer::thickness, number(limits::size), field_unit, "from face to face")};
}

std::vector<Key<Plume>> plume() {
  return {
      key("base", &Plume::base, vector(limits::coordinate), field_unit, "where the axis starts"),
      key("height", &Plume::height, number(limits::size), field_unit, "height"),
      key("radius_base", &Plume::radius_base, number(limits::size), field_unit,
          "radius at the base"),
      key("radius_top", &Plume::radius_top, number(limits::size), field_unit, "radius at the top"),
      key("lean", &Plume::lean, tuple<glm::dvec2>("x, z", number(limits::coordinate)), field_unit,
          "how far the axis moves sideways between base and top")};
}

std::vector<Key<Cuboid>> cuboid() {
  return {key("min", &Cuboid::min, vector(limits::coordinate), field_unit, "lower corner"),
          key("max", &Cuboid::max, vector(limits::coordinate), field_unit, "upper corner")};
}

std::vector<Key<Torus>> torus() {
  return {key("center", &Torus::center, vector(limits::coordinate), field_unit,
              "centre; the axis is along y"),
          key("ring_radius", &Torus::ring_radius, number(limits::size), field_unit,
              "from the centre to the middle of the tube"),
          key("tube_radius", &Torus::tube_radius, number(limits::size), field_unit,
              "radius of the tube")};
}

std::vector<Key<Capsule>> capsule() {
  return {key("a", &Capsule::a, vector(limits::coordinate), field_unit, "one end of the axis"),
          key("b", &Capsule::b, vector(limits::coordinate), field_unit, "the other end"),
          key("radius", &Capsule::radius, number(limits::size), field_unit, "radius")};
}

Kind<CloudBody> cloud_body() {
  return variant<CloudBody>(
      {one<CloudBody>("sphere", "a ball of noise", sphere()),
       one<CloudBody>("ellipsoid", "an ellipsoid of noise", ellipsoid()),
       one<CloudBody>("layer", "a horizontal layer of noise, unbounded in x and z", layer()),
       one<CloudBody, Everywhere>("everywhere", "noise without a shape", {}),
       one<CloudBody>("plume", "a leaning cone of noise, as of smoke that rises", plume())});
}

/// How harsh a noise cloud is.
struct Preset {
  double contrast, coverage, falloff;
  bool operator==(const Preset&) const = default;
};
constexpr Preset low_variation{0.5, 1.4, 1.8}, high_variation{3.0, 0.0, 0.45};

std::vector<Key<NoiseCloud>> noise_cloud() {
  return {
      setter<NoiseCloud>(
          "preset", low_variation,
          [](NoiseCloud& cloud, const Preset& preset) {
            cloud.contrast = preset.contrast;
            cloud.coverage = preset.coverage;
            cloud.falloff = preset.falloff;
          },
          choice<Preset>({{"low_variation", low_variation}, {"high_variation", high_variation}}),
          "",
          "sets contrast, coverage and falloff where they are not given: a soft cloud, or a broken "
          "one"),
      key("octaves", &NoiseCloud::octaves, integer<int>(limits::octaves), "",
          "octaves of gradient noise; 8, 12, 15 are 256^3, 4096^3, 32768^3 effective voxels"),
      key("gain", &NoiseCloud::gain, number(limits::gain), "",
          "amplitude of an octave over that of the one before"),
      key("seed", &NoiseCloud::seed, integer<std::uint32_t>(limits::noise_seed), "",
          "another seed, another cloud"),
      key("contrast", &NoiseCloud::contrast, number(limits::contrast), "", "hardness of the edges"),
      key("coverage", &NoiseCloud::coverage, number(limits::coverage), "",
          "added to the noise: more is fuller"),
      key("falloff", &NoiseCloud::falloff, number(limits::falloff), "",
          "taken from the noise at the surface of the body, 0 at its middle"),
      key("body", &NoiseCloud::body, cloud_body(), "", "what the noise is wrapped around")};
}

/// Reads the values of a grid from a file of 32-bit floats.
void load_values(Reader& reader, const Node& node, DenseGrid& grid) {
  static_assert(std::endian::native == std::endian::little, "raw files are little endian");
  const Node* name = child(node, "file");
  if (!name) return;
  const auto damaged = [&](const std::string& message) {
    reader.within("file", [&] { reader.error(*name, message, ExitCode::input_missing); });
  };
  const fs::path path = reader.file(name->value.get<std::string>());
  bool is_named_only = false;
  reader.within("file", [&] { is_named_only = reader.only_names(path); });
  if (is_named_only) return;
  std::error_code error;
  const std::uint64_t bytes = fs::file_size(path, error);
  if (error) return damaged(fmt::format("{}: {}", path.string(), error.message()));
  std::uint64_t expected = sizeof(float);
  for (const int n : grid.size) expected *= static_cast<std::uint64_t>(n);
  if (bytes != expected) {
    return damaged(fmt::format("{}: expected 4 x {} bytes, got {}", path.string(),
                               fmt::join(grid.size, " x "), bytes));
  }
  resize_in_huge_pages(grid.values, expected / sizeof(float));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(grid.values.data()),
                 static_cast<std::streamsize>(bytes))) {
    return damaged(path.string() + ": cannot be read");
  }
  reader.inputs.push_back(path.string());
  if (const std::string problem = grid_problem(grid); !problem.empty())
    damaged(path.string() + ": " + problem);
}

// ---- Volumes from files

/// What a scene says of one, and what becomes of it.
struct VolumeSource {
  std::string file;
  std::optional<std::string> grid;
  std::string sha256;
  int voxels = 256;  ///< of a mesh, along its longest side
  scene::SparseGrid field;
};

void check_digest(const fs::path& path, const std::string& expected) {
  std::string digest = sha256_of_file(path.string());
  if (digest != expected)
    throw Error(
        ExitCode::input_missing,
        fmt::format("{}: its SHA-256 is {}, expected {}: another file than the one that was meant",
                    path.string(), digest, expected));
}

/// In a sequence: whether a file other than `path` has the grid that it lacks.
template <class Load>
bool is_in_other_frames(Reader& reader, const std::string& path, const std::string& what,
                        const Load& load) {
  const auto [known, is_new] = reader.sequence->is_somewhere.try_emplace(reader.path() + what);
  for (const std::string& file : *reader.frame_files()) {
    if (!is_new || known->second) break;
    if (file == path) continue;
    try {
      known->second = !load(file, Emptiness::allowed).is_absent;
    } catch (const Error&) {  // is said of its own frame
    }
  }
  return known->second;
}

/// In a sequence: the box that `fit` fits into the unit cube in every frame, where it is not that
/// of the volume itself.
template <class Load>
std::optional<scene::SparseGrid::Bounds> box_to_fit(Reader& reader, const LoadedVolume& own,
                                                    const Load& load) {
  const auto box_of = [](const Volume& volume) {
    const ActiveBounds box = active_box(volume, volume.to_world());
    return scene::SparseGrid::Bounds{box.low, box.high};
  };
  const auto [known, is_new] = reader.sequence->fits.try_emplace(reader.path());
  SequenceFiles::Fit& fit = known->second;
  for (const std::string& file : *reader.frame_files()) {
    if (!is_new || !fit.file.empty()) break;
    try {
      const LoadedVolume loaded = file == own.path ? own : load(file, Emptiness::allowed);
      if (loaded.volume->active_voxels() > 0) fit = {file, box_of(*loaded.volume)};
    } catch (const Error&) {  // is said of its own frame
    }
  }
  if (fit.file.empty()) return std::nullopt;  // all of them are empty
  const scene::SparseGrid::Bounds box = fit.box, mine = box_of(*own.volume);
  if (own.volume->active_voxels() > 0 && box.low == mine.low && box.high == mine.high)
    return std::nullopt;
  return box;
}

/// \param load reads the file at its path, unless that was done before.
template <class Load>
void load_source(Reader& reader, const Node& node, VolumeSource& source, const std::string& what,
                 const Load& load) {
  const Node& name = *child(node, "file");
  const fs::path path = reader.file(source.file);
  reader.within("file", [&] {
    if (reader.only_names(path)) return;
    const bool is_numbered = reader.frame_files() != nullptr;
    try {
      if (!source.sha256.empty()) check_digest(path, source.sha256);
      const std::string known = path.lexically_normal().string() + what;
      auto found = reader.volumes.find(known);
      if (found == reader.volumes.end()) {
        LoadedVolume loaded =
            load(path.string(), is_numbered ? Emptiness::allowed : Emptiness::refused);
        if (loaded.is_absent && !is_in_other_frames(reader, path.string(), what, load)) {
          // A name that no frame knows is a slip of the pen: the frames to come need not be tried.
          try {
            load(path.string(), Emptiness::refused);
          } catch (const Error& error) {
            reader.error(name, error.what(), error.code());
            reader.errors.back().is_of_frame = false;
          }
          return;
        }
        if (loaded.is_absent)
          loaded.warnings.push_back("lacks this grid, which other frames have: taken as empty");
        else if (loaded.volume->active_voxels() == 0)
          loaded.warnings.push_back("no active voxels: empty in this frame");
        found = reader.volumes.emplace(known, std::move(loaded)).first;
        if (std::find(reader.inputs.begin(), reader.inputs.end(), path.string())
            == reader.inputs.end())
          reader.inputs.push_back(path.string());
        for (const std::string& warning : found->second.warnings)
          reader.warning(name, path.string() + ": " + warning);
      }
      source.field.volume = found->second.volume;
      if (is_numbered && source.field.fit == scene::SparseGrid::Fit::unit_cube)
        source.field.fit_box = box_to_fit(reader, found->second, load);
    } catch (const Error& error) {
      reader.error(name, error.what(), error.code());
    }
  });
}

template <class Source>
std::vector<Key<Source>> volume_keys(const char* file_doc) {
  using Fit = scene::SparseGrid::Fit;
  return {required(key("file", &Source::file, text("the name of a file"), "",
                       std::string(file_doc) + "; the name is relative to the scene's folder")),
          key("sha256", &Source::sha256, text("64 hexadecimal digits, in lower case"), "",
              "of the file: another one is refused"),
          setter<Source>(
              "fit", Fit::none, [](Source& s, const Fit& fit) { s.field.fit = fit; },
              choice<Fit>({{"none", Fit::none}, {"unit_cube", Fit::unit_cube}}), "",
              "unit_cube: moved and scaled until it just fits into the unit cube of field space; "
              "none: field space is the file's own")};
}

Kind<Remap> remap() {
  return object<Remap>(
      {key("scale", &Remap::scale, number(limits::remap), "", "values are multiplied by it"),
       key("offset", &Remap::offset, number(limits::remap), "", "then it is added"),
       setter<Remap>(
           "clamp", glm::dvec2(Remap{}.low, Remap{}.high),
           [](Remap& r, const glm::dvec2& clamp) { r.low = clamp.x, r.high = clamp.y; },
           tuple<glm::dvec2>("low, high", number(limits::density)), "",
           "then what is beyond is cut"),
       key("gamma", &Remap::gamma, number(limits::gamma), "", "power that is taken at last")});
}

Kind<Interpolation> interpolation() {
  return choice<Interpolation>(
      {{"trilinear", Interpolation::trilinear}, {"nearest", Interpolation::nearest}});
}

/// \param fallback the grid that is meant where none is named.
Case<Field> vdb(const std::string& fallback) {
  std::vector<Key<VolumeSource>> keys = volume_keys<VolumeSource>("a .vdb or .nvdb file");
  keys.push_back(setter<VolumeSource>(
      "grid", fallback, [](VolumeSource& s, const std::string& grid) { s.grid = grid; },
      text("the name of a grid"), "",
      "which of the file's grids; \"density[1]\" is the second one of that name"));
  keys.push_back(setter<VolumeSource>(
      "interpolation", Interpolation::trilinear,
      [](VolumeSource& s, const Interpolation& i) { s.field.interpolation = i; }, interpolation(),
      "", "between the voxels"));
  keys.push_back(setter<VolumeSource>(
      "remap", Remap{}, [](VolumeSource& s, const Remap& r) { s.field.remap = r; }, remap(), "",
      "what densities are made of the values"));
  return one<Field, VolumeSource>(
      "vdb",
      "a grid of an OpenVDB or NanoVDB file; a level set is a solid; where there are no voxels its "
      "background counts",
      std::move(keys),
      {{},
       false,
       [=](Reader& reader, const Node& node, VolumeSource& source) {
         const std::string what = fmt::format("\n{}", source.grid.value_or(fallback));
         load_source(reader, node, source, what, [&](const std::string& path, Emptiness emptiness) {
           return load_volume(path, fallback, source.grid, emptiness);
         });
         const Volume* volume = source.field.volume.get();
         if (volume && volume->is_level_set() && !source.grid)
           reader.warning(node,
                          "this grid is a level set, a surface: what is inside is a solid of "
                          "density 1");
       }},
      [](const VolumeSource& source) { return Field(source.field); });
}

Case<Field> mesh() {
  std::vector<Key<VolumeSource>> keys = volume_keys<VolumeSource>("an .obj mesh");
  keys.push_back(key("voxels", &VolumeSource::voxels, integer<int>(limits::mesh_voxels), "",
                     "along its longest side"));
  return one<Field, VolumeSource>(
      "mesh",
      "density 1 within a closed mesh, or the share of each voxel that is inside where walls are "
      "thin; a shell two voxels thick along an open one",
      std::move(keys),
      {{},
       false,
       [](Reader& reader, const Node& node, VolumeSource& source) {
         const std::string what = fmt::format("\n{}", source.voxels);
         load_source(reader, node, source, what, [&](const std::string& path, Emptiness) {
           return load_mesh(path, source.voxels);
         });
       }},
      [](const VolumeSource& source) { return Field(source.field); });
}

Case<Field> grid() {
  return one<Field, DenseGrid>(
      "grid", "voxels in the unit cube, each value at its voxel's centre; x runs fastest",
      {required(key("size", &DenseGrid::size,
                    tuple<std::array<int, 3>>("x, y, z", integer<int>(limits::voxels)), "",
                    "number of voxels")),
       key("values", &DenseGrid::values, list(number<float>(limits::density)), "", "densities"),
       setter<DenseGrid>(
           "file", std::string("density.raw"),
           [](DenseGrid&, const std::string&) {},  // see load_values
           text("the name of a file"), "",
           "densities as 32-bit floats, little endian; the name is relative to the scene's folder"),
       key("interpolation", &DenseGrid::interpolation, interpolation(), "", "between the voxels"),
       key("remap", &DenseGrid::remap, remap(), "", "what densities are made of the values")},
      {{{"values"}, {"file"}}, true, load_values});
}

Kind<Field> field(const std::string& fallback) {
  const auto solid = [](const auto& body) { return Field(Solid{body}); };
  return variant<Field>(
      {one<Field, Everywhere>("homogeneous", "density 1 everywhere", {}, {}, solid),
       one<Field, Sphere>("sphere", "density 1 inside a sphere", sphere(), {}, solid),
       one<Field, Cuboid>("box", "density 1 inside a box", cuboid(), {}, solid),
       one<Field, Torus>("torus", "density 1 inside a torus", torus(), {}, solid),
       one<Field, Capsule>("capsule", "density 1 inside a capsule", capsule(), {}, solid),
       one<Field>("noise_cloud", "density clamp(contrast (noise + coverage - falloff q), 0, 1)",
                  noise_cloud()),
       grid(), vdb(fallback), mesh()});
}

struct PhaseSource {
  std::string file;
  std::shared_ptr<const PhaseTable> table;
};

void load_phase(Reader& reader, const Node& node, PhaseSource& source) {
  const std::string path = reader.file(source.file).string();
  reader.within("file", [&] {
    if (reader.only_names(path)) return;
    try {
      source.table = read_phase_file(path);
      reader.inputs.push_back(path);
    } catch (const Error& error) {
      reader.error(*child(node, "file"), error.what(), error.code());
    }
  });
}

Kind<Phase> phase() {
  return variant<Phase>(
      {one<Phase, IsotropicPhase>("isotropic", "all directions alike", {}),
       one<Phase, HenyeyGreensteinPhase>("henyey_greenstein", "a lobe forwards or backwards",
                                         {key("g", &HenyeyGreensteinPhase::g, number(limits::g), "",
                                              "mean cosine; above 0 is forwards")}),
       one<Phase, RayleighPhase>("rayleigh", "as clear air", {}),
       one<Phase, TwoLobesPhase>(
           "two_lobes", "two of henyey_greenstein together",
           {required(key("g1", &TwoLobesPhase::g1, number(limits::g), "",
                         "mean cosine of the first lobe")),
            required(key("g2", &TwoLobesPhase::g2, number(limits::g), "", "and of the second one")),
            required(key("weight", &TwoLobesPhase::weight, number(limits::lobe_weight), "",
                         "share of the first lobe"))}),
       one<Phase, PhaseSource>(
           "tabulated", "linear in the cosine of the angle between the rows of a table",
           {required(key("file", &PhaseSource::file, text("the name of a file"), "",
                         "rows \"cosine value\" from cosine -1 to 1, the values in any unit; the "
                         "name is relative to the scene's folder"))},
           {{}, false, load_phase},
           [](const PhaseSource& source) { return Phase(TabulatedPhase{source.table}); })});
}

/// Sine of an angle [degree], exact at multiples of 90. A series of its own, since libms differ in
/// the last bit and transforms reach the tallies.
double sine(double degrees) {
  // term + term * (-square / (k (k + 1))) + ..., down to the last bit for angles up to 45 degrees
  const auto series = [](double term, double square, int k) {
    double sum = term;
    for (; k < 24; k += 2) {
      term *= -square / (k * (k + 1));
      sum += term;
    }
    return sum;
  };
  const double radian = std::numbers::pi / 180;
  double x = std::remainder(degrees, 360.0);  // exact
  if (x > 90) x = 180 - x;
  if (x < -90) x = -180 - x;
  if (std::abs(x) <= 45) return series(x * radian, x * radian * x * radian, 2);
  const double rest = (90 - std::abs(x)) * radian;
  return std::copysign(series(1, rest * rest, 1), x);
}

double cosine(double degrees) { return sine(degrees + 90); }

/// 16 numbers, row by row, which is not glm's order.
glm::dmat4 by_rows(const std::array<double, 16>& numbers) {
  glm::dmat4 m;
  for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = numbers[static_cast<unsigned>(i)];
  return m;
}

struct Transform {
  glm::dvec3 translate{0.0}, rotate{0.0}, scale{1.0};
  std::array<double, 16> matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

  /// At most one of `matrix` and the rest is not the identity.
  glm::dmat4 whole() const {
    const glm::dvec3 s{sine(rotate.x), sine(rotate.y), sine(rotate.z)};
    const glm::dvec3 c{cosine(rotate.x), cosine(rotate.y), cosine(rotate.z)};
    const glm::dmat3 about_x(1, 0, 0, 0, c.x, s.x, 0, -s.x, c.x);  // column by column
    const glm::dmat3 about_y(c.y, 0, -s.y, 0, 1, 0, s.y, 0, c.y);
    const glm::dmat3 about_z(c.z, s.z, 0, -s.z, c.z, 0, 0, 0, 1);
    const glm::dmat3 scaled(scale.x, 0, 0, 0, scale.y, 0, 0, 0, scale.z);
    glm::dmat4 parts(about_z * about_y * about_x * scaled);
    parts[3] = glm::dvec4(translate, 1.0);
    return by_rows(matrix) * parts;
  }
};

Kind<glm::dmat4> transform() {
  const Kind<Transform> parts = object<Transform>(
      {key("translate", &Transform::translate, vector(limits::coordinate), "length",
           "moved by, at last"),
       key("rotate", &Transform::rotate, vector(limits::angle), "degree",
           "turned about x, then y, then z"),
       key("scale", &Transform::scale, tuple<glm::dvec3>("x, y, z", number(limits::factor), true),
           "length/field unit", "stretched by, first of all"),
       key("matrix", &Transform::matrix,
           tuple<std::array<double, 16>>("xx, xy, xz, x, yx, yy, yz, y, zx, zy, zz, z, 0, 0, 0, 1",
                                         number(limits::factor)),
           "", "all in one: an affine matrix, row by row")},
      {{{"translate", "rotate", "scale"}, {"matrix"}}});
  return {"",
          [=](Reader& reader, const Node& node, glm::dmat4& value) {
            Transform read;
            parts.read(reader, node, read);
            value = read.whole();
          },
          parts.schema,
          [=](const glm::dmat4&, const std::string& indent) { return parts.list({}, indent); },
          {},
          true};
}

Kind<Emission> emission() {
  return variant<Emission>(
      {one<Emission, NoEmission>("none", "dark", {}),
       one<Emission, ColorEmission>(
           "color", "the same colour throughout, times a field or a grid of colours",
           {key("radiance", &ColorEmission::radiance, color(limits::light), "W/(area sr)",
                "of an opaque body"),
            key("field", &ColorEmission::field, field("emission"), "",
                "in the space of the component's own; a grid from a file is placed as that is")}),
       one<Emission, BlackbodyEmission>(
           "blackbody", "glows as hot things do, in W/(m^2 sr) as bright as the eye sees it",
           {required(key("temperature", &BlackbodyEmission::temperature, field("temperature"), "K",
                         "a field of temperatures; its remap makes kelvins of other numbers")),
            key("intensity", &BlackbodyEmission::intensity, number(limits::light), "",
                "times the radiance of a black body")})});
}

Kind<Component> component() {
  return object<Component>(
      {required(key("field", &Component::field, field("density"), "",
                    "where its matter is: the density")),
       required(key("extinction", &Component::extinction, number(limits::extinction), "1/length",
                    "at density 1")),
       key("albedo", &Component::albedo, color(limits::albedo), "",
           "scattered share of the extinction"),
       key("phase", &Component::phase, phase(), "", "where the scattered light goes"),
       key("emission", &Component::emission, emission(), "",
           "what it shines by itself: as it absorbs, extinction (1 - albedo) times a radiance"),
       key("transform", &Component::transform, transform(), "",
           "from field space to world space")});
}

std::vector<Key<Medium>> ground() {
  using Albedo = std::optional<glm::dvec3>;
  std::vector<Key<Medium>> faces;
  for (std::size_t face = 0; face < face_names.size(); ++face)
    faces.push_back(setter<Medium>(
        face_names[face], Albedo{},
        [face](Medium& medium, const Albedo& albedo) { medium.ground[face] = albedo; },
        or_null(color(limits::albedo)), "", "share of the light that this face reflects"));
  return faces;
}

Kind<Medium> medium() {
  const auto side = choice<Side>({{"open", Side::open}, {"periodic", Side::periodic}});
  return object<Medium>(
      {group<Medium>(
           "box",
           {key("min", &Medium::box_min, vector(limits::coordinate), "length", "lower corner"),
            key("max", &Medium::box_max, vector(limits::coordinate), "length", "upper corner")},
           "outside of it there is nothing; where it is not given and all fields are volumes from "
           "files, it holds them all"),
       key("sides", &Medium::sides, tuple<std::array<Side, 3>>("x, y, z", side), "",
           "of the box: light leaves through open ones and comes back on the other side of "
           "periodic ones"),
       group<Medium>("ground", ground(),
                     "faces of the box that are opaque, and reflect what meets them from inside "
                     "evenly in all directions; null: none"),
       group<Medium>(
           "majorants",
           {key("resolution", &Medium::majorant_resolution, cells(limits::majorants), "",
                "super-voxels; 0: as many as pay")},
           "grid of bounds of the extinction; changes the time a render takes, not what it shows"),
       required(key("components", &Medium::components, list(component()), "", "they add up"))});
}

template <class L>
Key<L> light_group() {
  return key("group", &L::group, text("a name"), "",
             "lights of one name are one group; those without a name, too");
}

/// For lights whose power is over the radiance (or intensity) what `extent` says.
template <class L>
Rules<L> or_power(const char* name, glm::dvec3 L::*amount, double (*extent)(const L&)) {
  return {{{name}, {"power"}}, true, [=](Reader&, const Node& node, L& light) {
            const double over = extent(light);
            if (child(node, "power") && over > 0) light.*amount /= over;
          }};
}
/// See or_power().
template <class L>
Key<L> power(glm::dvec3 L::*amount, const char* doc) {
  return setter<L>(
      "power", glm::dvec3(1), [=](L& light, const glm::dvec3& power) { light.*amount = power; },
      color(limits::light), "W", doc);
}

void load_environment(Reader& reader, const Node& node, EnvironmentLight& light) {
  const Node* name = child(node, "image");
  if (!name) return;
  const std::string path = reader.file(name->value.get<std::string>()).string();
  reader.within("image", [&] {
    if (reader.only_names(path)) return;
    try {
      const LoadedImage loaded = load_image(path);
      light.image = loaded.image;
      if (std::find(reader.inputs.begin(), reader.inputs.end(), path) == reader.inputs.end())
        reader.inputs.push_back(path);
      for (const std::string& warning : loaded.warnings)
        reader.warning(*name, fmt::format("{}: {}", path, warning));
    } catch (const Error& error) {
      reader.error(*name, error.what(), error.code());
    }
  });
}

Kind<Light> light() {
  constexpr double sphere_steradians = 4 * std::numbers::pi;
  const char* const radiance_unit = "W/(area sr)";
  return variant<Light>(
      {one<Light, PointLight>("point", "shines alike in all directions",
                              {required(key("position", &PointLight::position,
                                            vector(limits::coordinate), "length", "where it is")),
                               key("power", &PointLight::power, color(limits::light), "W",
                                   "into all directions together"),
                               setter<PointLight>(
                                   "intensity", glm::dvec3(1.0 / sphere_steradians),
                                   [](PointLight& l, const glm::dvec3& intensity) {
                                     l.power = sphere_steradians * intensity;
                                   },
                                   color(limits::light), "W/sr", "into every direction"),
                               light_group<PointLight>()},
                              {{{"power"}, {"intensity"}}, true}),
       one<Light, DirectionalLight>(
           "directional", "parallel light, or a sun's",
           {required(key("direction", &DirectionalLight::direction, vector(limits::coordinate), "",
                         "the way it travels")),
            required(key("irradiance", &DirectionalLight::irradiance, color(limits::light),
                         "W/area", "on a plane across the light")),
            key("angle", &DirectionalLight::angle, number(limits::sun_angle), "degree",
                "across the sun's disc, which the camera sees; 0: parallel, and unseen"),
            light_group<DirectionalLight>()}),
       one<Light, EnvironmentLight>(
           "environment", "radiance from everywhere; the camera sees it",
           {key("radiance", &EnvironmentLight::radiance, color(limits::light), radiance_unit,
                "the same from every direction"),
            setter<EnvironmentLight>(
                "image", std::string("sky.hdr"),
                [](EnvironmentLight&, const std::string&) {},  // see load_environment
                text("the name of a file"), "",
                "radiance by longitude and latitude, the top row at +y, the middle at +z, the "
                "left half at +x; the name is relative to the scene's folder"),
            key("scale", &EnvironmentLight::scale, number(limits::image_scale), "",
                "times the radiance, or times the image"),
            key("rotation", &EnvironmentLight::rotation, number(limits::angle), "degree",
                "of the image about +y: 90 takes what is at +z to +x"),
            light_group<EnvironmentLight>()},
           {{{"radiance"}, {"image"}}, true, load_environment}),
       one<Light, SpotLight>(
           "spot", "a point light that shines into a cone",
           {required(key("position", &SpotLight::position, vector(limits::coordinate), "length",
                         "where it is")),
            required(key("direction", &SpotLight::direction, vector(limits::coordinate), "",
                         "the cone's axis")),
            key("angle", &SpotLight::angle, number(limits::spot_angle), "degree",
                "of the whole cone"),
            key("edge", &SpotLight::edge, number(limits::spot_edge), "",
                "share of the half angle over which it fades"),
            key("intensity", &SpotLight::intensity, color(limits::light), "W/sr",
                "along the direction"),
            power(&SpotLight::intensity, "into all of the cone"), light_group<SpotLight>()},
           or_power<SpotLight>("intensity", &SpotLight::intensity, solid_angle)),
       one<Light, RectangleLight>(
           "rectangle", "a parallelogram that shines on one side; it is seen, and blocks nothing",
           {required(key("center", &RectangleLight::center, vector(limits::coordinate), "length",
                         "its middle")),
            required(key("edge_u", &RectangleLight::edge_u, vector(limits::coordinate), "length",
                         "one edge, from end to end")),
            required(key("edge_v", &RectangleLight::edge_v, vector(limits::coordinate), "length",
                         "the other; cross(edge_u, edge_v) points to the bright side")),
            key("radiance", &RectangleLight::radiance, color(limits::light), radiance_unit,
                "into every direction of that side"),
            power(&RectangleLight::radiance, "of all of it"), light_group<RectangleLight>()},
           or_power<RectangleLight>("radiance", &RectangleLight::radiance, etendue)),
       one<Light, SphereLight>(
           "sphere", "shines outwards; it is seen, and blocks nothing",
           {required(key("center", &SphereLight::center, vector(limits::coordinate), "length",
                         "its middle")),
            required(key("radius", &SphereLight::radius, number(limits::size), "length", "radius")),
            key("radiance", &SphereLight::radiance, color(limits::light), radiance_unit,
                "from every point into every direction"),
            power(&SphereLight::radiance, "of all of it"), light_group<SphereLight>()},
           or_power<SphereLight>("radiance", &SphereLight::radiance, etendue))});
}

/// A kind of camera, which has some keys of its own.
Case<Camera> one_camera(const std::string& name, Projection projection, const std::string& doc,
                        const std::vector<Key<Camera>>& own, Rules<Camera> rules = {}) {
  std::vector<Key<Camera>> keys = {
      key("position", &Camera::position, vector(limits::coordinate), "length", "where it is"),
      key("look_at", &Camera::look_at, vector(limits::coordinate), "length",
          "seen in the middle of the picture"),
      key("up", &Camera::up, vector(limits::coordinate), "",
          "direction that is upwards in the picture"),
      setter<Camera>(
          "matrix", std::array<double, 16>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
          [](Camera& c, const std::array<double, 16>& matrix) { c.matrix = by_rows(matrix); },
          tuple<std::array<double, 16>>("xx, xy, xz, x, yx, yy, yz, y, zx, zy, zz, z, 0, 0, 0, 1",
                                        number(limits::coordinate)),
          "", "from camera to world, row by row; the camera looks along -z, y is up")};
  keys.insert(keys.end(), own.begin(), own.end());
  keys.push_back(key("resolution", &Camera::resolution,
                     tuple<std::array<int, 2>>("width, height", integer<int>(limits::pixels)),
                     "pixel", "size of the picture"));
  keys.push_back(key("crop", &Camera::crop,
                     tuple<std::array<int, 4>>("x0, y0, x1, y1", integer<int>(limits::crop)),
                     "pixel",
                     "the part of the picture that is rendered, without x1 and y1; all 0: the "
                     "whole"));
  rules.second_alternatives = {{"position", "look_at", "up"}, {"matrix"}};
  rules.is_usual = projection == Projection::perspective;
  return one<Camera, Camera>(name, doc, std::move(keys), std::move(rules),
                             [projection](const Camera& read) {
                               Camera camera = read;
                               camera.projection = projection;
                               return camera;
                             });
}

Kind<Camera> camera() {
  return variant<Camera>(
      {one_camera(
           "perspective", Projection::perspective, "a pinhole, or a thin lens",
           {key("fov", &Camera::fov, number(limits::fov), "degree",
                "full angle across the picture's width"),
            setter<Camera>(
                "focal_length", 50.0,
                [](Camera& c, const double& length) { c.focal_length = length; },
                number(limits::size), "unit of film_width", "of a lens focused far away"),
            key("film_width", &Camera::film_width, number(limits::size), "unit of focal_length",
                "beside focal_length: what the width of the picture falls on"),
            key("aperture_radius", &Camera::aperture_radius, number(limits::lens), "length",
                "of the lens; 0: a pinhole, which has all in focus"),
            key("focus_distance", &Camera::focus_distance, number(limits::lens), "length",
                "along the view, to the plane that is in focus; 0: to look_at")},
           {{{"fov"}, {"focal_length", "film_width"}},
            false,
            [](Reader& reader, const Node& node, Camera&) {
              const Node* width = child(node, "film_width");
              if (!width || child(node, "focal_length")) return;
              reader.within("film_width", [&] {
                reader.error_at_key(*width, "expected a \"focal_length\" beside it");
              });
            }}),
       one_camera(
           "orthographic", Projection::orthographic, "parallel rays, from its plane on",
           {key("width", &Camera::width, number(limits::size), "length", "across the picture")}),
       one_camera("spherical", Projection::spherical,
                  "all directions: longitude across, latitude down, look_at in the middle", {})});
}

Kind<Detectors> detectors() {
  const auto bins = integer<int>(limits::bins);
  return object<Detectors>(
      {key("flux", &Detectors::flux, tuple<std::array<int, 2>>("u, v", integer<int>(limits::flux)),
           "",
           "cells of each face, and the power that leaves through them; u and v are the two other "
           "axes in the order x, y, z"),
       group<Detectors>("path_length",
                        {key("bins", &Detectors::path_length_bins, bins, "", "from 0 to max"),
                         key("max", &Detectors::path_length_max, number(limits::path_length),
                             "length", "end of the last bin, which takes what is beyond, too")},
                        "power that leaves, by the length of its way through the medium"),
       group<Detectors>("scatterings",
                        {key("bins", &Detectors::scattering_bins, bins, "",
                             "0, 1, 2 ... scatterings; the last one takes more, too")},
                        "power that leaves, by how often it was scattered"),
       group<Detectors>("exit_angle", {key("bins", &Detectors::exit_angle_bins, bins, "", "even")},
                        "power that leaves, by the cosine to the outward normal of the face"),
       key("absorbed", &Detectors::absorbed, cells(limits::voxels_absorbed), "",
           "voxels, and the power that is absorbed in them")});
}

constexpr int format_version = 1;

Key<Scene> version() {
  return {"tyndall",
          {fmt::format("{}", format_version),
           [](Reader&, const Node&, Scene&) {},  // see refuse_other_versions
           [] {
             return Json{{"const", format_version}};
           },
           [](const Scene&, const std::string&) { return fmt::format("{}", format_version); }},
          "",
          "version of the scene format",
          true};
}

const Kind<Scene>& table() {
  static const auto& scene = *new Kind<Scene>(object<Scene>(  // never taken down: it takes long
      {version(),
       required(key("medium", &Scene::medium, medium(), "", "what scatters and absorbs")),
       key("lights", &Scene::lights, list(light()), "", "where the photons come from"),
       key("camera", &Scene::camera, camera(), "",
           "what sees the picture; by default along +z, where +x is on the left"),
       key("background", &Scene::background, color(limits::light), "W/(area sr)",
           "radiance behind everything; it lights nothing"),
       key("sampler", &Scene::sampler,
           choice<Sampler>({{"super_voxel", Sampler::super_voxel},
                            {"woodcock", Sampler::woodcock},
                            {"ray_marching", Sampler::ray_marching}}),
           "", "how free paths are drawn; ray_marching is biased"),
       key("integrator", &Scene::integrator,
           choice<Integrator>({{"photons", Integrator::photons}, {"path", Integrator::path}}), "",
           "photons that light a grid, which the picture is gathered from; or paths from the "
           "camera alone, which know no bias, for comparison"),
       key("marching_step", &Scene::marching_step, number(limits::marching_step), "length",
           "step of ray_marching, 0: one voxel of the finest component"),
       group<Scene>(
           "photons",
           {key("count", &Scene::photons, integer<std::uint64_t>(limits::photons), "",
                "photons to shoot"),
            group<Scene>(
                "illumination",
                {key("resolution", &Scene::illumination_resolution, cells(limits::illumination), "",
                     "cells; 0: as many as make them 1.75 mean free paths of the densest matter "
                     "wide, "
                     "64 to 128 along the longest edge; in a box that is nearly empty about the "
                     "matter alone"),
                 key("order", &Scene::illumination_order, integer<int>(limits::order), "",
                     "of the spherical harmonics, -1: 2 unless all scattering is isotropic")},
                "grid in which the photons leave their light")},
           "the first pass: from the lights into the medium"),
       group<Scene>(
           "gather",
           {key("samples", &Scene::samples, integer<std::uint64_t>(limits::samples), "",
                "per pixel"),
            key("bounces", &Scene::bounces, or_null(integer<int>(limits::bounces)), "",
                "scatterings of the camera's paths before they read the grid: more are "
                "slower, and less blurred by its cells. null: 1, and up to 3 where cells are wider "
                "than 0.9 transport mean free paths"),
            key("single_scattering", &Scene::single_scattering,
                choice<SingleScattering>(
                    {{"apart", SingleScattering::apart}, {"grid", SingleScattering::grid}}),
                "",
                "apart: light that is scattered once comes by shadow walks, sharp; grid: "
                "it is in the grid with all other light, faster and blurred"),
            key("seed", &Scene::gather_seed, or_null(integer<std::uint64_t>(limits::seed)), "",
                "of the random numbers of this pass; null: the scene's seed. Another one "
                "is other grain by the same light")},
           "the second pass: from the camera into the medium"),
       group<Scene>("film",
                    {key("filter", &Scene::filter,
                         choice<Filter>({{"box", Filter::box},
                                         {"gaussian", Filter::gaussian},
                                         {"blackman_harris", Filter::blackman_harris}}),
                         "",
                         "how a pixel weighs the light around its middle; the radius is 3 standard "
                         "deviations of gaussian"),
                     key("filter_radius", &Scene::filter_radius, number(limits::filter_radius),
                         "pixel", "0: 0.5 of box, 1.5 of the others")},
                    "what the picture falls on"),
       group<Scene>("preview",
                    {key("exposure", &Scene::exposure, number(limits::exposure), "EV",
                         "brightness of the PNG alone")},
                    "the picture for the eye"),
       key("detectors", &Scene::detectors, detectors(), "",
           "what is counted of the photons for `render --detectors FILE`; 0: nothing"),
       key("seed", &Scene::seed, integer<std::uint64_t>(limits::seed), "",
           "of all random numbers; one seed, one picture")}));
  return scene;
}

// ---- Entry points. ----

std::string load(const std::string& path) {
  constexpr std::size_t most = std::size_t{256} << 20;
  const auto unreadable = [&](const std::string& why) {
    throw Error(ExitCode::input_missing, fmt::format("{}: {}", path, why));
  };
  std::error_code error;
  if (fs::is_directory(path, error)) unreadable("is a folder, expected a scene file");
  if (!fs::exists(path, error)) unreadable(error ? error.message() : "no such file");
  std::ifstream file(path, std::ios::binary);
  std::string text;
  char block[1 << 16];
  while (file.read(block, sizeof block), file.gcount() > 0 && text.size() <= most) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
  }
  if (!file.eof() && text.size() <= most) unreadable("cannot be read");
  if (text.size() > most)
    unreadable("larger than 256 MiB; put the values of grids into files of their own");
  return text;
}

/// Puts the value of `option` at `path`; objects on the way are made where they are missing.
void replace(Node& root, const std::string& path, const Source& option, Reader& reader) {
  Node* node = &root;
  std::string so_far;
  for (const std::string& step : steps(path)) {
    Node* next = child(*node, step);
    if (!next && !node->value.is_object()) {
      const std::string what = so_far.empty() ? "the scene" : so_far;
      reader.errors.push_back(
          {&option, 0, path, fmt::format("no such place: {} is {}", what, quote(*node))});
      return;
    }
    if (!next) {
      next = &node->children.emplace_back();
      next->source = &option;
      next->key = step;
      next->value = Json::object();
    }
    so_far += (so_far.empty() ? "" : ".") + step;
    node = next;
  }
  Node value = parse_option(option);
  value.key = node->key;
  *node = std::move(value);
}

/// \return whether one of two paths leads through the other.
bool related(std::string_view a, std::string_view b) {
  if (a.size() > b.size()) std::swap(a, b);
  return b.starts_with(a)
         && (a.empty() || a.size() == b.size() || b[a.size()] == '.' || b[a.size()] == '[');
}

[[noreturn]] void throw_all(std::vector<Finding> errors) {
  constexpr std::size_t most = 100;
  std::stable_sort(errors.begin(), errors.end(), [](const Finding& a, const Finding& b) {
    return std::pair(a.source->option, a.offset) < std::pair(b.source->option, b.offset);
  });
  std::string lines;
  for (std::size_t i = 0; i < std::min(most, errors.size()); ++i)
    lines += fmt::format("{}{}", i == 0 ? "" : "\n", errors[i].text());
  if (errors.size() > most) lines += fmt::format("\n... and {} more", errors.size() - most);
  const bool only_files = std::all_of(errors.begin(), errors.end(), [](const Finding& error) {
    return error.code == ExitCode::input_missing;
  });
  if (only_files
      && std::all_of(errors.begin(), errors.end(), [](const Finding& e) { return e.is_of_frame; }))
    throw UnreadableFrame(lines);
  // What is wrong with the scene comes first; then what the machine lacks, before what files do.
  ExitCode code = errors[0].code;
  for (const Finding& error : errors) {
    if (error.code == ExitCode::scene_invalid) throw Error(error.code, lines);
    code = std::max(code, error.code);
  }
  throw Error(code, lines);
}

/// Where all fields are volumes, which end where their voxels do: the box that holds them.
void enclose_volumes(Medium& medium) {
  glm::dvec3 low(1e300), high(-1e300);
  for (const Component& c : medium.components) {
    const auto* grid = std::get_if<scene::SparseGrid>(&c.field);
    if (!grid || !grid->volume) return;
    if (grid->volume->active_voxels() == 0) continue;
    const ActiveBounds box =
        active_box(*grid->volume, c.transform * fitted(*grid) * grid->volume->to_world());
    low = glm::min(low, box.low), high = glm::max(high, box.high);
  }
  if (low.x <= high.x) medium.box_min = low, medium.box_max = high;
}

/// Of another version every key may differ: its other errors would be noise.
void refuse_other_versions(const Node& root) {
  const Node* version = root.value.is_object() ? child(root, "tyndall") : nullptr;
  if (!version || version->value == format_version) return;
  throw_all({{version->source, version->offset, "tyndall",
              fmt::format("this build reads scenes of version {}, got {}", format_version,
                          quote(*version))}});
}

/// The text of a scene, with overrides.
struct Written {
  std::vector<Source> sources;
  Node root;  ///< points to these
};

Written parse_scene(const std::string& name, const std::string& text,
                    const std::vector<std::string>& overrides, Reader& reader) {
  Written written{{{name, text}}, {}};
  std::vector<Source>& sources = written.sources;
  sources.reserve(1 + overrides.size());  // nodes point to them
  Node& root = written.root = parse(sources[0]);
  for (const std::string& option : overrides) {
    const std::size_t equal = option.find('=');
    const std::string place = option.substr(0, equal);
    const std::vector<std::string> names = steps(place);
    if (equal == option.npos || std::find(names.begin(), names.end(), "") != names.end()) {
      throw Error(ExitCode::usage,
                  fmt::format("-D {}: expected PATH=VALUE, such as camera.fov=30", option));
    }
    sources.push_back({"-D " + option, option.substr(equal + 1), true});
    replace(root, place, sources.back(), reader);
  }
  refuse_other_versions(root);
  return written;
}

SceneFile read_written(const std::string& name, const std::string& text, const std::string& folder,
                       const std::vector<std::string>& overrides, SequenceFiles* sequence) {
  Reader reader(folder, sequence);
  const Written written = parse_scene(name, text, overrides, reader);
  const Node& root = written.root;
  Scene scene;
  table().read(reader, root, scene);

  const Node* medium = child(root, "medium");
  if (medium && !child(*medium, "box")) enclose_volumes(scene.medium);

  const Problems problems = check(scene);
  const auto finding = [&](const Problem& problem) {
    const Node& node = nearest_node(root, problem.path);
    return Finding{node.source, node.offset, problem.path, problem.message};
  };
  // What could not be read has its default, of which check() knows nothing.
  std::vector<std::string> unread = std::move(reader.unread);
  for (const Finding& error : reader.errors) unread.push_back(error.path);
  std::vector<Finding> errors = std::move(reader.errors);
  for (const Problem& problem : problems.errors) {
    const auto covers = [&](const std::string& other) {
      return related(other, problem.path)
             || std::any_of(problem.depends_on.begin(), problem.depends_on.end(),
                            [&](const std::string& key) { return related(other, key); });
    };
    if (std::none_of(unread.begin(), unread.end(), covers)) errors.push_back(finding(problem));
  }
  if (!errors.empty()) throw_all(std::move(errors));
  std::vector<std::string> warnings, inputs = std::move(reader.inputs);
  for (const Finding& warning : reader.warnings) warnings.push_back(warning.text());
  for (const Problem& warning : problems.warnings) warnings.push_back(finding(warning).text());
  std::vector<LoadedVolume> volumes;
  for (auto& [known, volume] : reader.volumes) volumes.push_back(std::move(volume));
  return {std::move(scene), std::move(warnings), std::move(inputs), std::move(volumes)};
}

}  // namespace

SceneFile read_scene(const std::string& path, const std::vector<std::string>& overrides,
                     const std::function<std::string(const std::string&)>& edit,
                     SequenceFiles* sequence) {
  const std::string text = load(path);
  SceneFile file = read_written(path, edit ? edit(text) : text,
                                fs::path(path).parent_path().string(), overrides, sequence);
  file.inputs.insert(file.inputs.begin(), path);
  return file;
}

SceneFile read_scene_text(const std::string& name, const std::string& text,
                          const std::string& folder, const std::vector<std::string>& overrides) {
  return read_written(name, text, folder, overrides, nullptr);
}

std::vector<NamedFile> scene_files(const std::string& path,
                                   const std::vector<std::string>& overrides,
                                   const std::function<std::string(const std::string&)>& edit) {
  Reader reader(fs::path(path).parent_path().string());
  reader.is_names_only = true;
  const Written written = parse_scene(path, edit(load(path)), overrides, reader);
  Scene scene;
  table().read(reader, written.root, scene);
  if (!reader.errors.empty()) throw_all(std::move(reader.errors));
  return std::move(reader.named);
}

std::string schema() {
  Json whole{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
             {"title", "Tyndall scene"}};
  whole.update(table().schema());
  return whole.dump(2) + "\n";
}

std::string defaults() {
  return "// Every key of a scene at its default, with its meaning, its unit and what it may be. "
         "Required keys have no\n"
         "// default: their values are examples. What a key may be instead stands in comments.\n"
         + table().list({}, "") + "\n";
}

}  // namespace tyndall::io
