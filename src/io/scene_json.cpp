// Scene files: src/scene describes their keys; this file reads the files that they name.
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
#include "tyndall/render/error.h"
#include "tyndall/render/huge_pages.h"
#include "tyndall/render/resolved_scene.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {
namespace {

using namespace scene;
using scene::Camera;
using scene::Component;
using scene::DenseGrid;
using scene::Solid;
namespace fs = std::filesystem;

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

/// The keys of a volume in a scene, and the field that results.
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
        fmt::format("{}: its SHA-256 is {}, expected {}: not the file that the scene expects",
                    path.string(), digest, expected));
}

/// \return in a sequence, whether a file other than `path` has the grid that `path` lacks.
template <class Load>
bool is_in_other_frames(Reader& reader, const std::string& path, const std::string& what,
                        const Load& load) {
  const auto [known, is_new] = reader.sequence->is_somewhere.try_emplace(reader.path() + what);
  for (const std::string& file : *reader.frame_files()) {
    if (!is_new || known->second) break;
    if (file == path) continue;
    try {
      known->second = !load(file, Emptiness::allowed).is_absent;
    } catch (const Error&) {  // reported with its own frame
    }
  }
  return known->second;
}

/// \return in a sequence, the box that `fit` maps to the unit cube in every frame; nullopt if it is
/// the box of the volume itself.
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
    } catch (const Error&) {  // reported with its own frame
    }
  }
  if (fit.file.empty()) return std::nullopt;  // all frames are empty
  const scene::SparseGrid::Bounds box = fit.box, mine = box_of(*own.volume);
  if (own.volume->active_voxels() > 0 && box.low == mine.low && box.high == mine.high)
    return std::nullopt;
  return box;
}

/// Sets the volume of `source`, which is read only once. \param load reads the file at a path
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
          // A grid that no frame has is an error of the scene, so later frames need not be tried.
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

/// Describes one key of SparseGrid as a key of VolumeSource.
template <class V>
struct FieldKey : scene::Visitor<FieldKey<V>> {
  FieldKey(V& visitor, std::string_view name) : visitor_(visitor), name_(name) {
    scene::visit_keys<scene::SparseGrid>(*this);
  }
  template <class M, class Form>
  void operator()(Name name, M scene::SparseGrid::*member, const Form& form, const char* unit,
                  const char* doc) {
    if (name.text != name_) return;
    visitor_.alias(
        name, scene::SparseGrid{}.*member,
        [member](VolumeSource& source, const M& value) { source.field.*member = value; }, form,
        unit, doc);
  }

 private:
  V& visitor_;
  const std::string_view name_;
};

template <class V>
void describe_file(V& v, const char* doc) {
  v(required("file"), &VolumeSource::file, Text{"the name of a file"}, "", doc);
  v("sha256", &VolumeSource::sha256, Text{"64 hexadecimal digits, in lower case"}, "",
    "checksum of the file; other files are refused");
  FieldKey(v, "fit");
}

struct VdbSource : VolumeSource {
  std::string fallback;  ///< the default of "grid"
};

template <class V>
void describe_vdb(V& v, const std::string& fallback) {
  describe_file(v, "a .vdb or .nvdb file; the name is relative to the scene's folder");
  v.alias(
      "grid", fallback, [](VolumeSource& s, const std::string& grid) { s.grid = grid; },
      Text{"the name of a grid"}, "",
      "which of the file's grids; \"density[1]\" is the second one of that name");
  FieldKey(v, "interpolation");
  FieldKey(v, "remap");
}

void load_vdb(Reader& reader, const Node& node, VdbSource& source) {
  const std::string what = fmt::format("\n{}", source.grid.value_or(source.fallback));
  load_source(reader, node, source, what, [&](const std::string& path, Emptiness emptiness) {
    return load_volume(path, source.fallback, source.grid, emptiness);
  });
  const Volume* volume = source.field.volume.get();
  if (volume && volume->is_level_set() && !source.grid)
    reader.warning(node,
                   "this grid is a level set, a surface: its interior is a solid of density 1");
}

struct MeshSource : VolumeSource {};

template <class V>
void describe_mesh(V& v) {
  describe_file(v, "an .obj mesh; the name is relative to the scene's folder");
  v("voxels", &VolumeSource::voxels, limits::mesh_voxels, "", "along its longest side");
}

void load_mesh_file(Reader& reader, const Node& node, MeshSource& source) {
  const std::string what = fmt::format("\n{}", source.voxels);
  load_source(reader, node, source, what,
              [&](const std::string& path, Emptiness) { return load_mesh(path, source.voxels); });
}

void load_phase(Reader& reader, const Node& node, TabulatedPhase& phase) {
  const Node& name = *child(node, "file");
  const std::string path = reader.file(name.value.get<std::string>()).string();
  reader.within("file", [&] {
    if (reader.only_names(path)) return;
    try {
      phase.table = read_phase_file(path);
      reader.inputs.push_back(path);
    } catch (const Error& error) {
      reader.error(name, error.what(), error.code());
    }
  });
}

/// \return the sine of an angle [degree], exact at multiples of 90. The series is our own because
/// implementations of libm differ in the last bit, and transforms affect the tallies.
double sine(double degrees) {
  // term + term * (-square / (k (k + 1))) + ..., accurate to the last bit up to 45 degrees
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

struct Transform {
  glm::dvec3 translate{0.0}, rotate{0.0}, scale{1.0};
  std::array<double, 16> matrix = identity;

  /// \return the transform. Either `matrix` or the product of the others is the identity.
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

template <class V>
constexpr void describe(V& v, Type<Transform>) {
  v("translate", &Transform::translate, limits::coordinate, "length", "translation, applied last");
  v("rotate", &Transform::rotate, limits::angle, "degree", "rotation about x, then y, then z");
  v("scale", &Transform::scale, cells(limits::factor), "length/field unit",
    "scale factors, applied first");
  v("matrix", &Transform::matrix, matrix(limits::factor), "",
    "the whole transform as an affine matrix, row by row");
  v.alternatives({{"translate", "rotate", "scale"}, {"matrix"}});
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

void refuse_lone_film_width(Reader& reader, const Node& node) {
  const Node* width = child(node, "film_width");
  if (!width || child(node, "focal_length")) return;
  reader.within("film_width",
                [&] { reader.error_at_key(*width, "expected a \"focal_length\" beside it"); });
}

constexpr int format_version = 1;

const Constant& version() {
  static const Constant version{"tyndall", format_version, fmt::format("{}", format_version),
                                "version of the scene format", true};
  return version;
}

}  // namespace

// ---- Additions to the descriptions

template <>
struct WrittenAs<glm::dmat4> {
  using Thing = Transform;
  static glm::dmat4 of(const Transform& transform) { return transform.whole(); }
};

template <>
struct Finish<DenseGrid> {
  static void run(Reader& r, const Node& n, DenseGrid& grid) { load_values(r, n, grid); }
};
template <>
struct Finish<VdbSource> {
  static void run(Reader& r, const Node& n, VdbSource& source) { load_vdb(r, n, source); }
};
template <>
struct Finish<MeshSource> {
  static void run(Reader& r, const Node& n, MeshSource& source) { load_mesh_file(r, n, source); }
};
template <>
struct Finish<TabulatedPhase> {
  static void run(Reader& r, const Node& n, TabulatedPhase& phase) { load_phase(r, n, phase); }
};
template <>
struct Finish<EnvironmentLight> {
  static void run(Reader& r, const Node& n, EnvironmentLight& l) { load_environment(r, n, l); }
};
template <>
struct Finish<Camera> {
  static void run(Reader& r, const Node& n, Camera&) { refuse_lone_film_width(r, n); }
};

/// In the file, each body is a type of field.
template <>
struct Case<Solid> {
  template <class Use>
  static void visit(const char*, const char*, const Things& form, const Use& use) {
    const auto body = [&]<class P>(Type<P>, const char* name, const char* doc) {
      Case<P>::visit(
          name, doc, form,
          [&](const auto& word, const auto& text, P&& initial, const auto& keys, const auto&) {
            use(word, text, std::move(initial), keys,
                [](P&& read) { return Solid{std::move(read)}; });
          });
    };
    visit_cases<SolidBody>(body);
  }
};

/// In the file, the type of a sparse grid is that of its source.
template <>
struct Case<scene::SparseGrid> {
  template <class Use>
  static void visit(const char*, const char*, const Things& form, const Use& use) {
    use(
        "vdb",
        "a grid of an OpenVDB or NanoVDB file; a level set is a solid; outside its voxels the grid "
        "has its background value",
        VdbSource{{}, form.grid}, [&](auto& v) { describe_vdb(v, form.grid); },
        [](VdbSource&& source) { return std::move(source.field); });
    use(
        "mesh",
        "density 1 within a closed mesh, or the fraction of each voxel that is inside if walls are "
        "thin; a shell two voxels thick along an open one",
        MeshSource{}, [](auto& v) { describe_mesh(v); },
        [](MeshSource&& source) { return std::move(source.field); });
  }
};

namespace {

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

/// Sets the value at `path` to that of `option`; missing objects on the way are created.
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

/// \return whether one of two paths is equal to the other or an ancestor of it.
bool related(std::string_view a, std::string_view b) {
  if (a.size() > b.size()) std::swap(a, b);
  return b.starts_with(a)
         && (a.empty() || a.size() == b.size() || b[a.size()] == '.' || b[a.size()] == '[');
}

/// \return the warnings about objects that have errors, one per line: replaced values of a file may
/// be the cause of an error.
std::string related_warnings(const std::vector<Finding>& warnings,
                             const std::vector<Finding>& errors) {
  std::string lines;
  for (const Finding& warning : warnings) {
    const auto is_beside = [&](const Finding& error) {
      const std::string thing = error.path.substr(0, error.path.rfind('.'));
      return thing.size() < error.path.size() && related(thing, warning.path)
             && warning.path.size() > thing.size();
    };
    if (std::any_of(errors.begin(), errors.end(), is_beside))
      lines += fmt::format("warning: {}\n", warning.text());
  }
  return lines;
}

/// \param lines printed before the errors
[[noreturn]] void throw_all(std::vector<Finding> errors, std::string lines = "") {
  constexpr std::size_t most = 100;
  std::stable_sort(errors.begin(), errors.end(), [](const Finding& a, const Finding& b) {
    return std::pair(a.source->option, a.offset) < std::pair(b.source->option, b.offset);
  });
  for (std::size_t i = 0; i < std::min(most, errors.size()); ++i)
    lines += fmt::format("{}{}", i == 0 ? "" : "\n", errors[i].text());
  if (errors.size() > most) lines += fmt::format("\n... and {} more", errors.size() - most);
  const bool only_files = std::all_of(errors.begin(), errors.end(), [](const Finding& error) {
    return error.code == ExitCode::input_missing;
  });
  if (only_files
      && std::all_of(errors.begin(), errors.end(), [](const Finding& e) { return e.is_of_frame; }))
    throw UnreadableFrame(lines);
  // Errors of the scene have priority; then missing resources; then errors of files.
  ExitCode code = errors[0].code;
  for (const Finding& error : errors) {
    if (error.code == ExitCode::scene_invalid) throw Error(error.code, lines);
    code = std::max(code, error.code);
  }
  throw Error(code, lines);
}

/// If all fields are volumes of files, sets the box of the medium to the box of their voxels.
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

/// Refuses other versions, before errors of keys that they may define differently.
void refuse_other_versions(const Node& root) {
  const Node* version = root.value.is_object() ? child(root, "tyndall") : nullptr;
  if (!version || version->value == format_version) return;
  throw_all({{version->source, version->offset, "tyndall",
              fmt::format("this build reads scenes of version {}, got {}", format_version,
                          quote(*version))}});
}

/// A parsed scene with overrides.
struct Written {
  std::vector<Source> sources;
  Node root;  ///< points to `sources`
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
  const auto written = std::make_shared<const Written>(parse_scene(name, text, overrides, reader));
  const Node& root = written->root;
  Scene scene;
  read_thing(reader, root, scene, Keys<Scene>{}, &version());

  const Node* medium = child(root, "medium");
  if (medium && !child(*medium, "box")) enclose_volumes(scene.medium);

  Problems problems;
  ResolvedScene resolved(std::move(scene), problems);
  const auto finding = [written](const Problem& problem) {
    const Node& node = nearest_node(written->root, problem.path);
    return Finding{node.source, node.offset, problem.path, problem.message};
  };
  // A value that could not be read has its default, so errors of check() about it are ignored.
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
  if (!errors.empty()) {
    std::string before = related_warnings(reader.warnings, errors);
    throw_all(std::move(errors), std::move(before));
  }
  const auto warnings_of = [finding,
                            of_reading = std::move(reader.warnings)](const ResolvedScene& of) {
    std::vector<std::string> lines;
    for (const Finding& warning : of_reading) lines.push_back(warning.text());
    for (const Problem& warning : of.warnings) lines.push_back(finding(warning).text());
    return lines;
  };
  std::vector<LoadedVolume> volumes;
  for (auto& [known, volume] : reader.volumes) volumes.push_back(std::move(volume));
  std::vector<std::string> warnings = warnings_of(resolved);
  return {std::move(resolved), std::move(warnings), std::move(reader.inputs), std::move(volumes),
          warnings_of};
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
  read_thing(reader, written.root, scene, Keys<Scene>{}, &version());
  if (!reader.errors.empty()) throw_all(std::move(reader.errors));
  return std::move(reader.named);
}

std::string schema() {
  Json whole{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
             {"title", "Tyndall scene"}};
  whole.update(schema_of_object(Scene{}, Keys<Scene>{}, &version()));
  return whole.dump(2) + "\n";
}

std::string defaults() {
  return "// Every key of a scene at its default, with its meaning, its unit and its valid values. "
         "Required keys have no\n"
         "// default: their values are examples. Comments list alternative values.\n"
         + list_of_object(Scene{}, "", Keys<Scene>{}, &version()) + "\n";
}

}  // namespace tyndall::io
