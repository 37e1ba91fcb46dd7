#include "render/lights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "render/emission.h"
#include "render/prepared_light.h"
#include "scene/lights.h"

namespace tyndall {

double cap_height(double degrees) {
  const double sine = sin_cos_turn(static_cast<float>(degrees / 720)).sin;
  return 2 * sine * sine;
}

std::string text_of(glm::dvec3 v) {
  for (int a = 0; a < 3; ++a)
    if (std::abs(v[a]) < 1e-4 * glm::length(v)) v[a] = 0;  // also replaces -0
  return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", v.x, v.y, v.z);
}

namespace {

/// Collects emitters and direct lights with their powers, then normalises them.
class LightList {
 public:
  LightList(const Scene& scene, const Box& box, const Stop& stop, PreparedScene& out)
      : target_(scene, box, stop, out), out_(out) {}

  void add(PreparedEmission emission) {
    if (emission.power > 0) emitters_.push_back({emission.emitter, glm::dvec3(emission.power)});
    out_.glow_tables.push_back(std::move(emission.ends));
  }
  /// \param name for messages \return the light's brightness: see PreparedLight
  double add(const scene::Light& light, const std::string& name) {
    PreparedLight prepared =
        std::visit([&](const auto& l) { return prepare_light(l, target_); }, light);
    out_.unshot_power += prepared.unshot_power;
    const int group = index_of_group(std::visit([](const auto& l) { return l.group; }, light));
    const bool is_sampled = is_distant(light) || !target_.is_endless();
    if (prepared.direct && is_sampled)
      direct_.push_back({{*prepared.direct, 0, 1, group}, prepared.direct_power});
    double shot = 0, arriving = 0;
    for (auto& [emitter, emitter_power] : prepared.emitters) {
      emitter.group = group;
      emitter.is_apart = out_.is_apart && is_sampled;
      emitters_.push_back({emitter, emitter_power});
      const double power = largest(emitter_power);
      shot += power;
      arriving += power * target_.try_out(emitter).arriving;
    }
    // Moving a vector keeps its elements in place.
    if (!prepared.table.empty()) out_.sky_tables.push_back(std::move(prepared.table));
    constexpr double dim = 0.01;
    if (shot > 0 && arriving < dim * shot) out_.dim_lights.push_back(name);
    shot_powers_.emplace_back(name, shot);
    if (!(arriving > 0)) {
      const std::string why = !(shot > 0) ? prepared.why_unshot : is_distant(light) ? "" : hidden();
      if (!why.empty())
        out_.warnings.push_back(
            fmt::format("{}: none of its light reaches the medium: {}", name, why));
    }
    return prepared.brightness;
  }

  /// Divides the random words among all lights. \pre called once, at the end
  void finish() {
    std::vector<double> powers;
    for (const Weighted<Emitter>& e : emitters_) powers.push_back(largest(e.power));
    out_.shot_power = std::accumulate(powers.begin(), powers.end(), 0.0);
    // dim_lights are the possible causes of unlit replicates: the strongest lights if none is dim.
    if (out_.dim_lights.empty()) {
      for (const auto& [name, power] : shot_powers_)
        if (power > 0 && power >= out_.shot_power / 8) out_.dim_lights.push_back(name);
    }
    out_.emitters = divide_words(emitters_, powers);
    for (std::size_t i = 0; i < powers.size(); ++i)
      out_.emitters[i].weight = to_vec3f(emitters_[i].power / powers[i]);

    std::stable_partition(direct_.begin(), direct_.end(),
                          [](const Weighted<DirectLight>& l) { return !l.value.is_delta(); });
    std::stable_partition(direct_.begin(), direct_.end(),
                          [](const Weighted<DirectLight>& l) { return l.value.is_uniform(); });
    powers.clear();
    for (const Weighted<DirectLight>& l : direct_) powers.push_back(largest(l.power));
    // A light far away or turned away keeps a minimum power: it still lights something.
    const double total = std::accumulate(powers.begin(), powers.end(), 0.0);
    const double least = std::max(total, 1e-300) / (1024 * static_cast<double>(powers.size()));
    for (std::size_t i = 0; i < powers.size(); ++i)
      powers[i] = direct_[i].value.is_uniform() ? 0.0 : std::max(powers[i], least);
    out_.direct_lights = divide_words(direct_, powers);
    std::uint64_t before = 0;
    for (DirectLight& light : out_.direct_lights) {
      light.probability = 0;
      if (light.is_uniform()) continue;
      const std::uint64_t end = std::uint64_t{light.last_word} + 1;
      light.probability = static_cast<float>(static_cast<double>(end - before) / 4294967296.0);
      before = end;
    }
  }

 private:
  template <class T>
  struct Weighted {
    T value;
    glm::dvec3 power;  // [W]
  };

  /// \return the values, sampled by random words in proportion to their powers.
  template <class T>
  static std::vector<T> divide_words(const std::vector<Weighted<T>>& from,
                                     const std::vector<double>& powers) {
    const double total = std::accumulate(powers.begin(), powers.end(), 0.0);
    std::vector<T> values;
    double sum = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      sum += powers[i];
      values.push_back(from[i].value);
      values[i].last_word = static_cast<std::uint32_t>(
          std::clamp(sum / std::max(total, 1e-300) * 4294967296.0 - 1.0, 0.0, 4294967295.0));
    }
    return values;
  }

  int index_of_group(const std::string& name) {
    const auto found = std::find(out_.light_groups.begin(), out_.light_groups.end(), name);
    const auto index = found - out_.light_groups.begin();
    if (found == out_.light_groups.end()) out_.light_groups.push_back(name);
    return static_cast<int>(index);
  }

  /// Why no photon of a placed light arrives, although it emits some.
  const char* hidden() const {
    return target_.box().grounds != 0
               ? "a ground is between them, or it shines along its side; move the light to the "
                 "other side"
               : "the light passes by; move it nearer or turn it";
  }

  Target target_;
  PreparedScene& out_;
  std::vector<std::pair<std::string, double>> shot_powers_;  ///< names and powers of scene lights
  std::vector<Weighted<Emitter>> emitters_;
  std::vector<Weighted<DirectLight>> direct_;
};

std::string name_of(const scene::Light& light, std::size_t index) {
  const std::string& group = std::visit(
      [](const auto& l) -> const auto& { return l.group; }, light);
  const char* kind = scene::case_name(light);
  return group.empty() ? fmt::format("lights[{}] ({})", index, kind)
                       : fmt::format("lights[{}] ({}, group \"{}\")", index, kind, group);
}

}  // namespace

double prepare_lights(const Scene& scene, const Box& box, int threads, const Stop& stop,
                      PreparedScene& out) {
  LightList list(scene, box, stop, out);
  for (std::size_t c = 0; c < out.components.size(); ++c) {
    if (!out.components[c].emission) continue;
    PreparedEmission emission = prepare_emission(out.components, c, box, out.tables, threads, stop);
    const auto index = static_cast<std::size_t>(out.scene_component[c]);
    const std::string why = why_dark(out.components[c], scene.medium.components[index],
                                     emission.power, emission.hottest);
    if (!why.empty()) {
      out.warnings.push_back(fmt::format("medium.components[{}].emission: {}", index, why));
    }
    list.add(std::move(emission));
  }
  double brightest = 0;
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    brightest = std::max(brightest, list.add(scene.lights[i], name_of(scene.lights[i], i)));
  list.finish();
  return brightest;
}

bool is_distant(const scene::Light& light) {
  return std::holds_alternative<scene::DirectionalLight>(light)
         || std::holds_alternative<scene::EnvironmentLight>(light);
}

bool has_unsampled_lights(const Scene& scene) {
  const auto& sides = scene.medium.sides;
  return std::find(sides.begin(), sides.end(), scene::Side::periodic) != sides.end()
         && !std::all_of(scene.lights.begin(), scene.lights.end(), is_distant);
}

}  // namespace tyndall
