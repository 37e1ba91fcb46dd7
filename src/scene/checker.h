/// \file
/// Shared parts of the checks of a scene. The source file of each thing checks it across its keys;
/// the description of the keys defines the ranges of numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "scene/describe.h"
#include "scene/values.h"
#include "tyndall/render/check.h"
#include "tyndall/render/resolved_scene.h"
#include "tyndall/scene/scene.h"

namespace tyndall::scene {

inline constexpr const char* axis_names = "xyz";

/// Lengths and angles are compared in double precision; directions count as parallel within 1e-6.
inline constexpr double parallel_sine = 1e-6;

/// Reports the numbers of a thing that are out of range. It does not visit nested things.
template <class T>
class RangeChecker : public Visitor<RangeChecker<T>> {
 public:
  /// \param path prefix of the keys
  RangeChecker(const T& thing, std::string path, std::vector<Problem>& errors)
      : thing_(thing), path_(std::move(path)), errors_(errors) {}

  template <class M, class Form>
  void operator()(Name name, M T::*member, const Form& form, const char*, const char*) {
    if constexpr (requires { form_of(form).range; })
      value(path_ + name.text, thing_.*member, form_of(form).range);
  }
  template <class M>
  void unwritten(M T::*) {}
  void part(const char* name, double T::*member, const Range& range) {
    value(path_ + name, thing_.*member, range);
  }
  void optional(Name name, double T::*member, double, const Range& range, const char*,
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
  void faces(M T::*member, const Numbers& form, const char*) {
    for (std::size_t face = 0; face < face_names.size(); ++face)
      value(path_ + face_names[face], (thing_.*member)[face], form.range);
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
    }  // readers check lists of any length
  }

  const T& thing_;
  const std::string path_;
  std::vector<Problem>& errors_;
};

class Checker {
 public:
  explicit Checker(const Scene& checked) : scene(checked) {}

  void error(const std::string& path, const std::string& message) {
    problems.errors.push_back({path, message, {}});
  }
  void warning(const std::string& path, const std::string& message) {
    problems.warnings.push_back({path, message, {}});
  }
  template <class T>
  void ranges(const std::string& path, const T& thing) {
    RangeChecker<T> checker(thing, path.empty() ? "" : path + ".", problems.errors);
    visit_keys<T>(checker);
  }
  void number(const std::string& path, double value, const Range& range) {
    if (!range.contains(value))
      error(path, fmt::format("expected {}, got {}", describe(range), value));
  }
  /// \return whether the key at `path` and its elements have no error, so that other checks may use
  /// them.
  bool is_good(const std::string& path) const {
    return std::none_of(problems.errors.begin(), problems.errors.end(), [&](const Problem& error) {
      return error.path.starts_with(path)
             && (error.path.size() == path.size() || error.path[path.size()] == '[');
    });
  }
  bool direction(const std::string& path, const glm::dvec3& value);
  bool affine(const std::string& path, const glm::dmat4& m);

  bool open(int axis) const {
    return scene.medium.sides[static_cast<unsigned>(axis)] == Side::open;
  }
  /// Whether light can enter and leave through a face.
  bool open_face(int face) const {
    return open(face / 2) && !scene.medium.ground[static_cast<unsigned>(face)];
  }
  bool any_open() const;
  bool any_ground() const;

  const Scene& scene;
  Problems problems;
};

/// \param[out] densities of the components
void check_medium(Checker& check, std::vector<Densities>& densities);
/// \param of the component's field or one of its emission
void check_field(Checker& check, const std::string& path, const Component& component,
                 const Field& of);
void check_phase(Checker& check, const std::string& path, const Phase& phase);
void check_lights(Checker& check);
/// Checks that the scene has any light.
void check_shines(Checker& check);
void check_camera(Checker& check);
/// Warns if cells are so many mean free paths wide that the light is wrong. \pre no errors so far
void check_cells(Checker& check, const ResolvedScene& resolved);

}  // namespace tyndall::scene
