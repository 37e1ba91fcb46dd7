#include "render/lights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "render/emission.h"
#include "render/scene_values.h"
#include "tyndall/render/bounds.h"
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

glm::dvec3 corner(const glm::dvec3& low, const glm::dvec3& high, int i) {
  return {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
}

/// The largest area that faces show to any direction of the cone. \param forth of the faces across
/// each axis, to directions along it \param back to directions against it
double largest_area(const glm::dvec3& forth, const glm::dvec3& back, const Cone& cone) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    glm::dvec3 axis(0);
    axis[a] = 1;
    sum +=
        std::max({forth[a] * cone.nearest_cosine(axis), back[a] * cone.nearest_cosine(-axis), 0.0});
  }
  return std::min(sum, glm::length(glm::max(forth, back)));
}

/// What can receive light from afar, in local space: super-voxels that hold something, and grounds.
/// All of the box where there is nothing, where its light has no end, and where detectors count
/// what leaves it.
class Target {
 public:
  Target(const Box& box, const MajorantTables& bounds, bool is_all) : is_endless_(is_endless(box)) {
    const glm::dvec3 extent = to_dvec3(box.extent);
    low_ = extent, high_ = glm::dvec3(0);
    const glm::dvec3 cell = extent / glm::dvec3(bounds.nx, bounds.ny, bounds.nz);
    std::size_t index = 0;
    for (int k = 0; k < bounds.nz; ++k)
      for (int j = 0; j < bounds.ny; ++j)
        for (int i = 0; i < bounds.nx; ++i)
          if (bounds.total[index++] > 0) {
            add(cell * glm::dvec3(i, j, k));
            add(cell * glm::dvec3(i + 1, j + 1, k + 1));
          }
    for (Face face = 0; face < 6; ++face) {
      if (!box.is_ground(face)) continue;
      glm::dvec3 low(0), high = extent;
      (face & 1 ? low : high)[face / 2] = face & 1 ? extent[face / 2] : 0.0;
      add(low), add(high);
    }
    if (is_all || is_endless_ || !(low_.x <= high_.x)) low_ = glm::dvec3(0), high_ = extent;
    // Light that comes from beyond a ground starts beyond it.
    const glm::dvec3 more = (margin - 1) * extent;
    low_ -= more, high_ += more;
  }

  glm::dvec3 center() const { return 0.5 * (low_ + high_); }
  double radius() const { return margin * 0.5 * glm::length(high_ - low_); }
  bool has_no_end() const { return is_endless_; }

  /// \param f (corner of its box) -> bool \return whether all are
  template <class F>
  bool all_corners(const F& f) const {
    for (int i = 0; i < 8; ++i)
      if (!f(corner(low_, high_, i))) return false;
    return true;
  }

  /// As it is seen along the directions from `position`, or from within `radius` of that: the cone
  /// that holds them. All directions from within, and where it has no end.
  Cone cone_from(const glm::dvec3& position, double radius) const {
    const glm::dvec3 way = center() - position;
    const double distance = glm::length(way), reach = this->radius() + radius * margin;
    Cone cone;
    if (distance > 1e-12 * reach) cone.axis = way / distance;
    if (is_endless_ || distance <= reach) return cone;
    const double square = (reach / distance) * (reach / distance);
    cone.height = double{static_cast<float>(square / (1 + std::sqrt(1 - square)))};
    return cone;
  }

  /// Aims `e`, a light about `position`, into `cone`.
  void aim(Emitter& e, const glm::dvec3& position, const Cone& cone) const {
    e.direction = to_vec3f(cone.axis);
    e.cone_height = static_cast<float>(cone.height);
    e.distance = static_cast<float>(glm::length(center() - position));
    e.receivers = {to_vec3f(low_), to_vec3f(high_ - low_), to_vec3f(center()),
                   is_endless_ ? 1e30f : static_cast<float>(radius())};
  }

  /// No less than the area that it shows to any direction of the cone.
  double largest_area(const Cone& cone) const {
    const glm::dvec3 e = high_ - low_, areas(e.y * e.z, e.x * e.z, e.x * e.y);
    return tyndall::largest_area(areas, areas, cone);
  }

  /// \return whether a ray that has entered the medium passes its box.
  bool is_met_by(const Ray& ray) const {
    double t0 = 0, t1 = 1e300;
    const glm::dvec3 o = to_dvec3(ray.origin), d = to_dvec3(ray.direction);
    for (int a = 0; a < 3; ++a) {
      const double x = (low_[a] - o[a]) / d[a], y = (high_[a] - o[a]) / d[a];
      if (!(d[a] == 0 ? o[a] >= low_[a] && o[a] <= high_[a] : true)) return false;
      if (d[a] == 0) continue;
      t0 = std::max(t0, std::min(x, y)), t1 = std::min(t1, std::max(x, y));
    }
    return is_endless_ || t0 <= t1;
  }

 private:
  void add(const glm::dvec3& p) { low_ = glm::min(low_, p), high_ = glm::max(high_, p); }

  glm::dvec3 low_, high_;
  bool is_endless_;
};

/// What becomes of the photons of an emitter, by some that are tried.
struct Yield {
  double weight = 0;    ///< that they have on average: all that is shot
  double arriving = 0;  ///< share of them that meets the receivers
};

/// Points of the additive recurrence of the generalised golden ratio in 6 dimensions [Roberts2018]:
/// the same everywhere. \param lights the clumps that it may be aimed at
Yield try_out(const Emitter& emitter, const Lights& lights, const Box& box, const Target& target) {
  constexpr std::uint32_t count = 8192;
  constexpr std::uint32_t step[] = {0xe60e2b73u, 0xcebd76dbu, 0xb9c9aa3bu,
                                    0xa6f5777fu, 0x9609c71fu, 0x86d516e5u};
  Yield yield;
  for (std::uint32_t i = 1; i <= count; ++i) {
    const auto word = [&](int k) { return 0x80000000u + i * step[k]; };
    const RandomBlock first{0, word(2), word(3), 0}, aim{word(0), word(1), word(4), word(5)};
    Photon photon = emitter.clump >= 0 ? emit_at_clump(emitter, lights, first, aim)
                                       : tyndall::emit(emitter, box, first, aim);
    if (!(largest(photon.weight) > 0)) continue;
    yield.weight += 1.0 / count;
    if (enter(box, photon.ray) && target.is_met_by(photon.ray)) yield.arriving += 1.0 / count;
  }
  return yield;
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
      : box_min_(scene.medium.box_min),
        box_(box),
        target_(box, out.tables, detects_what_leaves(scene.detectors)),
        stop_(stop),
        out_(out) {}

  void add(Glow glow) {
    emit(glow.emitter, glm::dvec3(glow.power));
    out_.glow_tables.push_back(std::move(glow.ends));
  }
  /// \param name for messages
  void add(const scene::Light& light, const std::string& name) {
    const std::size_t first = emitters_.size();
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
    double shot = 0, arriving = 0;
    for (std::size_t i = first; i < emitters_.size(); ++i) {
      const double power = largest(emitters_[i].power);
      shot += power;
      arriving += power * try_out(emitters_[i].value, out_.lights(), box_, target_).arriving;
    }
    constexpr double dim = 0.01;
    if (shot > 0 && arriving < dim * shot) out_.dim_lights.push_back(name);
    shot_powers_.emplace_back(name, shot);
    if (arriving > 0) return;
    std::visit(
        [&](const auto& l) {
          if (const std::string why = why_nothing_arrives(l, shot > 0); !why.empty())
            out_.warnings.push_back(
                fmt::format("{}: none of its light reaches the medium: {}", name, why));
        },
        light);
  }

  /// Gives each its share of the random words. Call it once, at the end.
  void finish() {
    std::vector<double> powers;
    for (const Weighed<Emitter>& e : emitters_) powers.push_back(largest(e.power));
    out_.shot_power = std::accumulate(powers.begin(), powers.end(), 0.0);
    // Where hardly any photon arrives, those of the strongest lights do not.
    if (out_.dim_lights.empty()) {
      for (const auto& [name, power] : shot_powers_)
        if (power > 0 && power >= out_.shot_power / 8) out_.dim_lights.push_back(name);
    }
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
    const glm::dvec3 position = local(light.position);
    const Cone cone = target_.cone_from(position, 0);
    Emitter e;
    e.kind = Emitter::Kind::point;
    e.position = to_vec3f(position);
    target_.aim(e, position, cone);
    e.is_far = cone.height < 2;
    if (!e.is_far) e.direction = {0, 0, 1};  // any: these pictures stay as they were
    DirectLight direct;
    direct.kind = DirectLight::Kind::point;
    direct.position = e.position;
    const double share = 0.5 * cone.height;
    out_.unshot_power += (1 - share) * light.power;
    add_placed(e, share * light.power, direct, light.power / (4 * double{pi}));
  }

  void add(const scene::SpotLight& light) {
    const glm::dvec3 axis = glm::normalize(light.direction), position = local(light.position);
    const double outer = cap_height(0.5 * light.angle), inner = fade_start(light);
    const Cone about_target = target_.cone_from(position, 0);
    const glm::dvec3 power = solid_angle(light) * light.intensity;
    Emitter e;
    e.kind = Emitter::Kind::spot;
    e.position = to_vec3f(position);
    e.axis = to_vec3f(axis);
    e.spot.height = static_cast<float>(outer);
    e.spot.sharpness = static_cast<float>(1 / std::max(outer - inner, 1e-30));
    e.bound = 1;
    DirectLight direct;
    direct.kind = DirectLight::Kind::spot;
    direct.position = e.position;
    direct.direction = e.axis;
    direct.spot = e.spot;
    if (about_target.nearest_cosine(axis) <= 1 - outer) {  // it shines past the medium
      out_.unshot_power += power;
      return;
    }
    Cone cone{axis, outer};
    target_.aim(e, position, cone);
    if (about_target.height < outer) {
      cone = about_target;
      target_.aim(e, position, cone);
      const double shot = cone.solid_angle() * cone.mean([&](Vec3f direction) {
        return e.spot.falloff(e.axis, direction);
      });
      out_.unshot_power += glm::max(power - shot * light.intensity, glm::dvec3(0));
    } else {
      // Its lines are known by where they pass the point of the axis that is nearest to what they
      // are aimed at.
      const double distance = glm::dot(target_.center() - position, axis);
      const glm::dvec3 nearest = position + distance * axis;
      e.receivers.center = to_vec3f(nearest);
      e.receivers.radius += static_cast<float>(glm::length(nearest - target_.center()) * margin);
      e.distance = static_cast<float>(distance);
    }
    e.is_far = about_target.height < 2 && e.distance > e.receivers.radius;
    add_placed(e, cone.solid_angle() * light.intensity, direct, light.intensity);
  }

  /// An emitter that is one of several ways to send light out.
  struct Way {
    Emitter emitter;
    double etendue = 0;  ///< [area sr] of all its photons
    Yield yield;

    double wasted() const { return etendue * (1 - yield.arriving); }
  };
  void judge(Way& way) const { way.yield = try_out(way.emitter, out_.lights(), box_, target_); }

  void add(const scene::RectangleLight& light) {
    std::vector<Way> tiles{send(light)};
    // A large light nearby, and one seen at a grazing angle: parts of it are very unlike.
    constexpr std::size_t most = 64;
    const auto is_poor = [&] {
      double arriving = 0, all = 0;
      for (const Way& tile : tiles) arriving += tile.yield.arriving * tile.etendue;
      for (const Way& tile : tiles) all += tile.etendue;
      return arriving < 0.125 * all;
    };
    std::vector<scene::RectangleLight> parts{light};
    while (!target_.has_no_end() && is_poor() && tiles.size() < most) {
      std::size_t worst = 0;
      for (std::size_t i = 1; i < tiles.size(); ++i)
        if (tiles[i].wasted() > tiles[worst].wasted()) worst = i;
      scene::RectangleLight half = parts[worst];
      glm::dvec3& edge =
          glm::length(half.edge_u) > glm::length(half.edge_v) ? half.edge_u : half.edge_v;
      edge *= 0.5;
      const glm::dvec3 aside = 0.5 * edge, middle = half.center;
      half.center = middle - aside;
      parts[worst] = half, tiles[worst] = send(half);
      half.center = middle + aside;
      parts.push_back(half), tiles.push_back(send(half));
    }
    const auto gives_nothing = [](const Way& tile) { return !(tile.yield.arriving > 0); };
    if (std::all_of(tiles.begin(), tiles.end(), gives_nothing)) tiles = {send(light)};

    const glm::dvec3 power = etendue(light) * light.radiance;
    double shot = 0;
    for (const Way& tile : tiles) {
      emit_light(tile.emitter, tile.etendue * light.radiance, !target_.has_no_end());
      shot += tile.etendue * tile.yield.weight;
    }
    out_.unshot_power += glm::max(power - shot * light.radiance, glm::dvec3(0));
    DirectLight direct;
    direct.kind = DirectLight::Kind::parallelogram;
    direct.parallelogram = parallelogram(light);
    if (!target_.has_no_end()) ask(direct, light.radiance, shot * light.radiance);
  }

  Parallelogram parallelogram(const scene::RectangleLight& light) const {
    const glm::dvec3 u = light.edge_u, v = light.edge_v, across = glm::cross(u, v);
    const double area = glm::length(across);
    const glm::dvec3 normal = across / area;
    Parallelogram shape;
    shape.center = to_vec3f(local(light.center));
    shape.edge_u = to_vec3f(u);
    shape.edge_v = to_vec3f(v);
    shape.dual_u = to_vec3f(glm::cross(v, normal) / area);
    shape.dual_v = to_vec3f(glm::cross(normal, u) / area);
    shape.normal = to_vec3f(normal);
    shape.area = static_cast<float>(area);
    return shape;
  }

  /// The best way to send its light out; of no etendue where it is turned away.
  Way send(const scene::RectangleLight& light) const {
    const glm::dvec3 u = light.edge_u, v = light.edge_v, center = local(light.center);
    const double area = glm::length(glm::cross(u, v));
    const glm::dvec3 normal = glm::cross(u, v) / area;
    Way way;
    way.emitter.kind = Emitter::Kind::parallelogram;
    way.emitter.parallelogram = parallelogram(light);
    if (!target_.has_no_end() && target_.all_corners([&](const glm::dvec3& p) {
          return glm::dot(p - center, normal) <= 0;
        }))
      return way;
    const double radius = 0.5 * std::max(glm::length(u + v), glm::length(u - v));
    const Cone cone = target_.cone_from(center, radius);
    target_.aim(way.emitter, center, cone);
    // Bounds of the cosine and of the cone's height, from all of its points.
    const double reach = target_.radius() * margin;
    const double from = (glm::length(target_.center() - center) - radius) / margin;
    const double above = glm::dot(target_.center() - center, normal) + reach;
    double nearest = cone.nearest_cosine(normal) * margin, height = 2;
    if (from > reach) {
      nearest = std::min(nearest, above / (from - reach) * margin);
      height = cone_of_sphere(static_cast<float>(from), static_cast<float>(reach));
    }
    way.etendue = double{pi} * area;
    if (!target_.has_no_end() && 2 * height * nearest < 1) {
      way.emitter.bound = static_cast<float>(height * nearest);
      way.etendue = 2 * double{pi} * area * double{way.emitter.bound};
    }
    judge(way);
    return better(way, traced_back(way.emitter, cone));
  }

  /// Another way: from what is lit back to the light. Nothing where there is none.
  Way traced_back(Emitter emitter, const Cone& cone) const {
    Way way;
    if (target_.has_no_end()) return way;
    emitter.is_traced_back = true;
    emitter.bound = static_cast<float>(target_.largest_area(cone) * margin);
    way.emitter = emitter;
    way.etendue = cone.solid_angle() * double{emitter.bound};
    judge(way);
    return way;
  }

  static const Way& better(const Way& a, const Way& b) {
    return b.etendue > 0 && b.yield.arriving > a.yield.arriving ? b : a;
  }

  void add(const scene::SphereLight& light) {
    const glm::dvec3 center = local(light.center);
    const Cone cone = target_.cone_from(center, light.radius);
    Way way;
    Emitter& e = way.emitter;
    e.kind = Emitter::Kind::sphere;
    e.position = to_vec3f(center);
    e.radius = static_cast<float>(light.radius);
    target_.aim(e, center, cone);
    DirectLight direct;
    direct.kind = DirectLight::Kind::sphere;
    direct.position = e.position;
    direct.radius = e.radius;
    const glm::dvec3 power = etendue(light) * light.radiance;
    // It shines outwards.
    const bool surrounds = !target_.has_no_end() && target_.all_corners([&](const glm::dvec3& p) {
      return glm::length(p - center) <= light.radius;
    });
    if (surrounds) {
      out_.unshot_power += power;
      return add_placed(e, glm::dvec3(0), direct, light.radiance);
    }
    way.etendue = etendue(light) * 0.5 * cone.height;
    judge(way);
    way = better(way, traced_back(e, cone));
    out_.unshot_power +=
        glm::max(power - way.etendue * way.yield.weight * light.radiance, glm::dvec3(0));
    add_placed(way.emitter, way.etendue * light.radiance, direct, light.radiance);
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
      if (!box_.is_open(face) || cosine <= 0) continue;
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
      if (!box_.is_open(face)) continue;
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
    return largest_area(to_dvec3(lit_areas(box_, {1, 1, 1})),
                        to_dvec3(lit_areas(box_, {-1, -1, -1})), cone);
  }

  // Lights that give nothing, why, and what helps. Nothing of those that are black, which check()
  // says, and of distant ones, which fall on all of an open side.

  std::string why_nothing_arrives(const scene::PointLight& l, bool is_shot) const {
    return largest(l.power) > 0 && is_shot ? hidden() : "";
  }
  std::string why_nothing_arrives(const scene::SpotLight& l, bool is_shot) const {
    if (!(largest(l.intensity) > 0)) return "";
    if (is_shot) return hidden();
    return fmt::format(
        "its cone passes by; turn its direction to {}, where the matter is, or widen its angle",
        text(target_.center() - local(l.position)));
  }
  std::string why_nothing_arrives(const scene::RectangleLight& l, bool is_shot) const {
    if (!(largest(l.radiance) > 0)) return "";
    if (is_shot) return hidden();
    return fmt::format(
        "it is turned away, since it shines along edge_u x edge_v, {}, and the matter is on its "
        "other side; exchange edge_u and edge_v",
        text(glm::normalize(glm::cross(l.edge_u, l.edge_v))));
  }
  std::string why_nothing_arrives(const scene::SphereLight& l, bool is_shot) const {
    if (!(largest(l.radiance) > 0)) return "";
    if (is_shot) return hidden();
    return "the matter is inside of it, and it shines outwards; take an environment light, or a "
           "smaller radius";
  }
  template <class Distant>
  std::string why_nothing_arrives(const Distant&, bool) const {
    return "";
  }
  std::string hidden() const {
    return box_.grounds != 0 ? "a ground is between them, or it shines along its side; move the "
                               "light to the other side"
                             : "the light passes by; move it nearer or turn it";
  }
  static std::string text(glm::dvec3 v) {
    for (int a = 0; a < 3; ++a)
      if (std::abs(v[a]) < 1e-4 * glm::length(v)) v[a] = 0;  // and no -0
    return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", v.x, v.y, v.z);
  }

  static bool detects_what_leaves(const scene::Detectors& d) {
    return d.flux[0] > 0 || d.path_length_bins > 0 || d.scattering_bins > 0
           || d.exit_angle_bins > 0;
  }

  glm::dvec3 box_min_;
  Box box_;
  Target target_;
  const Stop& stop_;
  PreparedScene& out_;
  int group_ = -1;
  int clump_ = -1;  ///< that light from far away is aimed at
  SkyImage sky_;    ///< of the image that was tabulated last
  std::vector<std::pair<std::string, double>> shot_powers_;  ///< of the scene's lights, by name
  std::vector<Weighed<Emitter>> emitters_;
  std::vector<Weighed<DirectLight>> direct_;
};

std::string name_of(const scene::Light& light, std::size_t index) {
  const char* kind =
      std::visit(Overloaded{[](const scene::PointLight&) { return "point"; },
                            [](const scene::SpotLight&) { return "spot"; },
                            [](const scene::RectangleLight&) { return "rectangle"; },
                            [](const scene::SphereLight&) { return "sphere"; },
                            [](const scene::DirectionalLight&) { return "directional"; },
                            [](const scene::EnvironmentLight&) { return "environment"; }},
                 light);
  const std::string& group = std::visit(
      [](const auto& l) -> const auto& { return l.group; }, light);
  return group.empty() ? fmt::format("lights[{}] ({})", index, kind)
                       : fmt::format("lights[{}] ({}, group \"{}\")", index, kind, group);
}

/// \return nothing of fields that have none.
const scene::Remap* remap_of(const scene::Field& field) {
  if (const auto* grid = std::get_if<scene::DenseGrid>(&field)) return &grid->remap;
  if (const auto* grid = std::get_if<scene::SparseGrid>(&field)) return &grid->remap;
  return nullptr;
}

/// Why a component that is to shine does not, and what helps; empty where it does. \param power it
/// has \param hottest [K] where the medium is
std::string why_dark(const Component<AnyField>& component, const scene::Component& from,
                     double power, double hottest) {
  if (component.extinction == 0) return "";  // which check() says
  const Emission& emission = *component.emission;
  if (const auto* body = std::get_if<scene::BlackbodyEmission>(&from.emission)) {
    // Below, what the eye sees of a black body is less than 1e-9 W/(m^2 sr).
    constexpr double visible = 700, fire = 2000;
    if (body->intensity == 0) return "its intensity is 0";
    const double anywhere = largest_density(emission.field);
    if (anywhere >= visible && hottest < visible && largest_density(component.field) > 0)
      return fmt::format(
          "its field is hot only where the medium is not: its largest temperature is {:.4g} K, "
          "{:.4g} K in the medium; move one of them",
          anywhere, hottest);
    if (anywhere < visible) {
      const scene::Remap* remap = remap_of(body->temperature);
      const std::string remedy = !remap || !(anywhere > 0) ? "give a hotter field"
                                 : remap->offset != 0 || !(remap->scale > 0)
                                     ? "give a remap that makes kelvins of its numbers"
                                 : anywhere <= 1.5
                                     ? fmt::format(
                                         "the convention 0 to 1 wants a remap that makes kelvins "
                                         "of it, such as \"remap\": {{\"scale\": {:.4g}}}",
                                         fire / anywhere * remap->scale)
                                     : fmt::format(
                                         "if its numbers are not kelvins, make kelvins of them, "
                                         "such as by \"remap\": {{\"scale\": {:.4g}}}",
                                         fire / anywhere * remap->scale);
      return fmt::format(
          "its largest temperature is {:.4g} K, and black bodies below {} K do not "
          "shine visibly; {}",
          anywhere, visible, remedy);
    }
  }
  if (power > 0) return "";
  if (!(largest(emission.factor) > 0)) return "";  // which check() says
  if (!(largest_density(component.field) > 0))
    return "the component holds no matter that could shine";
  if (emission.kind != Emission::Kind::color && !(largest_density(emission.field) > 0))
    return "its field is 0 everywhere; give one that is not";
  const Vec3f share = Vec3f{1, 1, 1} - component.albedo;
  if (!(largest(share * emission.factor) > 0))
    return "matter emits as it absorbs, and it absorbs nothing in the colours of the emission; "
           "lower its albedo there";
  return "its field is 0 where the matter is; move one of them";
}

}  // namespace

double largest_density(const AnyField& field) {
  using enum AnyField::Kind;
  if (field.kind == solid || field.kind == noise_cloud) return 1;
  return density_bounds(field, {glm::dvec3(0.0), glm::dvec3(1e30)}).upper;
}

void prepare_lights(const Scene& scene, const Box& box, int threads, const Stop& stop,
                    PreparedScene& out) {
  LightList list(scene, box, stop, out);
  for (std::size_t c = 0; c < out.components.size(); ++c) {
    if (!out.components[c].emission) continue;
    Glow of_component = glow(out.components, c, box, out.tables, threads, stop);
    const auto index = static_cast<std::size_t>(out.scene_component[c]);
    const std::string why = why_dark(out.components[c], scene.medium.components[index],
                                     of_component.power, of_component.hottest);
    if (!why.empty()) {
      out.warnings.push_back(fmt::format("medium.components[{}].emission: {}", index, why));
    }
    list.add(std::move(of_component));
  }
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    list.add(scene.lights[i], name_of(scene.lights[i], i));
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
  // A tiny light may be cut where it is seen, so that what it lights is still counted.
  const auto lit_or_seen = [&](const glm::dvec3& radiance, double share) {
    const double lit = largest(radiance) * std::min(share, double{pi});
    return std::max(lit, std::min(seen(radiance), 4096 * lit));
  };
  return std::visit(
      Overloaded{
          [&](const scene::PointLight& l) {
            return largest(l.power) / (4 * double{pi} * square_to(l.position));
          },
          [&](const scene::SpotLight& l) { return largest(l.intensity) / square_to(l.position); },
          [&](const scene::RectangleLight& l) {
            const double share = etendue(l) / (double{pi} * square_to(l.center));
            return lit_or_seen(l.radiance, share);
          },
          [&](const scene::SphereLight& l) {
            const double share = etendue(l) / (4 * double{pi} * square_to(l.center));
            return lit_or_seen(l.radiance, share);
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
