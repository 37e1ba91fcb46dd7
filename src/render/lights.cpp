#include "render/lights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "render/emission.h"
#include "render/scene_values.h"
#include "tyndall/render/image.h"
#include "tyndall/render/lights.h"

namespace tyndall {

double cap_height(double degrees) {
  const double sine = sin_cos_turn(static_cast<float>(degrees / 720)).sin;
  return 2 * sine * sine;
}

namespace {

double fade_start(const scene::SpotLight& light) {
  return cap_height(0.5 * light.angle * (1 - light.edge));
}
double squared_sine(double height) { return height * (2 - height); }

}  // namespace

double solid_angle(const scene::SpotLight& light) {
  return double{pi} * (fade_start(light) + cap_height(0.5 * light.angle));
}
double etendue(const scene::RectangleLight& light) {
  return double{pi} * glm::length(glm::cross(light.edge_u, light.edge_v));
}
double etendue(const scene::SphereLight& light) {
  return 4 * double{pi} * double{pi} * light.radius * light.radius;
}

namespace {

constexpr double margin = 1 + 1e-5;  // of bounds, for what floats round

double face_area(const Box& box, Face face) {
  const glm::dvec3 e = to_dvec3(box.extent);
  return face / 2 == 0 ? e.y * e.z : face / 2 == 1 ? e.x * e.z : e.x * e.y;
}

bool is_endless(const Box& box) { return box.periodic_x || box.periodic_y || box.periodic_z; }

/// Directions about `axis`: 1 - cosine of the half angle.
struct Cone {
  glm::dvec3 axis{0, 0, 1};
  double height = 2;

  double solid_angle() const { return 2 * double{pi} * height; }
  /// The largest cosine between any of its directions and `other`.
  double nearest_cosine(const glm::dvec3& other) const {
    const double middle = std::clamp(glm::dot(axis, other), -1.0, 1.0), edge = 1 - height;
    if (middle >= edge) return 1;
    return middle * edge + std::sqrt((1 - middle * middle) * squared_sine(height));
  }
  /// Of f(direction), by the middle rule.
  template <class F>
  double mean(const F& f) const {
    constexpr int n = 64;
    double sum = 0;
    for (int i = 0; i < n * n; ++i) {
      sum += f(direction_in_cone(to_vec3f(axis), static_cast<float>(height),
                                 (static_cast<float>(i % n) + 0.5f) / n,
                                 (static_cast<float>(i / n) + 0.5f) / n));
    }
    return sum / (n * n);
  }
};

/// The directions in which a light of this radius reaches the medium: the cone about the box's
/// bounding sphere. All of them from within it, and where the medium has no end.
Cone cone_about(const Box& box, const glm::dvec3& position, double radius) {
  const glm::dvec3 center = 0.5 * to_dvec3(box.extent), way = center - position;
  const double distance = glm::length(way), reach = (glm::length(center) + radius) * margin;
  if (is_endless(box) || distance <= reach) return {};
  const double square = (reach / distance) * (reach / distance);
  const auto height = static_cast<float>(square / (1 + std::sqrt(1 - square)));
  return {way / distance, double{height}};
}

/// Image environments as the walks read them: see SkyImage.
std::vector<std::uint32_t> tabulate(const Image& image, SkyImage& sky, const Stop& stop) {
  const int width = image.width(), height = image.height();
  // The largest sine that the tent of a texel reaches: it ends at the middles of the next rows.
  std::vector<double> sines;
  for (int j = 0; j < height; ++j) {
    const double low = std::max((j - 0.5) / height, 0.0), high = std::min((j + 1.5) / height, 1.0);
    const auto sine = [](double v) {
      return double{sin_cos_turn(static_cast<float>(0.5 * v)).sin};
    };
    sines.push_back(low <= 0.5 && high >= 0.5 ? 1.0 : std::max(sine(low), sine(high)));
  }
  const auto each = [&](const auto& call) {
    std::size_t k = 0;
    for (int j = 0; j < height; ++j) {
      stop_if(stop);
      for (int i = 0; i < width; ++i, ++k)
        call(sines[static_cast<std::size_t>(j)] * double{largest(image.texels()[k])});
    }
  };
  double total = 0;
  each([&](double bound) { total += bound; });
  if (!(total > 0)) return {};
  const auto texels = static_cast<double>(image.texels().size());
  // Weights are rounded upwards, and end below 2^32 all the same.
  const double unit = std::max(total * margin / (4294967295.0 - 2 * texels), 1e-30);
  std::vector<std::uint32_t> ends;
  ends.reserve(image.texels().size());
  std::uint32_t sum = 0;
  each([&](double bound) {
    sum += static_cast<std::uint32_t>(std::ceil(bound * margin / unit));
    ends.push_back(sum);
  });
  sky.texels = image.texels().data();
  sky.width = width;
  sky.height = height;
  sky.unit = static_cast<float>(unit);
  sky.irradiance = static_cast<float>(unit * 2 * double{pi} * double{pi} * sum / texels);
  return ends;
}

/// Emitters and lights with their powers, before they are normalised.
class LightList {
 public:
  LightList(const Scene& scene, const Box& box, const Stop& stop, PreparedScene& out)
      : box_min_(scene.medium.box_min), box_(box), stop_(stop), out_(out) {}

  void add(Glow glow) {
    emit(glow.emitter, glm::dvec3(glow.power));
    out_.glow_tables.push_back(std::move(glow.ends));
  }
  void add(const scene::Light& light) {
    std::visit(
        [&](const auto& l) {
          group_ = index_of_group(l.group);
          using Light = std::decay_t<decltype(l)>;
          constexpr bool is_far =
              std::is_same_v<
                  Light, scene::DirectionalLight> || std::is_same_v<Light, scene::EnvironmentLight>;
          if constexpr (is_far) {
            if (!out_.clumps.empty()) return add_at_clumps(l);
          }
          add(l);
        },
        light);
  }

  /// Gives each its share of the random words. Call it once, at the end.
  void finish() {
    std::vector<double> powers;
    for (const Weighed<Emitter>& e : emitters_) powers.push_back(largest(e.power));
    out_.shot_power = std::accumulate(powers.begin(), powers.end(), 0.0);
    out_.emitters = share_out(emitters_, powers);
    for (std::size_t i = 0; i < powers.size(); ++i)
      out_.emitters[i].weight = to_vec3f(emitters_[i].power / powers[i]);

    std::stable_partition(direct_.begin(), direct_.end(),
                          [](const Weighed<DirectLight>& l) { return l.value.is_met(); });
    std::stable_partition(direct_.begin(), direct_.end(),
                          [](const Weighed<DirectLight>& l) { return l.value.is_even(); });
    powers.clear();
    for (const Weighed<DirectLight>& l : direct_) powers.push_back(largest(l.power));
    // What is far off or turned away still lights something.
    const double total = std::accumulate(powers.begin(), powers.end(), 0.0);
    const double least = std::max(total, 1e-300) / (1024 * static_cast<double>(powers.size()));
    for (std::size_t i = 0; i < powers.size(); ++i)
      powers[i] = direct_[i].value.is_even() ? 0.0 : std::max(powers[i], least);
    out_.direct_lights = share_out(direct_, powers);
    std::uint64_t before = 0;
    for (DirectLight& light : out_.direct_lights) {
      light.chance = 0;
      if (light.is_even()) continue;
      const std::uint64_t end = std::uint64_t{light.last_word} + 1;
      light.chance = static_cast<float>(static_cast<double>(end - before) / 4294967296.0);
      before = end;
    }
  }

 private:
  template <class T>
  struct Weighed {
    T value;
    glm::dvec3 power;  // [W]
  };

  /// \return the values, chosen by random words in proportion to their powers.
  template <class T>
  static std::vector<T> share_out(const std::vector<Weighed<T>>& from,
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

  glm::dvec3 local(const glm::dvec3& p) const { return p - box_min_; }

  void emit(Emitter emitter, glm::dvec3 power) {
    if (!(largest(power) > 0)) return;
    emitters_.push_back({emitter, power});
  }
  /// One of the scene's lights. \param is_asked whether it is a direct light, too
  void emit_light(Emitter emitter, glm::dvec3 power, bool is_asked) {
    emitter.group = group_;
    emitter.clump = clump_;
    emitter.is_apart = out_.is_apart && is_asked;
    emit(emitter, power);
  }
  /// \param power it sends into the medium, or about that
  void ask(DirectLight light, glm::dvec3 amount, glm::dvec3 power) {
    if (!(largest(amount) > 0)) return;
    if (clump_ > 0) {  // it is one light
      direct_.back().power += power;
      return;
    }
    light.group = group_;
    light.amount = to_vec3f(amount);
    direct_.push_back({light, power});
  }
  /// A light far away, as often as there are clumps: each as if it were all that there is.
  template <class Light>
  void add_at_clumps(const Light& light) {
    const Box whole = box_;
    glm::dvec3 unshot = power_into_box(light);
    for (const Clump& clump : out_.clumps) {
      box_.extent = clump.size;
      ++clump_;
      add(light);
      unshot -= power_into_box(light);  // that of lines through several counts several times
    }
    box_ = whole;
    clump_ = -1;
    out_.unshot_power += glm::max(unshot, glm::dvec3(0));
  }

  /// Of a small sun: of its middle. Of images: none.
  glm::dvec3 power_into_box(const scene::DirectionalLight& light) const {
    const Vec3f areas = lit_areas(box_, to_vec3f(glm::normalize(light.direction)));
    return double{areas.x + areas.y + areas.z} * light.irradiance;
  }
  glm::dvec3 power_into_box(const scene::EnvironmentLight& light) const {
    if (light.image) return glm::dvec3(0);
    double area = 0;
    for (Face face = 0; face < 6; ++face) area += face_area(box_, face);
    return double{pi} * area * light.scale * light.radiance;
  }

  /// A light at a place, which between periodic sides has images without end: no one asks them.
  void add_placed(const Emitter& emitter, glm::dvec3 power, const DirectLight& direct,
                  glm::dvec3 amount) {
    emit_light(emitter, power, !is_endless(box_));
    if (!is_endless(box_)) ask(direct, amount, power);
  }

  void add(const scene::PointLight& light) {
    const Cone cone = cone_about(box_, local(light.position), 0);
    Emitter e;
    e.kind = Emitter::Kind::point;
    e.position = to_vec3f(local(light.position));
    e.direction = to_vec3f(cone.axis);
    e.cone_height = static_cast<float>(cone.height);
    DirectLight direct;
    direct.kind = DirectLight::Kind::point;
    direct.position = e.position;
    const double share = 0.5 * cone.height;
    out_.unshot_power += (1 - share) * light.power;
    add_placed(e, share * light.power, direct, light.power / (4 * double{pi}));
  }

  void add(const scene::SpotLight& light) {
    const glm::dvec3 axis = glm::normalize(light.direction);
    const double outer = cap_height(0.5 * light.angle), inner = fade_start(light);
    const Cone about_box = cone_about(box_, local(light.position), 0);
    const glm::dvec3 power = solid_angle(light) * light.intensity;
    if (about_box.nearest_cosine(axis) <= 1 - outer) {  // it shines past the medium
      out_.unshot_power += power;
      return;
    }
    Emitter e;
    e.kind = Emitter::Kind::spot;
    e.position = to_vec3f(local(light.position));
    e.axis = to_vec3f(axis);
    e.spot.height = static_cast<float>(outer);
    e.spot.sharpness = static_cast<float>(1 / std::max(outer - inner, 1e-30));
    e.bound = 1;
    DirectLight direct;
    direct.kind = DirectLight::Kind::spot;
    direct.position = e.position;
    direct.direction = e.axis;
    direct.spot = e.spot;
    Cone cone{axis, outer};
    if (about_box.height < outer) {
      cone = about_box;
      const double shot = cone.solid_angle() * cone.mean([&](Vec3f direction) {
        return e.spot.falloff(e.axis, direction);
      });
      out_.unshot_power += glm::max(power - shot * light.intensity, glm::dvec3(0));
    }
    e.direction = to_vec3f(cone.axis);
    e.cone_height = static_cast<float>(cone.height);
    add_placed(e, cone.solid_angle() * light.intensity, direct, light.intensity);
  }

  void add(const scene::RectangleLight& light) {
    const glm::dvec3 u = light.edge_u, v = light.edge_v, across = glm::cross(u, v);
    const double area = glm::length(across);
    const glm::dvec3 normal = across / area, power = etendue(light) * light.radiance;
    Emitter e;
    e.kind = Emitter::Kind::parallelogram;
    Parallelogram& shape = e.parallelogram;
    shape.center = to_vec3f(local(light.center));
    shape.edge_u = to_vec3f(u);
    shape.edge_v = to_vec3f(v);
    shape.dual_u = to_vec3f(glm::cross(v, normal) / area);
    shape.dual_v = to_vec3f(glm::cross(normal, u) / area);
    shape.normal = to_vec3f(normal);
    shape.area = static_cast<float>(area);
    DirectLight direct;
    direct.kind = DirectLight::Kind::parallelogram;
    direct.parallelogram = shape;

    const double radius = 0.5 * std::max(glm::length(u + v), glm::length(u - v));
    const Cone cone = cone_about(box_, local(light.center), radius);
    const double nearest = cone.nearest_cosine(normal) * margin;
    glm::dvec3 shot = power;
    if (cone.height < 2 && nearest <= 0) {
      shot = glm::dvec3(0);  // turned away
      out_.unshot_power += power;
    } else if (2 * cone.height * nearest < 1) {
      e.direction = to_vec3f(cone.axis);
      e.cone_height = static_cast<float>(cone.height);
      e.bound = static_cast<float>(nearest);
      const glm::dvec3 amount = cone.solid_angle() * area * light.radiance;
      shot = nearest * amount;
      out_.unshot_power += power - amount * cone.mean([&](Vec3f direction) {
        return max(dot(direction, shape.normal), 0.0f);
      });
    }
    add_placed(e, shot, direct, light.radiance);
  }

  void add(const scene::SphereLight& light) {
    const Cone cone = cone_about(box_, local(light.center), light.radius);
    Emitter e;
    e.kind = Emitter::Kind::sphere;
    e.position = to_vec3f(local(light.center));
    e.radius = static_cast<float>(light.radius);
    e.direction = to_vec3f(cone.axis);
    e.cone_height = static_cast<float>(cone.height);
    DirectLight direct;
    direct.kind = DirectLight::Kind::sphere;
    direct.position = e.position;
    direct.radius = e.radius;
    const glm::dvec3 power = etendue(light) * light.radiance;
    const double share = 0.5 * cone.height;
    out_.unshot_power += (1 - share) * power;
    add_placed(e, share * power, direct, light.radiance);
  }

  void add(const scene::DirectionalLight& light) {
    const glm::dvec3 direction = glm::normalize(light.direction);
    DirectLight direct;
    direct.direction = to_vec3f(-direction);
    Emitter e;
    e.direction = to_vec3f(direction);
    if (light.angle > 0) {
      const Cone cone{direction, cap_height(0.5 * light.angle)};
      e.kind = Emitter::Kind::sun;
      e.cone_height = direct.cone_height = static_cast<float>(cone.height);
      const double bound = largest_open_area(cone);
      e.bound = static_cast<float>(bound * margin);
      const glm::dvec3 radiance = light.irradiance / (double{pi} * squared_sine(cone.height));
      const glm::dvec3 power = cone.solid_angle() * double{e.bound} * radiance;
      emit_light(e, power, true);
      direct.kind = DirectLight::Kind::sun;
      return ask(direct, radiance, power);
    }
    double area = 0;
    for (Face face = 0; face < 6; ++face) {
      const double cosine = glm::dot(direction, to_dvec3(inward_normal(face)));
      if (!is_open(box_, face) || cosine <= 0) continue;
      e.kind = Emitter::Kind::beam;
      e.face = face;
      emit_light(e, cosine * face_area(box_, face) * light.irradiance, true);
      area += cosine * face_area(box_, face);
    }
    direct.kind = DirectLight::Kind::beam;
    ask(direct, light.irradiance, area * light.irradiance);
  }

  void add(const scene::EnvironmentLight& light) {
    if (light.image) return add_sky(light);
    const glm::dvec3 radiance = light.scale * light.radiance;
    double area = 0;
    for (Face face = 0; face < 6; ++face) {
      if (!is_open(box_, face)) continue;
      Emitter e;
      e.kind = Emitter::Kind::environment;
      e.face = face;
      emit_light(e, double{pi} * face_area(box_, face) * radiance, true);
      area += face_area(box_, face);
    }
    DirectLight direct;
    direct.kind = DirectLight::Kind::environment;
    ask(direct, radiance, double{pi} * area * radiance);
  }

  void add_sky(const scene::EnvironmentLight& light) {
    Emitter e;
    e.kind = Emitter::Kind::sky;
    std::vector<std::uint32_t> ends;
    if (clump_ > 0 && sky_.ends) {
      e.sky = sky_;
    } else {
      ends = tabulate(*light.image, e.sky, stop_);
      if (ends.empty()) return;  // black
      e.sky.ends = ends.data();
    }
    sky_ = e.sky;
    const double turn = 0.5 + light.rotation / 360;
    e.sky.shift = static_cast<float>(turn - std::floor(turn));
    e.bound = static_cast<float>(largest_open_area({}) * margin);
    const glm::dvec3 power(light.scale * double{e.bound} * double{e.sky.irradiance});
    emit_light(e, power, true);
    DirectLight direct;
    direct.kind = DirectLight::Kind::sky;
    direct.sky = e.sky;
    ask(direct, glm::dvec3(light.scale), power);
    if (!ends.empty()) out_.sky_tables.push_back(std::move(ends));  // its memory stays where it is
  }

  /// No less than the open faces show to any direction of the cone.
  double largest_open_area(const Cone& cone) const {
    const glm::dvec3 forth = to_dvec3(lit_areas(box_, {1, 1, 1})),
                     back = to_dvec3(lit_areas(box_, {-1, -1, -1}));
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      glm::dvec3 axis(0);
      axis[a] = 1;
      sum += std::max(
          {forth[a] * cone.nearest_cosine(axis), back[a] * cone.nearest_cosine(-axis), 0.0});
    }
    return std::min(sum, glm::length(glm::max(forth, back)));
  }

  glm::dvec3 box_min_;
  Box box_;
  const Stop& stop_;
  PreparedScene& out_;
  int group_ = -1;
  int clump_ = -1;  ///< that light from far away is aimed at
  SkyImage sky_;    ///< of the image that was tabulated last
  std::vector<Weighed<Emitter>> emitters_;
  std::vector<Weighed<DirectLight>> direct_;
};

}  // namespace

void prepare_lights(const Scene& scene, const Box& box, int threads, const Stop& stop,
                    PreparedScene& out) {
  LightList list(scene, box, stop, out);
  for (std::size_t c = 0; c < out.components.size(); ++c) {
    if (out.components[c].emission)
      list.add(glow(out.components, c, box, out.tables, threads, stop));
  }
  for (const scene::Light& light : scene.lights) list.add(light);
  list.finish();
}

bool has_unsampled_lights(const Scene& scene) {
  const auto is_placed = [](const scene::Light& light) {
    return !std::holds_alternative<scene::DirectionalLight>(light)
           && !std::holds_alternative<scene::EnvironmentLight>(light);
  };
  const auto& sides = scene.medium.sides;
  return std::find(sides.begin(), sides.end(), scene::Side::periodic) != sides.end()
         && std::any_of(scene.lights.begin(), scene.lights.end(), is_placed);
}

double brightness(const scene::Light& light, glm::dvec3 box_min, const Box& box) {
  const glm::dvec3 center = 0.5 * to_dvec3(box.extent);
  // Lit from about here; not nearer than a tenth of the box.
  const auto square_to = [&](const glm::dvec3& position) {
    const double distance = glm::length(position - box_min - center);
    const double near = std::max(distance - glm::length(center), 0.1 * glm::length(center));
    return near * near;
  };
  const auto seen = [](const glm::dvec3& radiance) { return largest(radiance) / 1024; };
  return std::visit(
      Overloaded{
          [&](const scene::PointLight& l) {
            return largest(l.power) / (4 * double{pi} * square_to(l.position));
          },
          [&](const scene::SpotLight& l) { return largest(l.intensity) / square_to(l.position); },
          [&](const scene::RectangleLight& l) {
            const double share = etendue(l) / (double{pi} * square_to(l.center));
            return std::max(largest(l.radiance) * std::min(share, double{pi}), seen(l.radiance));
          },
          [&](const scene::SphereLight& l) {
            const double share = etendue(l) / (4 * double{pi} * square_to(l.center));
            return std::max(largest(l.radiance) * std::min(share, double{pi}), seen(l.radiance));
          },
          [&](const scene::DirectionalLight& l) {
            const double sine = squared_sine(cap_height(0.5 * l.angle));
            return std::max(largest(l.irradiance),
                            l.angle > 0 ? seen(l.irradiance / (double{pi} * sine)) : 0.0);
          },
          [&](const scene::EnvironmentLight& l) {
            if (!l.image) return l.scale * largest(l.radiance);
            double sum = 0;
            for (const Vec3f& texel : l.image->texels()) sum += double{largest(texel)};
            return l.scale
                   * std::max(sum / static_cast<double>(l.image->texels().size()),
                              double{l.image->largest()} / 1024);
          }},
      light);
}

}  // namespace tyndall
