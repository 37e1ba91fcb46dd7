#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scene/scene.h"
#include "tyndall/render/check.h"
#include "tyndall/render/render.h"

namespace tyndall {
namespace {

using namespace scene;

/// One number of a scene.
struct Number {
  std::string path;
  Range range;
  std::function<double()> get;
  std::function<void(double)> set;
};

/// Collects the numbers of a thing, and the first number of a list.
template <class T>
class Collector : public Visitor<Collector<T>> {
 public:
  Collector(T& thing, std::string path, std::vector<Number>& numbers)
      : thing_(thing), path_(std::move(path)), numbers_(numbers) {}

  template <class M, class Form>
  void operator()(Name name, M T::*member, const Form& form, const char*, const char*) {
    if constexpr (requires { form_of(form).range; })
      add(path_ + name.text, thing_.*member, form_of(form).range);
  }
  template <class M>
  void unwritten(M T::*) {}
  void part(const char* name, double T::*member, const Range& range) {
    add(path_ + name, thing_.*member, range);
  }
  void optional(Name name, double T::*member, double, const Range& range, const char*,
                const char*) {
    add(path_ + name.text, thing_.*member, range);
  }
  template <class Describe>
  void group(const char* name, const char*, const Describe& keys) {
    Collector inner(thing_, path_ + name + ".", numbers_);
    keys(inner);
  }
  template <class E, class Describe>
  void when(E T::*kind, E value, const char*, const Describe& keys) {
    if (thing_.*kind == value) keys(*this);
  }

 private:
  template <class V>
  void add(const std::string& path, V& value, const Range& range) {
    if constexpr (std::is_arithmetic_v<V>) {
      using Ends = std::numeric_limits<V>;
      const auto set = [&value](double x) {
        if (x >= static_cast<double>(Ends::lowest()) && x < static_cast<double>(Ends::max()))
          value = static_cast<V>(x);
      };
      numbers_.push_back({path, range, [&value] { return static_cast<double>(value); }, set});
    } else if constexpr (requires { value.emplace(); }) {
      add(path, value.emplace(), range);
    } else if constexpr (!requires { value.push_back(0); }) {
      add(path + "[0]", value[0], range);
    }
  }

  T& thing_;
  const std::string path_;
  std::vector<Number>& numbers_;
};

class Numbered {
 public:
  std::vector<Number> of(Scene& scene) {
    add("", scene);
    add("medium.", scene.medium);
    add("camera.", scene.camera);
    add("detectors.", scene.detectors);
    Component& c = scene.medium.components[0];
    const std::string path = "medium.components[0].";
    add(path, c);
    add_any(path + "phase.", c.phase);
    add_any(path + "emission.", c.emission);
    add_any(path + "field.", c.field);
    if (auto* solid = std::get_if<scene::Solid>(&c.field)) add_any(path + "field.", solid->body);
    if (auto* cloud = std::get_if<scene::NoiseCloud>(&c.field))
      add_any(path + "field.body.", cloud->body);
    if (auto* grid = std::get_if<scene::DenseGrid>(&c.field))
      add(path + "field.remap.", grid->remap);
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
      add_any(fmt::format("lights[{}].", i), scene.lights[i]);
    return std::move(numbers_);
  }

 private:
  template <class T>
  void add(const std::string& path, T& thing) {
    Collector<T> collector(thing, path, numbers_);
    visit_keys<T>(collector);
  }
  template <class V>
  void add_any(const std::string& path, V& variant) {
    std::visit([&](auto& thing) { add(path, thing); }, variant);
  }

  std::vector<Number> numbers_;
};

/// Scenes that together have all things with numbers in the scene file.
std::vector<Scene> scenes() {
  const std::vector<Field> fields = {Solid{Sphere{}},
                                     Solid{Cuboid{}},
                                     Solid{Torus{}},
                                     Solid{Capsule{}},
                                     NoiseCloud{},
                                     NoiseCloud{8, 0.5, 0, 0.5, 1.4, 1.8, Ellipsoid{}},
                                     NoiseCloud{8, 0.5, 0, 0.5, 1.4, 1.8, Layer{}},
                                     NoiseCloud{8, 0.5, 0, 0.5, 1.4, 1.8, Plume{}},
                                     DenseGrid{{1, 1, 1}, {1}, {}, {}}};
  std::vector<Scene> all;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    Scene scene;
    Component component;
    component.field = fields[i];
    component.albedo = glm::dvec3(0.5);
    if (i % 3 == 1) component.phase = HenyeyGreensteinPhase{0.5};
    if (i % 3 == 2) component.phase = TwoLobesPhase{};
    if (i % 3 == 1) component.emission = ColorEmission{};
    if (i % 3 == 2) component.emission = BlackbodyEmission{};
    scene.medium.components = {component};
    scene.lights = {PointLight{}, DirectionalLight{}, EnvironmentLight{},
                    SpotLight{},  RectangleLight{},   SphereLight{}};
    scene.camera.projection = static_cast<Projection>(i % 3);
    all.push_back(scene);
  }
  return all;
}

TEST(Describe, EveryRangeIsChecked) {
  for (Scene& scene : scenes()) {
    for (const Number& number : Numbered().of(scene)) {
      const double value = number.get();
      for (const double x :
           {number.range.high * 2 + 1, number.range.low - std::abs(number.range.low) - 1}) {
        if (!std::isfinite(x)) continue;
        number.set(x);
        if (number.get() != x) continue;  // the type has no value out of range
        bool is_found = false;
        for (const Problem& problem : check(scene).errors)
          is_found = is_found || problem.path == number.path;
        EXPECT_TRUE(is_found) << number.path << ' ' << x;
        number.set(value);
      }
    }
  }
}

TEST(Describe, EveryNumberIsHashed) {
  for (Scene& scene : scenes()) {
    for (const Number& number : Numbered().of(scene)) {
      if (number.path == "preview.exposure") continue;    // only for the preview
      if (number.path == "lights[2].rotation") continue;  // only for an image, which it lacks
      const auto hash = [&] { return scene_hash(ResolvedScene::unchecked(scene)); };
      const std::uint64_t before = hash();
      const double value = number.get();
      for (const double x : {value * 0.5, value + 1, value - 1, value + 0.125})
        if (number.get() == value && number.range.contains(x)) number.set(x);
      EXPECT_NE(number.get(), value) << number.path;
      EXPECT_NE(hash(), before) << number.path;
      number.set(value);
      EXPECT_EQ(hash(), before) << number.path;
    }
  }
}

TEST(Describe, NamesWhatAVariantHolds) {
  EXPECT_STREQ(case_name(Light(SphereLight{})), "sphere");
  EXPECT_STREQ(case_name(Phase(TwoLobesPhase{})), "two_lobes");
  EXPECT_STREQ(word_of(Projection::spherical), "spherical");
}

}  // namespace
}  // namespace tyndall
