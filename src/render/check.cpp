#include "tyndall/render/check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/cube_root.h"
#include "scene/prepare_phase.h"
#include "scene/scene.h"
#include "scene/values.h"
#include "tyndall/base/math.h"
#include "tyndall/medium/noise.h"
#include "tyndall/render/image.h"
#include "tyndall/render/volume.h"
#include "tyndall/transport/film.h"
#include "tyndall/transport/illumination.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {
namespace {

using namespace scene;

constexpr const char* axis_names = "xyz";

bool has_detectors(const scene::Detectors& d) {
  return d.flux[0] > 0 || d.path_length_bins > 0 || d.scattering_bins > 0 || d.exit_angle_bins > 0
         || d.absorbed[0] > 0;
}

glm::dvec3 magnitudes(const glm::dvec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

double largest_density(const scene::Remap& r, double low, double high) {
  const auto clamped = [&](double x) {
    return std::max(std::min(r.scale * x + r.offset, r.high), r.low);  // NaN stays
  };
  const auto most = static_cast<float>(std::max(clamped(low), clamped(high)));
  return r.gamma == 1 ? most : power(most, static_cast<float>(r.gamma));
}

/// Expects values in their ranges.
double largest_density(const Field& field) {
  if (const auto* grid = std::get_if<scene::DenseGrid>(&field); grid && !grid->values.empty()) {
    const auto ends = std::minmax_element(grid->values.begin(), grid->values.end());
    return largest_density(grid->remap, *ends.first, *ends.second);
  }
  if (const auto* grid = std::get_if<scene::SparseGrid>(&field); grid && grid->volume) {
    const Volume& v = *grid->volume;
    return v.is_level_set() ? 1.0 : largest_density(grid->remap, v.minimum(), v.maximum());
  }
  return 1.0;
}

double density_of(const scene::Remap& remap, float value) {
  return largest_density(remap, double{value}, double{value});
}

ValueCounts counts_of(const scene::DenseGrid& grid) {
  ValueCounts counts;
  for (const float v : grid.values) counts.add(v);
  return counts;
}
const ValueCounts& counts_of(const scene::SparseGrid& grid) { return grid.volume->counts(); }

/// Calls visit(density, voxels) for the voxels of a grid, those of about one value together.
template <class Grid, class Visit>
void for_densities(const Grid& grid, Visit&& visit) {
  counts_of(grid).for_each(
      [&](float value, std::uint64_t count) { visit(density_of(grid.remap, value), count); });
}

/// The density that half of a grid's extinction is at, or above: the densest voxel says nothing of
/// the rest.
template <class Grid>
double median_density(const Grid& grid) {
  std::vector<std::pair<double, double>> matter;  // density, extinction
  double total = 0;
  for_densities(grid, [&](double density, std::uint64_t count) {
    if (!(density > 0)) return;
    matter.emplace_back(density, density * static_cast<double>(count));
    total += matter.back().second;
  });
  std::sort(matter.begin(), matter.end(), std::greater<>());
  double sum = 0;
  for (const auto& [density, extinction] : matter) {
    sum += extinction;
    if (sum >= 0.5 * total) return density;
  }
  return 0;
}

/// Expects values in their ranges. \return the density where most of a field's extinction is.
double typical_density(const Field& field) {
  if (const auto* grid = std::get_if<scene::DenseGrid>(&field)) return median_density(*grid);
  const auto* grid = std::get_if<scene::SparseGrid>(&field);
  if (grid && grid->volume && !grid->volume->is_level_set()) return median_density(*grid);
  return 1;
}

/// Whether neither medium nor light changes along an axis: then cells may be of any width.
bool is_uniform(const Scene& scene, int axis) {
  const Medium& m = scene.medium;
  const auto spans = [&](const scene::Component& c, const Field& field) {
    const auto* solid = std::get_if<scene::Solid>(&field);
    if (!solid) return false;
    if (std::holds_alternative<Everywhere>(solid->body)) return true;
    const auto* body = std::get_if<Cuboid>(&solid->body);
    return body && c.transform == glm::dmat4(1.0) && body->min[axis] <= m.box_min[axis]
           && body->max[axis] >= m.box_max[axis];
  };
  const auto is_even = [&](const scene::Component& c) {
    return spans(c, c.field) && std::holds_alternative<NoEmission>(c.emission);
  };
  const auto is_far = [](const scene::Light& light) {
    return std::holds_alternative<scene::DirectionalLight>(light)
           || std::holds_alternative<scene::EnvironmentLight>(light);
  };
  return m.sides[static_cast<std::size_t>(axis)] == Side::periodic
         && std::all_of(m.components.begin(), m.components.end(), is_even)
         && std::all_of(scene.lights.begin(), scene.lights.end(), is_far);
}

double mean_cosine(const scene::Phase& phase) {
  std::vector<std::vector<PhaseKnot>> tables;
  return double{prepare_phase(phase, highest_order, 1, tables).moment(1)};
}

/// \return [length] of the illumination grid's cells, along the axes that anything varies along.
double cell_width(const Scene& scene) {
  const std::array<int, 3> cells = stored_illumination_resolution(scene);
  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  double width = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (!is_uniform(scene, axis))
      width = std::max(width, extent[axis] / cells[static_cast<std::size_t>(axis)]);
  return width;
}

constexpr double endless = std::numeric_limits<double>::infinity();

double ball(double radii) { return 4.0 / 3 * double{pi} * radii; }

double filled_volume(const scene::Solid& solid) {
  return std::visit(Overloaded{[](const Everywhere&) { return endless; },
                               [](const Sphere& b) { return ball(b.radius * b.radius * b.radius); },
                               [](const Cuboid& b) {
                                 const glm::dvec3 e = b.max - b.min;
                                 return e.x * e.y * e.z;
                               },
                               [](const Torus& b) {
                                 return 2 * double{pi} * double{pi} * b.ring_radius * b.tube_radius
                                        * b.tube_radius;
                               },
                               [](const Capsule& b) {
                                 return ball(b.radius * b.radius * b.radius)
                                        + double{pi} * b.radius * b.radius * glm::length(b.b - b.a);
                               }},
                    solid.body);
}
double filled_volume(const scene::NoiseCloud& cloud) {
  if (!(cloud.falloff > 0)) return endless;
  const double most =
      cloud.coverage + double{fractal_noise_bound(cloud.octaves, static_cast<float>(cloud.gain))};
  const double square = std::max(most / cloud.falloff, 0.0), cube = square * std::sqrt(square);
  if (const auto* b = std::get_if<Sphere>(&cloud.body))
    return cube * ball(b->radius * b->radius * b->radius);
  if (const auto* b = std::get_if<Ellipsoid>(&cloud.body))
    return cube * ball(b->radii.x * b->radii.y * b->radii.z);
  return endless;
}
template <class Grid>
double filled_voxels(const Grid& grid) {
  double voxels = 0;
  for_densities(grid, [&](double density, std::uint64_t count) {
    if (density > 0) voxels += static_cast<double>(count);
  });
  return voxels;
}
double filled_volume(const scene::DenseGrid& grid) {
  return filled_voxels(grid) / std::max(static_cast<double>(grid.values.size()), 1.0);
}
double filled_volume(const scene::SparseGrid& grid) {
  if (!grid.volume) return endless;
  const Volume& v = *grid.volume;
  const double voxel =
      std::abs(glm::determinant(glm::dmat3(fitted(grid)) * glm::dmat3(v.to_world())));
  if (v.is_level_set()) {  // what is inside is not active
    const glm::dvec3 extent = glm::dvec3(v.high() - v.low()) + 1.0;
    return voxel * extent.x * extent.y * extent.z;
  }
  if (density_of(grid.remap, v.background()) > 0) return endless;
  return voxel * filled_voxels(grid);
}

/// How much of space a component fills, or more.
double filled_volume(const scene::Component& c) {
  const double of_field = std::visit([](const auto& f) { return filled_volume(f); }, c.field);
  return of_field * std::abs(glm::determinant(glm::dmat3(c.transform)));
}

/// Lengths and angles are judged in double precision: what is parallel to 1e-6 is parallel.
constexpr double parallel = 1e-6;

/// [degree] across a sun's disc, in which single precision still resolves directions.
constexpr double least_sun_angle = 0.01;

/// Whether a key's path is `key`, or an element of it.
bool is_of(const std::string& path, const std::string& key) {
  return path.starts_with(key) && (path.size() == key.size() || path[key.size()] == '[');
}

/// Reports the numbers of a thing that are out of their ranges. Things within it are not visited.
template <class T>
class RangeChecker : public scene::Visitor<RangeChecker<T>> {
 public:
  /// \param path what keys are added to
  RangeChecker(const T& thing, std::string path, std::vector<Problem>& errors)
      : thing_(thing), path_(std::move(path)), errors_(errors) {}

  template <class M, class Form>
  void operator()(scene::Name name, M T::*member, const Form& form, const char*, const char*) {
    if constexpr (requires { form_of(form).range; })
      value(path_ + name.text, thing_.*member, form_of(form).range);
  }
  template <class M>
  void unwritten(M T::*) {}
  void part(const char* name, double T::*member, const Range& range) {
    value(path_ + name, thing_.*member, range);
  }
  void optional(scene::Name name, double T::*member, double, const Range& range, const char*,
                const char*) {
    if (thing_.*member != 0) value(path_ + name.text, thing_.*member, range);
  }
  template <class Describe>
  void group(const char* name, const char*, const Describe& keys) {
    RangeChecker inner(thing_, path_ + name + ".", errors_);
    keys(inner);
  }
  template <class E, class Describe>
  void when(E T::*kind, E value, const char*, const Describe& keys) {
    if (thing_.*kind == value) keys(*this);
  }
  template <class M>
  void faces(M T::*member, const scene::Numbers& form, const char*) {
    for (std::size_t face = 0; face < scene::face_names.size(); ++face)
      value(path_ + scene::face_names[face], (thing_.*member)[face], form.range);
  }

 private:
  template <class V>
  void value(const std::string& path, const V& v, const Range& range) {
    if constexpr (std::is_arithmetic_v<V>) {
      if (range.contains(static_cast<double>(v))) return;
      errors_.push_back({path, fmt::format("expected {}, got {}", describe(range), v), {}});
    } else if constexpr (requires { v.has_value(); }) {
      if (v) value(path, *v, range);
    } else if constexpr (requires { v.length(); }) {
      for (int i = 0; i < v.length(); ++i) value(fmt::format("{}[{}]", path, i), v[i], range);
    } else if constexpr (requires { std::tuple_size<V>::value; }) {
      for (std::size_t i = 0; i < v.size(); ++i) value(fmt::format("{}[{}]", path, i), v[i], range);
    }  // lists of any length are checked where they are read
  }

  const T& thing_;
  const std::string path_;
  std::vector<Problem>& errors_;
};

class Checker {
 public:
  explicit Checker(const Scene& scene) : scene_(scene) {}

  Problems run() {
    medium();
    for (std::size_t i = 0; i < scene_.lights.size(); ++i)
      light(fmt::format("lights[{}]", i), scene_.lights[i]);
    ranges("", scene_);
    something_shines();
    camera();
    work();
    detectors();
    return std::move(problems_);
  }

 private:
  void error(const std::string& path, const std::string& message) {
    problems_.errors.push_back({path, message, {}});
  }
  void warning(const std::string& path, const std::string& message) {
    problems_.warnings.push_back({path, message, {}});
  }

  template <class T>
  void ranges(const std::string& path, const T& thing) {
    RangeChecker<T> checker(thing, path.empty() ? "" : path + ".", problems_.errors);
    scene::visit_keys<T>(checker);
  }
  /// \return whether no error was found of the key at `path`: it may be used in further checks.
  bool is_good(const std::string& path) const {
    return std::none_of(problems_.errors.begin(), problems_.errors.end(),
                        [&](const Problem& error) { return is_of(error.path, path); });
  }
  void number(const std::string& path, double value, const Range& range) {
    if (!range.contains(value))
      error(path, fmt::format("expected {}, got {}", describe(range), value));
  }
  bool direction(const std::string& path, const glm::dvec3& value) {
    if (!is_good(path)) return false;
    if (glm::length(value) >= limits::size.low) return true;
    error(path, "a direction must have a length, got [0, 0, 0] or nearly so");
    return false;
  }

  bool open(int axis) const {
    return scene_.medium.sides[static_cast<unsigned>(axis)] == Side::open;
  }
  /// Whether light can enter and leave there.
  bool open_face(int face) const {
    return open(face / 2) && !scene_.medium.ground[static_cast<unsigned>(face)];
  }
  bool any_open() const {
    for (int face = 0; face < 6; ++face)
      if (open_face(face)) return true;
    return false;
  }

  // ---- The medium

  void medium() {
    const Medium& m = scene_.medium;
    ranges("medium", m);
    if (is_good("medium.box.min") && is_good("medium.box.max")) box();
    ground();
    if (m.components.empty()) {
      error("medium.components",
            "expected at least one component: a medium of nothing has nothing to show");
    } else if (m.components.size() > max_components) {
      error("medium.components", fmt::format("expected at most {} components, got {}",
                                             max_components, m.components.size()));
    }
    for (std::size_t i = 0; i < m.components.size(); ++i) {
      component(fmt::format("medium.components[{}]", i), m.components[i]);
    }
    if (!any_open() && !m.components.empty()) walks_end();
  }

  void box() {
    const glm::dvec3 low = scene_.medium.box_min, high = scene_.medium.box_max;
    for (int a = 0; a < 3; ++a) {
      const double extent = high[a] - low[a];
      if (extent <= 0) {
        error("medium.box", fmt::format("expected max above min, got {} from {} to {}",
                                        axis_names[a], low[a], high[a]));
      } else if (extent < thinnest() * std::max(std::abs(low[a]), std::abs(high[a]))
                 || extent < limits::size.low) {
        error("medium.box",
              fmt::format("too thin for single precision: {} from {} to {}; move it nearer to the "
                          "origin or make it thicker than {} of its distance from there{}",
                          axis_names[a], low[a], high[a], has_noise() ? "a thousandth" : "1e-8",
                          has_noise() ? " (noise is what it is at its place)" : ""));
      }
    }
  }

  /// Noise has its own origin, and single precision there; all else is brought to the box in
  /// double.
  bool has_noise() const {
    const auto is_noise = [](const Field& field) {
      return std::holds_alternative<scene::NoiseCloud>(field);
    };
    const std::vector<scene::Component>& all = scene_.medium.components;
    return std::any_of(all.begin(), all.end(), [&](const scene::Component& c) {
      const auto* color = std::get_if<ColorEmission>(&c.emission);
      const auto* body = std::get_if<BlackbodyEmission>(&c.emission);
      return is_noise(c.field) || (color && is_noise(color->field))
             || (body && is_noise(body->temperature));
    });
  }
  /// Of the box, along an axis, over its distance from the origin.
  double thinnest() const { return has_noise() ? nearest_far : 1e-8; }

  bool any_ground() const {
    const auto& grounds = scene_.medium.ground;
    return std::any_of(grounds.begin(), grounds.end(),
                       [](const auto& albedo) { return albedo.has_value(); });
  }

  void ground() {
    for (int face = 0; face < 6; ++face) {
      const auto f = static_cast<unsigned>(face);
      const std::optional<glm::dvec3>& albedo = scene_.medium.ground[f];
      if (!albedo) continue;
      const std::string path = fmt::format("medium.ground.{}", face_names[f]);
      if (!open(face / 2))
        error(path, fmt::format("this face is no end of the medium, which is periodic along {}: "
                                "expected \"open\" in medium.sides",
                                axis_names[face / 2]));
    }
  }

  /// Without open sides only absorption ends a walk: that of grounds, or of matter where there are
  /// none, since between white grounds without matter it would go on and on.
  void walks_end() {
    if (any_ground()) {
      const auto& grounds = scene_.medium.ground;
      if (std::none_of(grounds.begin(), grounds.end(),
                       [](const auto& albedo) { return albedo && largest(*albedo) < 1; }))
        error("medium.ground",
              "light never leaves: at least one ground needs an albedo below 1 in every channel, "
              "or a side must be open");
      return;
    }
    const auto absorbs = [](const scene::Component& c) {
      return c.extinction > 0 && largest(c.albedo) < 1;
    };
    const std::vector<scene::Component>& components = scene_.medium.components;
    if (std::none_of(components.begin(), components.end(), absorbs)) {
      error("medium.sides",
            "with three periodic sides light never leaves: at least one component needs an "
            "extinction above 0 and "
            "an albedo below 1 in every channel");
    }
  }

  void component(const std::string& path, const scene::Component& c) {
    const std::size_t errors = problems_.errors.size();
    ranges(path, c);
    if (is_good(path + ".extinction")) extinction(path, c);
    phase(path + ".phase", c.phase);
    transform(path + ".transform", c.transform);
    field(path + ".field", c, c.field);
    emission(path + ".emission", c);
    if (problems_.errors.size() == errors) size(path, c);
  }

  /// Matter of one unit in a box of another is a speck that few photons find. Of a volume its whole
  /// extent counts, however little of that is filled.
  void size(const std::string& path, const scene::Component& c) {
    const glm::dvec3 box = scene_.medium.box_max - scene_.medium.box_min;
    double space = filled_volume(c);
    if (const auto* grid = std::get_if<scene::SparseGrid>(&c.field);
        grid && grid->volume && space > 0 && space < endless) {
      const Volume& v = *grid->volume;
      const glm::dvec3 extent = glm::dvec3(v.high() - v.low()) + 1.0;
      space = extent.x * extent.y * extent.z
              * std::abs(glm::determinant(glm::dmat3(c.transform * fitted(*grid) * v.to_world())));
    }
    const double share = space / (box.x * box.y * box.z);
    constexpr double least = 1e-6;
    if (share > 0 && share < least)
      warning(
          path + ".transform",
          fmt::format("its matter has {:.1g} of the space in medium.box: was a scale forgotten? "
                      "Give the component a transform, or the box its size",
                      share));
  }

  void phase(const std::string& path, const scene::Phase& phase) {
    std::visit([&](const auto& p) { ranges(path, p); }, phase);
    if (const auto* tabulated = std::get_if<TabulatedPhase>(&phase)) {
      if (!tabulated->table) return error(path + ".file", "no table");
      const PhaseTableProblem problem = phase_table_problem(*tabulated->table);
      if (!problem.message.empty())
        return error(path + ".file", fmt::format("row {}: {}", problem.row, problem.message));
    }
    if (const Peak peak = narrowest_peak(phase); peak.fraction > 0.01)
      warning(path,
              fmt::format("a peak is as narrow as single precision resolves: {:.2g} % of the light "
                          "scatters into it, and pixels that see a light through it are wrong by a "
                          "factor of up to {:.3g}; take a g of at most 0.995, or a table with a "
                          "wider peak",
                          100 * peak.fraction, peak.factor));
  }

  struct Peak {
    double fraction = 0;  ///< of the light that scatters into it
    double factor = 1;    ///< between densities within it
  };
  /// The interval of cosines, as wide as their rounding errors, into which most light scatters.
  static Peak narrowest_peak(const scene::Phase& phase) {
    constexpr double cosine_error = 1.8e-7;  // 2^-22.4
    const auto of_lobe = [](double g, double weight) {
      const double a = std::abs(g), square = (1 - a) * (1 - a);
      const double ratio = 1 + 2 * a * cosine_error / square;
      return Peak{weight * 0.5 * (1 - a * a) / (square * (1 - a)) * cosine_error,
                  ratio * std::sqrt(ratio)};
    };
    if (const auto* hg = std::get_if<HenyeyGreensteinPhase>(&phase)) return of_lobe(hg->g, 1);
    if (const auto* lobes = std::get_if<TwoLobesPhase>(&phase)) {
      const Peak first = of_lobe(lobes->g1, lobes->weight),
                 second = of_lobe(lobes->g2, 1 - lobes->weight);
      return first.fraction > second.fraction ? first : second;
    }
    const auto* tabulated = std::get_if<TabulatedPhase>(&phase);
    if (!tabulated) return {};
    const std::vector<double>&x = tabulated->table->cosines, &y = tabulated->table->values;
    double total = 0;
    for (std::size_t i = 1; i < x.size(); ++i) total += 0.5 * (y[i - 1] + y[i]) * (x[i] - x[i - 1]);
    // Both from its low and from its high end, since its ends are those of segments.
    Peak narrowest;
    const auto consider = [&](double low, double high) {
      double sum = 0, least = std::numeric_limits<double>::infinity(), most = 0;
      for (std::size_t i = static_cast<std::size_t>(
               std::max<std::ptrdiff_t>(std::upper_bound(x.begin(), x.end(), low) - x.begin(), 1));
           i < x.size() && x[i - 1] < high; ++i) {
        const double a = std::max(low, x[i - 1]), b = std::min(high, x[i]);
        const auto at = [&](double c) {
          return std::lerp(y[i - 1], y[i], (c - x[i - 1]) / (x[i] - x[i - 1]));
        };
        sum += 0.5 * (at(a) + at(b)) * (b - a);
        least = std::min({least, at(a), at(b)}), most = std::max({most, at(a), at(b)});
      }
      if (sum > narrowest.fraction * total)
        narrowest = {sum / total, most / std::max(least, 1e-30)};
    };
    for (const double end : x) consider(end - cosine_error, end), consider(end, end + cosine_error);
    return narrowest;
  }

  void field(const std::string& path, const scene::Component& c, const Field& of) {
    std::visit(Overloaded{[&](const scene::Solid& solid) { body(path, solid.body); },
                          [&](const scene::NoiseCloud& cloud) { noise(path, cloud); },
                          [&](const scene::DenseGrid& grid) { dense_grid(path, grid); },
                          [&](const scene::SparseGrid&) { sparse_grid(path, c, of); }},
               of);
  }

  void emission(const std::string& path, const scene::Component& c) {
    if (std::holds_alternative<NoEmission>(c.emission)) return;
    std::visit([&](const auto& e) { ranges(path, e); }, c.emission);
    if (const auto* color = std::get_if<ColorEmission>(&c.emission)) {
      if (is_good(path + ".radiance") && largest(color->radiance) == 0)
        warning(path, "this emission is black");
      field(path + ".field", c, color->field);
    }
    if (const auto* body = std::get_if<BlackbodyEmission>(&c.emission))
      field(path + ".temperature", c, body->temperature);
    if (std::min({c.albedo.x, c.albedo.y, c.albedo.z}) >= 1)
      error(path,
            "matter emits as it absorbs, and with albedo 1 it absorbs nothing: give the component "
            "an albedo below 1");
  }

  /// Where the mean free path nears what positions resolve, flights would stand still.
  void extinction(const std::string& path, const scene::Component& c) {
    if (c.extinction == 0)
      warning(path + ".extinction", "with extinction 0 this component does nothing");
    const double densest = largest_density(c.field);
    const auto* grid = std::get_if<scene::SparseGrid>(&c.field);
    const bool is_empty = grid && grid->volume && grid->volume->active_voxels() == 0;  // as is said
    if (densest == 0 && !is_empty)
      warning(path + ".field", "its density is 0 everywhere: this component does nothing");
    const double across = glm::length(scene_.medium.box_max - scene_.medium.box_min);
    constexpr double most = 2e6;
    if (c.extinction * densest * across > most) {
      error(
          path + ".extinction",
          fmt::format("too dense for single precision: {:.3g} mean free paths across the medium{}, "
                      "expected at most {:g}; an extinction of {:.3g} is opaque, too",
                      c.extinction * densest * across,
                      densest == 1 ? "" : fmt::format(", where the density is {:.3g}", densest),
                      most, most / (densest * across)));
    }
    crawling(path, c);
  }

  /// In a super-voxel that a surface passes through the bound is that of the inside: who crosses it
  /// outside has as many tentative collisions as if it were full.
  void crawling(const std::string& path, const scene::Component& c) {
    const auto* solid = std::get_if<scene::Solid>(&c.field);
    if (solid && std::holds_alternative<Everywhere>(solid->body)) return;
    const glm::dvec3 extent = scene_.medium.box_max - scene_.medium.box_min;
    double crossings =
        0;  // [1/length] of super-voxels, where no more are said as many as there may be
    for (int a = 0; a < 3; ++a) {
      const int n = scene_.medium.majorant_resolution[static_cast<std::size_t>(a)];
      crossings += 0.5 * (n > 0 ? n : 64) / extent[a];
    }
    constexpr double many = 100;
    const double collisions = c.extinction * typical_density(c.field) / crossings;
    if (!(collisions > many)) return;
    warning(
        path + ".extinction",
        fmt::format("photons crawl: they need {:.3g} tentative collisions to pass a super-voxel "
                    "at its surface; an extinction of {:.2g} is opaque, too, or raise "
                    "medium.majorants.resolution",
                    collisions, c.extinction * many / collisions));
  }

  void transform(const std::string& path, const glm::dmat4& m) {
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        const double x = m[column][row];
        if (!limits::factor.contains(x)) {
          return error(path, fmt::format("expected matrix elements in [{}, {}], got {}",
                                         limits::factor.low, limits::factor.high, x));
        }
      }
    }
    if (!affine(path, m)) return;
    double lengths = 1;
    for (int column = 0; column < 3; ++column) {
      const double length = glm::length(glm::dvec3(m[column]));
      if (length < limits::size.low) {
        return error(
            path, fmt::format("singular: it shrinks {} to nothing; expected a scale of at least {}",
                              axis_names[column], limits::size.low));
      }
      lengths *= length;
    }
    if (std::abs(glm::determinant(glm::dmat3(m))) < parallel * lengths) {
      error(path, "singular: it flattens space, and cannot be inverted");
    }
  }

  bool affine(const std::string& path, const glm::dmat4& m) {
    if (m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1) return true;
    error(path, fmt::format("expected an affine matrix, with last row 0 0 0 1, got {} {} {} {}",
                            m[0][3], m[1][3], m[2][3], m[3][3]));
    return false;
  }

  // ---- Its fields

  template <class Body>
  void body(const std::string& path, const Body& shape) {
    std::visit(
        [&](const auto& s) {
          ranges(path, s);
          this->shape(path, s);
        },
        shape);
  }
  template <class Shape>
  void shape(const std::string&, const Shape&) {}
  void shape(const std::string& path, const Cuboid& s) {
    if (!is_good(path + ".min") || !is_good(path + ".max")) return;
    for (int a = 0; a < 3; ++a) {
      if (s.max[a] <= s.min[a]) {
        error(path + ".max", fmt::format("expected max above min, got {} from {} to {}",
                                         axis_names[a], s.min[a], s.max[a]));
      }
    }
  }

  void noise(const std::string& path, const scene::NoiseCloud& cloud) {
    ranges(path, cloud);
    body(path + ".body", cloud.body);
  }

  void dense_grid(const std::string& path, const scene::DenseGrid& grid) {
    ranges(path, grid);
    remap(path + ".remap", grid.remap);
    if (!is_good(path + ".size")) return;
    if (const std::string problem = grid_problem(grid); !problem.empty())
      error(path + ".values", problem);
  }

  void sparse_grid(const std::string& path, const scene::Component& c, const Field& of) {
    const auto& grid = std::get<scene::SparseGrid>(of);
    remap(path + ".remap", grid.remap);
    if (!grid.volume) return error(path, "no volume");
    const Volume& volume = *grid.volume;
    if (volume.is_color()) {
      const auto* color = std::get_if<ColorEmission>(&c.emission);
      if (color && &color->field == &of) return;
      return error(path, "a grid of colours is neither a density nor a temperature");
    }
    if (volume.active_voxels() == 0 || &of != &c.field) return;
    const ActiveBounds box = active_box(volume, c.transform * fitted(grid) * volume.to_world());
    for (int a = 0; a < 3; ++a) {
      if (box.high[a] > scene_.medium.box_min[a] && box.low[a] < scene_.medium.box_max[a]) continue;
      return warning(
          path, fmt::format("outside of medium.box: its voxels are in [{:.6g}, {:.6g}, {:.6g}] "
                            "to [{:.6g}, {:.6g}, {:.6g}]; move it, or the box",
                            box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z));
    }
    const double slack = 1e-6 * glm::length(box.high - box.low);
    for (int a = 0; grid.fit_box && a < 3; ++a) {
      if (box.high[a] <= scene_.medium.box_max[a] + slack
          && box.low[a] >= scene_.medium.box_min[a] - slack)
        continue;
      return warning(
          path,
          "fitted as another frame is, it reaches beyond medium.box, which cuts it: leave "
          "the box out, make it larger, or scale by the component's transform");
    }
  }

  void remap(const std::string& path, const scene::Remap& r) {
    ranges(path, r);
    if (is_good(path + ".clamp") && r.low > r.high)
      error(path + ".clamp", fmt::format("expected low, high, got {} above {}", r.low, r.high));
  }

  // ---- Lights

  void light(const std::string& path, const Light& light) {
    std::visit(
        [&](const auto& l) {
          ranges(path, l);
          this->light(path, l);
          group(path + ".group", l.group);
        },
        light);
  }

  /// It is the name of a layer of EXR files, where dots mean something.
  void group(const std::string& path, const std::string& name) {
    const auto is_good = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'
             || c == '-';
    };
    if (name.size() > 24 || !std::all_of(name.begin(), name.end(), is_good))
      error(path, fmt::format("expected up to 24 letters, digits, '_' and '-', got \"{}\"", name));
    for (const char* taken : {"others", "emission", "background"})
      if (name == taken) error(path, fmt::format("\"{}\" is the layer of what no group has", name));
  }

  void emission(const std::string& path, const glm::dvec3& amount) {
    if (is_good(path) && largest(amount) == 0) warning(path, "this light is black");
  }

  void light(const std::string& path, const PointLight& l) {
    emission(path + ".power", l.power);
    if (is_good(path + ".position")) place(path, "position", "point", l.position, glm::dvec3(0));
  }

  void light(const std::string& path, const SpotLight& l) {
    emission(path + ".intensity", l.intensity);
    direction(path + ".direction", l.direction);
    if (is_good(path + ".position")) place(path, "position", "spot", l.position, glm::dvec3(0));
  }

  void light(const std::string& path, const RectangleLight& l) {
    emission(path + ".radiance", l.radiance);
    if (!direction(path + ".edge_u", l.edge_u) || !direction(path + ".edge_v", l.edge_v)) return;
    const double lengths = glm::length(l.edge_u) * glm::length(l.edge_v);
    if (glm::length(glm::cross(l.edge_u, l.edge_v)) < 1e-3 * lengths)
      return error(path + ".edge_v", "parallel to edge_u: they must span an area");
    if (is_good(path + ".center"))
      place(path, "center", "rectangle", l.center,
            0.5 * (magnitudes(l.edge_u) + magnitudes(l.edge_v)));
  }

  void light(const std::string& path, const SphereLight& l) {
    emission(path + ".radiance", l.radiance);
    if (is_good(path + ".center") && is_good(path + ".radius"))
      place(path, "center", "sphere", l.center, glm::dvec3(l.radius));
  }

  /// \param half of the box about the light
  void place(const std::string& path, const char* key, const char* kind, const glm::dvec3& center,
             const glm::dvec3& half) {
    if (!(open(0) && open(1) && open(2))
        && (scene_.integrator == Integrator::path || scene_.bounces != 0 || any_ground()))
      error(path, fmt::format("between periodic sides a {} light has images without end, which the "
                              "camera's paths cannot ask one by one: expected the integrator "
                              "\"photons\" without bounces (gather.bounces 0), and no ground",
                              kind));
    if (!(open(0) && open(1) && open(2))) truncated(path, kind);
    bool inside = true, enters = false;
    for (int a = 0; a < 3; ++a) {
      const bool below =
          center[a]
          + half[a]<scene_.medium.box_min[a], above = center[a] - half[a]> scene_.medium.box_max[a];
      inside = inside && !below && !above;
      enters = enters || (below && open_face(2 * a)) || (above && open_face(2 * a + 1));
    }
    if (!inside && !enters) {
      error(path + "." + key,
            "outside the medium, and every side that faces it is periodic or a ground: its light "
            "cannot enter; move it inside or open a side");
    }
  }

  /// The illumination grid holds the light of this one from the first collision on.
  void truncated(const std::string& path, const char* kind) {
    double missing = 1;
    for (const Component& c : scene_.medium.components) {
      const auto* tabulated = std::get_if<TabulatedPhase>(&c.phase);
      if (largest(c.albedo) == 0) continue;
      if (tabulated
          && (!tabulated->table || !phase_table_problem(*tabulated->table).message.empty()))
        continue;
      std::vector<std::vector<PhaseKnot>> tables;
      const tyndall::Phase phase = prepare_phase(c.phase, highest_order, 1, tables);
      const double series =
          double{phase.moment(0)} + 3 * double{phase.moment(1)} + 5 * double{phase.moment(2)};
      if (phase.is_split)
        missing = std::max(missing, 4 * double{pi} * double{phase.evaluate(1.0f)} / series);
    }
    if (missing > 1.1)
      warning(path, fmt::format("between periodic sides the light of a {} is read from the "
                                "illumination grid alone, whose harmonics end at order 2: seen "
                                "towards it, light scattered once is up to {:.3g} times too dark. "
                                "Open the sides, or use a sun or an environment",
                                kind, missing));
  }

  void light(const std::string& path, const DirectionalLight& l) {
    emission(path + ".irradiance", l.irradiance);
    if (is_good(path + ".angle") && l.angle > 0 && l.angle < least_sun_angle)
      error(path + ".angle", fmt::format("expected 0, for parallel light, or at least {}, got {}",
                                         least_sun_angle, l.angle));
    if (!direction(path + ".direction", l.direction)) return;
    if (l.angle > 0 && any_open()) return;
    const glm::dvec3 way = glm::normalize(l.direction);
    for (int a = 0; a < 3; ++a) {
      if (std::abs(way[a]) > parallel && open_face(2 * a + (way[a] < 0 ? 1 : 0))) return;
    }
    error(path + ".direction",
          "it meets no open side of the medium: its light cannot enter; turn it or open a side");
  }

  void light(const std::string& path, const EnvironmentLight& l) {
    if (!l.image) emission(path + ".radiance", l.radiance);
    if (l.scale == 0) warning(path + ".scale", "this light is black");
    if (l.image && l.image->largest() == 0) warning(path + ".image", "this light is black");
    if (!any_open()) error(path, "an environment shines in through open sides, and there are none");
  }

  void something_shines() {
    const glm::dvec3& background = scene_.background;
    const auto shines = [](const Light& light) {
      return std::visit(
          Overloaded{[](const PointLight& l) { return largest(l.power) > 0; },
                     [](const DirectionalLight& l) { return largest(l.irradiance) > 0; },
                     [](const EnvironmentLight& l) {
                       return l.scale > 0
                              && (l.image ? l.image->largest() > 0 : largest(l.radiance) > 0);
                     },
                     [](const SpotLight& l) { return largest(l.intensity) > 0; },
                     [](const auto& l) { return largest(l.radiance) > 0; }},
          light);
    };
    if (std::any_of(scene_.lights.begin(), scene_.lights.end(), shines)) return;
    const std::vector<scene::Component>& components = scene_.medium.components;
    if (std::any_of(components.begin(), components.end(), [](const scene::Component& c) {
          return !std::holds_alternative<NoEmission>(c.emission);
        }))
      return;
    if (largest(background) > 0) {
      warning("lights", "no light shines: only the background will be seen");
    } else {
      Problem dark{"lights",
                   "nothing shines, neither a light nor the background: the picture would be black",
                   {"background"}};
      for (std::size_t i = 0; i < components.size(); ++i)
        dark.depends_on.push_back(fmt::format("medium.components[{}].emission", i));
      problems_.errors.push_back(std::move(dark));
    }
  }

  // ---- The camera

  void camera() {
    const scene::Camera& c = scene_.camera;
    ranges("camera", c);
    if (c.projection == Projection::perspective) lens(c);
    if (is_good("camera.resolution")) crop(c);
    if (c.matrix) return camera_matrix(*c.matrix);
    const bool upright = direction("camera.up", c.up);
    if (!is_good("camera.position") || !is_good("camera.look_at")) return;
    const glm::dvec3 view = c.look_at - c.position;
    if (glm::length(view) < limits::size.low) {
      return error("camera.look_at",
                   fmt::format("equal to the position [{}, {}, {}]: no direction to look in",
                               c.position.x, c.position.y, c.position.z));
    }
    if (upright && glm::length(glm::cross(glm::normalize(view), glm::normalize(c.up))) < parallel) {
      error("camera.up",
            "parallel to the view: no side of the picture is up; choose another direction");
    }
  }

  void lens(const scene::Camera& c) {
    if (is_good("camera.focus_distance") && c.focus_distance > 0)
      number("camera.focus_distance", c.focus_distance, limits::size);
    if (c.focus_distance == 0 && c.aperture_radius > 0 && c.matrix)
      error("camera.focus_distance",
            "an open lens needs one: with a matrix there is no look_at to focus on");
  }

  void crop(const scene::Camera& c) {
    if (c.crop == std::array{0, 0, 0, 0}) return;  // the whole picture
    for (unsigned a = 0; a < 2; ++a) {
      const int low = c.crop[a], high = c.crop[a + 2], end = c.resolution[a];
      if (0 <= low && low < high && high <= end) continue;
      error("camera.crop", fmt::format("expected 0 <= {0}0 < {0}1 <= {1}, got {2} and {3}",
                                       axis_names[a], end, low, high));
    }
  }

  void camera_matrix(const glm::dmat4& m) {
    const std::string path = "camera.matrix";
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        const std::string element = fmt::format("{}[{}]", path, 4 * row + column);
        number(element, m[column][row], limits::coordinate);
        if (!is_good(element)) return;
      }
    }
    if (!affine(path, m)) return;
    constexpr double tolerance = 1e-4;
    for (int i = 0; i < 3; ++i) {
      const double length = glm::length(glm::dvec3(m[i]));
      if (std::abs(length - 1) > tolerance) {
        return error(path, fmt::format("scaled: expected columns of length 1, got {:.6g} in {}; a "
                                       "camera has no size",
                                       length, axis_names[i]));
      }
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const double cosine = glm::dot(glm::dvec3(m[i]), glm::dvec3(m[j]));
      if (std::abs(cosine) > tolerance) {
        return error(path, fmt::format("sheared: expected perpendicular columns, {} and {} have a "
                                       "dot product of {:.6g}",
                                       axis_names[i], axis_names[j], cosine));
      }
    }
    if (glm::determinant(glm::dmat3(m)) <= 0)
      error(path, "mirrored: its determinant is below 0; turn one axis round");
  }

  // ---- Work and detectors

  /// What the light of cells of several mean free paths is worth.
  /// \return how much too bright a thick slab is at the sun's zenith, relatively, at least. \param
  /// width of cells [transport mean free path]
  static double expected_error(double width, int bounces) {
    // Measured, in percent: tyndall-bias --slabs --depths 25,50,100,200,400 --g 0 --bounces 0,1,2,3
    constexpr std::array widths{0.0, 0.39, 0.78, 1.56, 1.75, 3.12};
    constexpr double errors[4][widths.size()] = {{0, 0.6, 2.1, 6.2, 7.3, 13.8},
                                                 {0, 0.0, 0.5, 2.2, 2.7, 6.9},
                                                 {0, 0.0, 0.0, 0.6, 0.8, 3.6},
                                                 {0, 0.0, 0.0, 0.0, 0.1, 2.0}};
    const double* const row = errors[std::clamp(bounces, 0, 3)];
    std::size_t i = 1;
    while (i + 1 < widths.size() && width > widths[i]) ++i;
    const double t = (width - widths[i - 1]) / (widths[i] - widths[i - 1]);
    return 0.01 * std::lerp(row[i - 1], row[i], std::min(t, 1.0));
  }

  void coarse_cells() {
    if (scene_.integrator == scene::Integrator::path || !problems_.errors.empty()) return;
    const double width = cell_width(scene_);
    const int bounces = gather_bounces(scene_);
    for (std::size_t i = 0; i < scene_.medium.components.size(); ++i) {
      const scene::Component& c = scene_.medium.components[i];
      if (!(largest(c.albedo) > 0)) continue;
      const double paths = width * c.extinction * typical_density(c.field);
      const double error = expected_error(paths * (1 - mean_cosine(c.phase)), bounces);
      constexpr double many = 4;  // of which the dark side of a slab is half as bright again
      const bool is_dark_side_wrong = paths > many * (1 + scene_.bounces.value_or(1));
      if (error < 0.03 && !is_dark_side_wrong) continue;
      warning("photons.illumination.resolution",
              fmt::format("cells are {:.3g} mean free paths of medium.components[{}] wide: with {} "
                          "bounces its bright sides are expected to be {:.2g} % too bright{}; "
                          "raise it, or gather.bounces",
                          paths, i, bounces, 100 * error,
                          is_dark_side_wrong ? " or more, dark sides up to half" : ""));
      return;
    }
  }

  void work() {
    coarse_cells();
    if (is_good("marching_step") && scene_.marching_step > 0) marching();
  }

  void marching() {
    if (scene_.sampler != Sampler::ray_marching) {
      return warning("marching_step", "only the sampler ray_marching takes steps: not used");
    }
    const double across = glm::length(scene_.medium.box_max - scene_.medium.box_min);
    if (across / scene_.marching_step > most_steps) {
      error("marching_step",
            fmt::format("expected at least {} (2^22 steps across the medium), got {}",
                        across / most_steps, scene_.marching_step));
    }
  }

  void detectors() {
    const scene::Detectors& d = scene_.detectors;
    ranges("detectors", d);
    if (is_good("detectors.flux")) all_or_none("detectors.flux", d.flux);
    if (is_good("detectors.path_length.max") && d.path_length_bins > 0)
      number("detectors.path_length.max", d.path_length_max, limits::size);
    if (is_good("detectors.absorbed")) all_or_none("detectors.absorbed", d.absorbed);
    if (has_detectors(d) && scene_.integrator == Integrator::path)
      warning("detectors", "not used: they count photons, and the integrator path shoots none");
  }

  template <class Sizes>
  void all_or_none(const std::string& path, const Sizes& sizes) {
    const auto zeros = std::count(sizes.begin(), sizes.end(), 0);
    if (zeros != 0 && zeros != std::ssize(sizes))
      error(path,
            fmt::format("expected sizes above 0, or 0 for all, got [{}]", fmt::join(sizes, ", ")));
  }

  const Scene& scene_;
  Problems problems_;
};

template <class Sizes>
std::uint64_t product(const Sizes& sizes) {
  std::uint64_t cells = 1;
  for (const int n : sizes) cells *= static_cast<std::uint64_t>(std::max(n, 0));
  return cells;
}

}  // namespace

// ---- What is asked of a scene

Problems check(const Scene& scene) { return Checker(scene).run(); }

std::string grid_problem(const scene::DenseGrid& grid) {
  const std::uint64_t voxels = product(grid.size);
  if (grid.values.size() != voxels) {
    return fmt::format("expected {} x {} x {} = {} values, got {}", grid.size[0], grid.size[1],
                       grid.size[2], voxels, grid.values.size());
  }
  const auto bad = [](float v) { return !limits::density.contains(v); };
  const auto first = std::find_if(grid.values.begin(), grid.values.end(), bad);
  if (first == grid.values.end()) return {};
  return fmt::format(
      "expected densities in [0, 1e12], got {} others of {}, the first {} at index {}",
      std::count_if(first, grid.values.end(), bad), voxels, *first, first - grid.values.begin());
}

PhaseTableProblem phase_table_problem(const scene::PhaseTable& table) {
  const std::vector<double>&cosines = table.cosines, &values = table.values;
  const std::size_t rows = cosines.size();
  if (rows != values.size() || !limits::phase_rows.contains(static_cast<double>(rows))) {
    return {rows > 0 ? rows - 1 : 0,
            fmt::format("expected {:g} to {:g} rows, got {}", limits::phase_rows.low,
                        limits::phase_rows.high, std::min(rows, values.size()))};
  }
  for (std::size_t i = 0; i < rows; ++i) {
    if (!limits::phase_value.contains(values[i]))
      return {i, fmt::format("expected a value in [0, 1e30], got {}", values[i])};
    if (i == 0 && cosines[i] != -1)
      return {i, fmt::format("expected to begin with cosine -1, got {}", cosines[i])};
    if (i > 0 && !(cosines[i] > cosines[i - 1]))
      return {i, fmt::format("expected ascending cosines, got {} after {}", cosines[i],
                             cosines[i - 1])};
  }
  if (cosines.back() != 1)
    return {rows - 1, fmt::format("expected to end with cosine 1, got {}", cosines.back())};
  if (*std::max_element(values.begin(), values.end()) <= 0)
    return {rows - 1, "expected a value above 0, all are 0"};
  return {};
}

bool detects(const Scene& scene) {
  return scene.integrator == Integrator::photons && has_detectors(scene.detectors);
}

int needed_illumination_order(const Scene& scene) {
  int order = 0;
  for (const scene::Component& c : scene.medium.components) {
    if (largest(c.albedo) == 0) continue;
    const auto* hg = std::get_if<HenyeyGreensteinPhase>(&c.phase);
    if (hg && hg->g != 0) order = std::max(order, 1);
    if (!hg && !std::holds_alternative<IsotropicPhase>(c.phase)) order = 2;
  }
  return order;
}

int stored_illumination_order(const Scene& scene) {
  if (scene.illumination_order >= 0) return scene.illumination_order;
  return needed_illumination_order(scene) > 0 ? highest_order : 0;
}

int gather_bounces(const Scene& scene) {
  if (scene.bounces) return *scene.bounces;
  const double width = cell_width(scene);
  double widest = 0;  // [transport mean free path]
  for (const scene::Component& c : scene.medium.components) {
    if (!(largest(c.albedo) > 0)) continue;
    widest = std::max(widest,
                      width * c.extinction * typical_density(c.field) * (1 - mean_cosine(c.phase)));
  }
  return widest <= 0.9 ? 1 : widest <= 1.25 ? 2 : 3;
}

std::array<int, 3> dense_illumination_resolution(const Scene& scene) {
  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  const double longest = std::max({extent.x, extent.y, extent.z});
  double densest = 0;  // of one component: where several overlap, little of it is as dense as all
  for (const scene::Component& c : scene.medium.components)
    if (largest(c.albedo) > 0)
      densest = std::max(densest, c.extinction * double{largest_density(c.field)});
  const double along = std::clamp(std::ceil(longest * densest / cells_in_free_paths), 64.0, 128.0);
  std::array<int, 3> cells = scene.illumination_resolution;
  for (int axis = 0; axis < 3; ++axis) {
    int& n = cells[static_cast<std::size_t>(axis)];
    if (n == 0) n = static_cast<int>(std::max(1.0, std::ceil(along * extent[axis] / longest)));
  }
  return cells;
}

IlluminationPlan plan_illumination(const Scene& scene) {
  IlluminationPlan plan;
  plan.cells = dense_illumination_resolution(scene);
  plan.stored = product(plan.cells);
  const auto is_given = [](int n) { return n > 0; };
  const std::array<int, 3>& given = scene.illumination_resolution;
  if (std::any_of(given.begin(), given.end(), is_given)) return plan;

  const glm::dvec3 extent = scene.medium.box_max - scene.medium.box_min;
  double thickest = 0, filled = 0, widest = 0;
  for (const scene::Component& c : scene.medium.components) {
    if (largest(c.albedo) > 0)
      thickest = std::max(thickest, c.extinction * typical_density(c.field));
    filled += filled_volume(c);
  }
  for (int axis = 0; axis < 3; ++axis)
    widest = std::max(widest, extent[axis] / plan.cells[static_cast<std::size_t>(axis)]);
  const double box = extent.x * extent.y * extent.z;
  if (!(thickest > 0) || !(filled > 0) || !(8 * filled < box)) return plan;
  const double finest = cube_root(filled) / 128, coarsest = 2 * finest;
  const double wanted = std::max(cells_in_free_paths / thickest, finest),
               width = std::min(wanted, coarsest);
  const bool is_coarse = 2 * wanted < widest, is_lost = 64 * filled < box && 2 * width < widest;
  if (!is_coarse && !is_lost) return plan;

  // Bricks at the rim of the matter are not full. And single precision resolves no more cells.
  constexpr double finest_share = 1 << 20, rim = 8;
  for (int axis = 0; axis < 3; ++axis)
    plan.cells[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::clamp(std::ceil(extent[axis] / width), 1.0, finest_share));
  plan.is_sparse = true;
  plan.stored = static_cast<std::uint64_t>(
      std::min(rim * filled / (width * width * width), static_cast<double>(most_stored_cells)));
  return plan;
}

std::array<int, 3> stored_illumination_resolution(const Scene& scene) {
  return plan_illumination(scene).cells;
}

std::uint64_t memory_needed(const Scene& scene) {
  // A pixel: integer tallies of a replicate and of all, what their spread takes, and 20 floats.
  const std::array<int, 4>& crop = scene.camera.crop;
  const std::uint64_t pixels = crop[2] == 0
                                   ? product(scene.camera.resolution)
                                   : product(std::array{crop[2] - crop[0], crop[3] - crop[1]});
  const std::uint64_t film = pixels * (2 * sizeof(PixelTally) + 48 + 80);

  // A cell: RGB coefficients and the matter as 64-bit integers, of this replicate and of the next,
  // and the same once more as floats.
  const int order = stored_illumination_order(scene);
  const auto numbers = static_cast<std::uint64_t>(3 * (order + 1) * (order + 1) + 1);
  const std::uint64_t illumination = plan_illumination(scene).stored * numbers * (2 * 8 + 4);

  // A super-voxel: two bounds of each component. A grid: its values here and as the walks read
  // them.
  const Medium& medium = scene.medium;
  std::array<int, 3> super_voxels = medium.majorant_resolution;
  for (int& n : super_voxels) n = n == 0 ? 64 : n;  // where they are chosen, no more
  std::uint64_t media = product(super_voxels) * medium.components.size() * 8;
  for (const scene::Component& c : medium.components) {
    if (const auto* grid = std::get_if<scene::DenseGrid>(&c.field))
      media += 2 * 4 * grid->values.size();
    if (std::get_if<scene::NoiseCloud>(&c.field)) media += 2u << 20;  // its table
  }
  for (const Light& light : scene.lights) {  // an image's texels, and the table of their weights
    const auto* sky = std::get_if<EnvironmentLight>(&light);
    if (sky && sky->image) media += (12 + 4) * sky->image->texels().size();
  }

  // Bins: RGB, here and in the text they become.
  const scene::Detectors& d = scene.detectors;
  const std::uint64_t bins =
      6 * product(d.flux) + product(d.absorbed) + product(std::array{d.path_length_bins})
      + product(std::array{d.scattering_bins}) + product(std::array{d.exit_angle_bins});
  return film + illumination + media + bins * 3 * (2 * 8 + 24);
}

std::string describe(const Range& range) {
  const auto brief = [](double x) {  // 1e+09, not 1000000000
    std::string text = fmt::format("{:g}", x);
    return std::strtod(text.c_str(), nullptr) == x ? text : fmt::format("{}", x);
  };
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  if (!low && !high) return range.what;
  if (!high)
    return fmt::format("{}, {} {}", range.what, range.open ? "above" : "at least",
                       brief(range.low));
  return fmt::format("{} in {}{}, {}{}", range.what, range.open ? '(' : '[', brief(range.low),
                     brief(range.high), range.open ? ')' : ']');
}

}  // namespace tyndall
