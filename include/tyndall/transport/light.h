/// \file
/// Where photons come from, and what matter sees of it. All lights are flattened into emitters,
/// chosen in proportion to their power, so that each photon carries the same power times a colour
/// whose largest channel is 1 at most. Area lights emit and are seen, but block nothing.
#pragma once

#include "tyndall/medium/medium.h"
#include "tyndall/random/random.h"
#include "tyndall/transport/walk.h"

namespace tyndall {

/// \return the first of `count` ascending `ends` that is above word / 2^32 of the last one.
TYN_HD int choose(const std::uint32_t* ends, int count, std::uint32_t word) {
  const auto at = static_cast<std::uint32_t>(std::uint64_t{word} * ends[count - 1] >> 32);
  int first = 0, last = count - 1;
  while (first < last) {
    const int middle = first + (last - first) / 2;
    if (ends[middle] > at)
      last = middle;
    else
      first = middle + 1;
  }
  return first;
}

/// Where the matter of a component may shine: a box of cells, each with an integer weight in
/// proportion to a bound of what it emits, by which it is chosen.
struct GlowCells {
  Vec3f low{0, 0, 0}, size{0, 0, 0};  ///< of the box's first cell
  int nx = 0, ny = 0, nz = 0;
  const std::uint32_t* ends = nullptr;  ///< [nx ny nz] sums of the weights up to a cell, x fastest
  float unit = 0;                       ///< emission at weight 1 [W/(length^3 sr)]

  TYN_HD int count() const { return nx * ny * nz; }

  TYN_HD int choose(std::uint32_t word) const { return tyndall::choose(ends, count(), word); }
  TYN_HD float bound(int cell) const {
    return unit * static_cast<float>(ends[cell] - (cell > 0 ? ends[cell - 1] : 0u));
  }
  TYN_HD Vec3f point(int cell, float u, float v, float w) const {
    return low
           + size
                 * Vec3f{static_cast<float>(cell % nx) + u, static_cast<float>(cell / nx % ny) + v,
                         static_cast<float>(cell / nx / ny) + w};
  }
};

// ---- Shapes of lights

/// How a spot fades from the middle of its cone to the edge: a cubic of the cosine.
struct SpotCone {
  float height = 2;     ///< of the cone's cap: 1 - cosine of the half angle
  float sharpness = 0;  ///< over the height of the part that fades

  TYN_HD float falloff(Vec3f axis, Vec3f direction) const {
    const float x = clamp((height - cap_height(axis, direction)) * sharpness, 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
  }
};

/// A parallelogram that shines on the side of its normal.
struct Parallelogram {
  Vec3f center{0, 0, 0};
  Vec3f edge_u{1, 0, 0}, edge_v{0, 1, 0};  ///< from end to end
  Vec3f dual_u{1, 0, 0}, dual_v{0, 1, 0};  ///< in its plane: along an edge 1, along the other 0
  Vec3f normal{0, 0, 1};
  float area = 1;

  /// u, v in [0, 1]
  TYN_HD Vec3f point(float u, float v) const {
    return center + (u - 0.5f) * edge_u + (v - 0.5f) * edge_v;
  }
  /// \return whether the line from the centre's `offset` along the unit `direction`, at `distance`,
  /// passes through it.
  TYN_HD bool holds(Vec3f offset, Vec3f direction, float distance) const {
    const Vec3f at = offset + distance * direction;
    return abs(dot(at, dual_u)) <= 0.5f && abs(dot(at, dual_v)) <= 0.5f;
  }
  /// \return how far along the unit `direction` the bright side is met, 0 for never. The ray
  /// begins `before` ahead of `from`: as much may be below 0.
  TYN_HD float meet(Vec3f from, Vec3f direction, float before = 0.0f) const {
    const float cosine = -dot(normal, direction);
    const Vec3f way = center - from;
    const float distance = -dot(normal, way) / cosine;
    if (!(cosine > 0.0f && distance > -before)) return 0.0f;
    const Vec3f at = distance * direction - way;
    return abs(dot(at, dual_u)) <= 0.5f && abs(dot(at, dual_v)) <= 0.5f ? distance : 0.0f;
  }
};

/// Radiance from all around, by an image in longitude and latitude. Its rows go from +y to -y; of
/// its columns, seen from within with +y up, the middle one is at +z, and that a quarter to the
/// left of it at +x, unless the image is turned. Radiance is linear between the middles of texels,
/// around the ends of a row, too, and constant beyond the first and the last row's middles.
///
/// Directions are drawn by a table of integer weights: a texel, and a place about its middle by the
/// tent that the interpolation gives it, so that the density is the interpolation of the weights.
/// A weight is no less than the texel's largest channel times the largest sine of the polar angle
/// that its tent reaches, in units of `unit`, so that radiance never exceeds what the density
/// stands for.
struct SkyImage {
  const Vec3f* texels = nullptr;        ///< [width height], from the top left
  const std::uint32_t* ends = nullptr;  ///< [width height] sums of the weights up to a texel
  int width = 0, height = 0;
  float shift = 0.5f;    ///< [turn] column at +z
  float unit = 0;        ///< radiance times sine at weight 1
  float irradiance = 0;  ///< integral of the bound of the radiance over all directions [W/area]

  struct Place {
    float u, v;  ///< in [0, 1]: longitude and polar angle over the width and height
    float sine;  ///< of the polar angle
  };
  struct Sample {
    Vec3f direction;
    Vec3f share;  ///< radiance over the bound, times `irradiance` it is that over the density
    float pdf;    ///< [1/sr]
  };

  TYN_HD int count() const { return width * height; }

  TYN_HD Sample sample(std::uint32_t texel, std::uint32_t offset) const {
    const int chosen = choose(ends, count(), texel);
    const float x =
        static_cast<float>(chosen % width) + 0.5f + tent(static_cast<float>(offset >> 16));
    float y =
        static_cast<float>(chosen / width) + 0.5f + tent(static_cast<float>(offset & 0xffffu));
    const float rows = static_cast<float>(height);
    y = y < 0.0f ? -y : y > rows ? 2.0f * rows - y : y;
    const float u = fraction(x / static_cast<float>(width)), v = clamp(y / rows, 0.0f, 1.0f);
    const SinCos polar = sin_cos_turn(0.5f * v), azimuth = sin_cos_turn(fraction(shift - u));
    const Place place{u, v, polar.sin};
    const float weight = weight_at(place);
    return {{polar.sin * azimuth.sin, polar.cos, polar.sin * azimuth.cos},
            (polar.sin / (unit * weight)) * radiance(place),
            pdf(place, weight)};
  }

  TYN_HD Place place_of(Vec3f direction) const {
    const float sine = sqrt(direction.x * direction.x + direction.z * direction.z);
    return {fraction(shift - turn_of(direction.z, direction.x)),
            min(2.0f * turn_of(direction.y, sine), 1.0f), sine};
  }

  TYN_HD Vec3f radiance(Place place) const {
    const Square s = square(place);
    const auto row = [&](int j) {
      return (1.0f - s.x) * texels[j * width + s.i0] + s.x * texels[j * width + s.i1];
    };
    return (1.0f - s.y) * row(s.j0) + s.y * row(s.j1);
  }

  TYN_HD float pdf(Place place) const { return pdf(place, weight_at(place)); }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    if (!texels) return;
    texels = copy(texels, static_cast<std::size_t>(count()));
    ends = copy(ends, static_cast<std::size_t>(count()));
  }

 private:
  /// The four texels about a place, and the place between them.
  struct Square {
    int i0, i1, j0, j1;
    float x, y;
  };
  TYN_HD Square square(Place place) const {
    const float x = place.u * static_cast<float>(width) - 0.5f,
                y = place.v * static_cast<float>(height) - 0.5f;
    const int i = floor_to_int(x), j = floor_to_int(y);
    return {i < 0 ? width - 1 : clamp(i, 0, width - 1),
            i + 1 < width ? i + 1 : 0,
            clamp(j, 0, height - 1),
            clamp(j + 1, 0, height - 1),
            x - static_cast<float>(i),
            y - static_cast<float>(j)};
  }

  TYN_HD float weight(int texel) const {
    return static_cast<float>(ends[texel] - (texel > 0 ? ends[texel - 1] : 0u));
  }
  TYN_HD float weight_at(Place place) const {
    const Square s = square(place);
    const auto row = [&](int j) {
      return (1.0f - s.x) * weight(j * width + s.i0) + s.x * weight(j * width + s.i1);
    };
    return (1.0f - s.y) * row(s.j0) + s.y * row(s.j1);
  }
  TYN_HD float pdf(Place place, float weight) const {
    return unit * weight / (irradiance * max(place.sine, 1e-9f));
  }

  /// In (-1, 1), of one of 2^16 even steps.
  TYN_HD static float tent(float step) {
    const float s = (step + 0.5f) * (1.0f / 32768.0f);  // in (0, 2)
    return s < 1.0f ? sqrt(s) - 1.0f : 1.0f - sqrt(2.0f - s);
  }
  TYN_HD static float fraction(float x) { return x - floor(x); }
};

// ---- Photons

/// What photons of placed lights are aimed at: a box, and the sphere about it.
struct Receivers {
  Vec3f low{0, 0, 0}, size{1, 1, 1};
  Vec3f center{0.5f, 0.5f, 0.5f};
  float radius = 1;
};

struct Emitter {
  enum class Kind {
    point,          ///< from `position` uniformly into the cone about `direction`
    spot,           ///< the same, fading about `axis`
    disc,           ///< from `position` through an even point of the disc that `direction` ends in
    beam,           ///< parallel light along `direction`, evenly over the face of the box
    sun,            ///< an even direction of the cone, evenly over the faces of the box
    environment,    ///< cosine-distributed inwards, evenly over the face of the box: constant
                    ///< radiance outside
    sky,            ///< directions of an image, evenly over the faces of the box
    parallelogram,  ///< from a uniform point of it into the cone that holds the receivers there,
                    ///< or cosine-distributed about its normal
    sphere,         ///< about `position`: from its surface into the cone
    matter,         ///< of a component that shines, evenly in all directions
  };

  Kind kind = Kind::point;
  std::uint32_t last_word =
      0;  ///< chosen by random words up to this one (and above the previous emitter's)
  Vec3f weight{1, 1, 1};  ///< colour of its photons, largest channel 1
  Vec3f position{0, 0, 0};
  Vec3f direction{0, 0, 1};
  float cone_height = 2;  ///< 1 - cosine of the half angle: the cone that holds the medium, or the
                          ///< spot, or the sun; 2 for all directions
  float radius = 0;       ///< disc, across `direction`; sphere
  Face face = 0;          ///< beam, environment
  float bound = 0;  ///< parallelogram: of the cosine times the cone's height, 0: no cone; sun, sky:
                    ///< of the area that the open faces show to a direction; traced back: of the
                    ///< area that the receivers show
  Receivers receivers;          ///< point, spot, parallelogram, sphere
  float distance = 0;           ///< [length] from the light's centre to that of the receivers; then
                                ///< `direction` is the way there
  bool is_far = false;          ///< point, spot: outside the receivers' sphere
  bool is_traced_back = false;  ///< parallelogram, sphere: from a uniform point that the receivers
                                ///< show to a direction of the cone, back to the light
  Vec3f axis{0, 0, 1};          ///< spot
  SpotCone spot;
  Parallelogram parallelogram;
  SkyImage sky;
  int component = 0;      ///< matter: whose, of the prepared medium
  bool is_apart = false;  ///< its photons leave no light where they collide first: the gather asks
                          ///< the light itself
  int group = -1;         ///< of PreparedScene::light_groups; -1: matter
  int clump = -1;         ///< whose faces light from far away is aimed at; -1: the box's
  GlowCells cells;        ///< matter

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    if (cells.ends) cells.ends = copy(cells.ends, static_cast<std::size_t>(cells.count()));
    sky.relocate(copy);
  }
};

/// A box of matter in a medium that is nearly empty: nothing lies between the clumps.
struct Clump {
  Vec3f low{0, 0, 0}, size{1, 1, 1};

  /// \return whether the line along the unit `direction` passes through it. \param[out] first where
  /// it enters [length]
  TYN_HD bool meets(Vec3f origin, Vec3f direction, float& first) const {
    float enters = -largest_float, leaves = largest_float;
    const auto along = [&](float from, float way, float begin, float length) {
      if (way == 0.0f) {
        if (from < begin || from > begin + length) leaves = -largest_float;
        return;
      }
      const float a = (begin - from) / way, b = (begin + length - from) / way;
      enters = max(enters, min(a, b));
      leaves = min(leaves, max(a, b));
    };
    along(origin.x, direction.x, low.x, size.x);
    along(origin.y, direction.y, low.y, size.y);
    along(origin.z, direction.z, low.z, size.z);
    first = enters;
    return enters <= leaves;
  }
};

struct Lights {
  const Emitter* emitters = nullptr;
  int count = 0;
  const Clump* clumps = nullptr;
  int clump_count = 0;
};

// ---- Lights as matter sees them

/// A direction to a light, and what arrives from it where nothing is in between.
struct LightSample {
  Vec3f direction;   ///< to the light, unit
  float distance;    ///< [length] to the light; largest_float: beyond everything
  Vec3f irradiance;  ///< [W/area] radiance over the density of `direction` (for point, spot and
                     ///< parallel lights, all there is), over the chance to choose this light
  float pdf;         ///< [1/sr] of `direction`, the chance of the light included; 0 where no ray
                     ///< meets the light by chance: point, spot, parallel
  int group;         ///< of PreparedScene::light_groups
};

/// A light as matter sees it.
struct DirectLight {
  enum class Kind { point, spot, beam, sun, environment, sky, parallelogram, sphere };

  Kind kind = Kind::point;
  std::uint32_t last_word = 0;  ///< as an Emitter's
  float chance = 1;             ///< to be chosen; 0 of the first ones, if of any
  int group = 0;
  Vec3f amount{0, 0, 0};  ///< point, spot: intensity [W/sr]; beam: [W/area]; radiance [W/(area sr)]
                          ///< of the others, of which the image is a multiple
  Vec3f position{0, 0, 0};   ///< point, spot, sphere
  Vec3f direction{0, 0, 1};  ///< spot: its axis; beam, sun: to the light
  float radius = 0;          ///< sphere
  float cone_height = 0;     ///< sun
  SpotCone spot;
  Parallelogram parallelogram;
  SkyImage sky;

  static constexpr float highest_pdf = 1e18f;  ///< whose square is a number

  /// Whether rays meet it by chance.
  TYN_HD bool is_met() const {
    return kind != Kind::point && kind != Kind::spot && kind != Kind::beam;
  }
  /// Whether it is the same from everywhere: found best by chance, by the directions that matter
  /// scatters into. It has no chance to be asked.
  TYN_HD bool is_even() const { return kind == Kind::environment; }
  /// Whether it is beyond everything.
  TYN_HD bool is_distant() const {
    return kind == Kind::beam || kind == Kind::sun || kind == Kind::environment
           || kind == Kind::sky;
  }

  /// As if it were the only light.
  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    LightSample out{direction, largest_float, {0, 0, 0}, 0.0f, group};
    const float u = uniform_symmetric(random.b), v = uniform_symmetric(random.c);
    switch (kind) {
      case Kind::point:
      case Kind::spot: {
        const Vec3f way = position - p;
        const float square = max(dot(way, way), 1e-30f);
        out.distance = sqrt(square);
        out.direction = (1.0f / out.distance) * way;
        out.irradiance = (1.0f / square) * amount;
        if (kind == Kind::spot)
          out.irradiance = spot.falloff(direction, -1.0f * out.direction) * out.irradiance;
        break;
      }
      case Kind::beam:
        out.irradiance = amount;
        break;
      case Kind::sun:
        out.direction = direction_in_cone(direction, cone_height, u, v);
        out.pdf = cone_pdf(cone_height);
        out.irradiance = (2.0f * pi * cone_height) * amount;
        break;
      case Kind::environment:
        out.direction = direction_in_cone({0, 0, 1}, 2.0f, u, v);
        out.pdf = cone_pdf(2.0f);
        out.irradiance = (4.0f * pi) * amount;
        break;
      case Kind::sky: {
        const SkyImage::Sample s = sky.sample(random.b, random.c);
        out.direction = s.direction;
        out.pdf = min(s.pdf, highest_pdf);
        out.irradiance = sky.irradiance * (s.share * amount);
        break;
      }
      case Kind::parallelogram: {
        const Vec3f way = parallelogram.point(u, v) - p;
        const float square = max(dot(way, way), 1e-30f);
        out.distance = sqrt(square);
        out.direction = (1.0f / out.distance) * way;
        const float cosine = -dot(parallelogram.normal, out.direction);
        if (!(cosine > 0.0f)) break;
        out.pdf = parallelogram_pdf(out.distance, cosine);
        out.irradiance = (cosine * (parallelogram.area / square)) * amount;
        break;
      }
      case Kind::sphere: {
        const float height = cap_of_sphere(p);
        if (!(height > 0.0f)) break;
        const Vec3f way = position - p;
        out.direction = direction_in_cone(normalize(way), height, u, v);
        out.distance = distance_to_sphere(way, out.direction);
        out.pdf = cone_pdf(height);
        out.irradiance = (2.0f * pi * height) * amount;
        break;
      }
    }
    return out;
  }

  /// The same of all that a ray meets. Calls add(radiance, pdf) or not.
  template <class Add>
  TYN_HD void meet(Vec3f from, Vec3f along, float distance, Add&& add, float before = 0.0f) const {
    if (is_distant() && distance != largest_float) return;
    switch (kind) {
      case Kind::point:
      case Kind::spot:
      case Kind::beam:
        break;
      case Kind::sun:
        if (cap_height(direction, along) <= cone_height) add(amount, cone_pdf(cone_height));
        break;
      case Kind::environment:
        add(amount, cone_pdf(2.0f));
        break;
      case Kind::sky: {
        const SkyImage::Place place = sky.place_of(along);
        add(amount * sky.radiance(place), min(sky.pdf(place), highest_pdf));
        break;
      }
      case Kind::parallelogram: {
        const float at = parallelogram.meet(from, along, before);
        if (at != 0.0f && at < distance)
          add(amount, parallelogram_pdf(at + before, -dot(parallelogram.normal, along)));
        break;
      }
      case Kind::sphere: {
        const float height = cap_of_sphere(from - before * along);
        if (!(height > 0.0f)) break;
        const Vec3f way = position - from;
        const float middle = dot(way, along);
        const Vec3f aside = way - middle * along;
        if (middle > -before && dot(aside, aside) <= radius * radius
            && distance_to_sphere(way, along, before) < distance)
          add(amount, cone_pdf(height));
        break;
      }
    }
  }

 private:
  TYN_HD static float cone_pdf(float height) {
    return min(1.0f / (2.0f * pi * height), highest_pdf);
  }
  TYN_HD float parallelogram_pdf(float distance, float cosine) const {
    return min(distance / parallelogram.area * (distance / cosine), highest_pdf);
  }
  /// The height of the cap of directions in which `p` sees the sphere; 0 from within.
  TYN_HD float cap_of_sphere(Vec3f p) const {
    const Vec3f way = position - p;
    const float square = radius * radius / max(dot(way, way), 1e-30f);  // of the half angle's sine
    return square < 1.0f ? square / (1.0f + sqrt(1.0f - square)) : 0.0f;
  }
  TYN_HD float distance_to_sphere(Vec3f way, Vec3f along, float before = 0.0f) const {
    const float middle = dot(way, along);
    const Vec3f aside = way - middle * along;
    return max(middle - sqrt(max(radius * radius - dot(aside, aside), 0.0f)), -before);
  }
};

/// Those that rays may meet come first.
struct DirectLights {
  const DirectLight* lights = nullptr;
  int count = 0;

  /// Whether there are any to be asked.
  TYN_HD bool any_asked() const { return count > 0 && lights[count - 1].chance > 0.0f; }

  /// One of those, as seen from `p`. \param random a: choice of the light, b and c: point of it
  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    int chosen = 0;
    while (chosen + 1 < count
           && (lights[chosen].chance == 0.0f || random.a > lights[chosen].last_word))
      ++chosen;
    const DirectLight& light = lights[chosen];
    LightSample out = light.sample(p, random);
    out.irradiance = (1.0f / light.chance) * out.irradiance;
    out.pdf = light.chance * out.pdf;
    return out;
  }

  /// Whether rays can meet any: area lights, suns with an angle, environments.
  TYN_HD bool any_met() const { return count > 0 && lights[0].is_met(); }

  /// Calls add(radiance, pdf, group) for each light that the ray meets at less than `distance`;
  /// environments and suns where that is largest_float. \param direction unit \param add pdf as in
  /// LightSample, as seen from where the ray begins: `before` ahead of `from` [length]
  template <class Add>
  TYN_HD void meet(Vec3f from, Vec3f direction, float distance, Add&& add,
                   float before = 0.0f) const {
    for (int i = 0; i < count && lights[i].is_met(); ++i) {
      const DirectLight& light = lights[i];
      light.meet(
          from, direction, distance,
          [&](Vec3f radiance, float pdf) { add(radiance, light.chance * pdf, light.group); },
          before);
    }
  }
};

struct Photon {
  Ray ray;
  Vec3f weight;  ///< RGB, in units of the power of one photon
};

TYN_HD const Emitter& choose(const Lights& lights, std::uint32_t word) {
  int chosen = 0;
  while (chosen + 1 < lights.count && word > lights.emitters[chosen].last_word) ++chosen;
  return lights.emitters[chosen];
}

/// A line that passes two centres, the second one `distance` behind the first: that of a light and
/// that of the receivers. Where it passes the second one follows from where it passes the first and
/// from the angle between, not from positions: that holds for any distance.
struct Aim {
  Vec3f direction;  ///< unit
  Vec3f across;     ///< unit, at right angles to it: where angles turn a line at the second centre
  float sine, cosine;  ///< to the line through the centres

  /// \return how far a line through the first centre passes from the second one.
  TYN_HD Vec3f shift(float distance) const { return (distance * sine) * across; }
};

/// A uniform direction of the cone about `axis`, the unit vector from the first centre to the
/// second. See direction_in_cone().
TYN_HD Aim aim_in_cone(Vec3f axis, float height, float u, float v) {
  const float h = u * height, sine = sqrt(max(0.0f, h * (2.0f - h))), cosine = 1.0f - h;
  const SinCos phi = sin_cos_turn(v);
  return {normalize(to_frame_of(axis, {sine * phi.cos, sine * phi.sin, cosine})),
          normalize(to_frame_of(axis, {cosine * phi.cos, cosine * phi.sin, -sine})), sine, cosine};
}

/// The height of the cone of directions in which a sphere is seen; 2 from within.
TYN_HD float cone_of_sphere(float distance, float radius) {
  const float sine = distance > radius ? radius / distance : 1.0f;
  return sine < 1.0f ? sine * sine / (1.0f + sqrt(1.0f - sine * sine)) : 2.0f;
}

/// Event 0 of a photon; of weight 0 where a test against a bound fails, which shines nowhere.
/// \param first block (0, emission); `aim` block (0, aim) of its stream. Not for matter, which
/// emit_from_matter() asks.
TYN_HD Photon emit(const Emitter& light, const Box& box, RandomBlock first, RandomBlock aim) {
  Photon photon{{light.position, light.direction}, light.weight};
  const Receivers& receivers = light.receivers;
  const float u = uniform_symmetric(aim.a), v = uniform_symmetric(aim.b);
  Vec3f& direction = photon.ray.direction;
  const auto require = [&](float value) {
    TYN_EXPECT(value <= light.bound);
    if (!(uniform(aim.d) * light.bound < value)) photon.weight = {0, 0, 0};
  };
  const auto fall_on_faces = [&] {
    const Vec3f areas = lit_areas(box, direction);
    require(areas.x + areas.y + areas.z);
    photon.ray.origin =
        lit_point(box, direction, areas, uniform(first.b), uniform(first.c), uniform(aim.c));
  };
  // The line passes the receivers' centre at `offset` and starts `start` beyond that point, or
  // where it meets their sphere: there positions have the digits that the medium needs.
  const auto start_from = [&](Vec3f offset, float start) {
    photon.ray.origin = receivers.center + offset + max(start, -receivers.radius) * direction;
  };
  // A line through a uniform point that the receivers show. \return where it passes the light's
  // centre.
  const auto trace_back = [&](const Aim& line) {
    Box shown;
    shown.extent = receivers.size;
    direction = line.direction;
    const Vec3f areas = lit_areas(shown, direction);
    require(areas.x + areas.y + areas.z);
    const Vec3f p =
        receivers.low - receivers.center
        + lit_point(shown, direction, areas, uniform(first.b), uniform(first.c), uniform(aim.c));
    return p - dot(p, direction) * direction - line.shift(light.distance);
  };
  switch (light.kind) {
    case Emitter::Kind::point:
    case Emitter::Kind::spot: {
      const Aim line = aim_in_cone(light.direction, light.cone_height, u, v);
      direction = line.direction;
      if (light.is_far) start_from(line.shift(light.distance), -largest_float);
      if (light.kind == Emitter::Kind::spot) require(light.spot.falloff(light.axis, direction));
      break;
    }
    case Emitter::Kind::disc: {
      const SinCos turn = sin_cos_turn(v);
      const float r = light.radius * sqrt(u);
      const Vec3f across = to_frame_of(normalize(light.direction), {r * turn.cos, r * turn.sin, 0});
      direction = normalize(light.direction + across);
      break;
    }
    case Emitter::Kind::beam:
      photon.ray.origin = point_on_face(box, light.face, uniform(first.b), uniform(first.c));
      break;
    case Emitter::Kind::sun:
      direction = direction_in_cone(light.direction, light.cone_height, u, v);
      fall_on_faces();
      break;
    case Emitter::Kind::environment:
      photon.ray.origin = point_on_face(box, light.face, uniform(first.b), uniform(first.c));
      direction = direction_around(inward_normal(light.face), sqrt(u), v);
      break;
    case Emitter::Kind::sky: {
      const SkyImage::Sample sample = light.sky.sample(aim.a, aim.b);
      direction = -1.0f * sample.direction;
      photon.weight = {light.weight.x * min(sample.share.x, 1.0f),
                       light.weight.y * min(sample.share.y, 1.0f),
                       light.weight.z * min(sample.share.z, 1.0f)};
      fall_on_faces();
      break;
    }
    case Emitter::Kind::parallelogram: {
      const Parallelogram& shape = light.parallelogram;
      if (light.is_traced_back) {
        const Aim line = aim_in_cone(light.direction, light.cone_height, u, v);
        const Vec3f offset = trace_back(line);
        const float cosine = dot(shape.normal, direction);
        const float start = -dot(shape.normal, offset) / max(cosine, 1e-30f);
        const bool meets = cosine > 0.0f && shape.holds(offset, direction, start);
        if (!meets) photon.weight = {0, 0, 0};
        start_from(offset + line.shift(light.distance),
                   meets ? start - light.distance * line.cosine : 0.0f);
      } else if (light.bound > 0.0f) {
        const Vec3f way = receivers.center - shape.point(uniform(first.b), uniform(first.c));
        const float distance = length(way), height = cone_of_sphere(distance, receivers.radius);
        const Aim line = aim_in_cone((1.0f / max(distance, 1e-30f)) * way, height, u, v);
        direction = line.direction;
        require(height * max(dot(direction, shape.normal), 0.0f));
        start_from(line.shift(distance), -distance * line.cosine);
      } else {
        photon.ray.origin = shape.point(uniform(first.b), uniform(first.c));
        direction = direction_around(shape.normal, sqrt(u), v);
      }
      break;
    }
    case Emitter::Kind::sphere: {
      // The sphere shows a disc to each direction, as bright as to any other.
      const Aim line = aim_in_cone(light.direction, light.cone_height, u, v);
      direction = line.direction;
      Vec3f offset;
      float square;  // of its length over the radius
      if (light.is_traced_back) {
        offset = trace_back(line);
        square = dot(offset, offset) / (light.radius * light.radius);
        if (!(square < 1.0f)) photon.weight = {0, 0, 0};
      } else {
        const SinCos turn = sin_cos_turn(uniform(first.c));
        square = uniform(first.b);
        const float r = light.radius * sqrt(square);
        offset = (r * turn.cos) * line.across + (r * turn.sin) * cross(line.direction, line.across);
      }
      start_from(offset + line.shift(light.distance),
                 light.radius * sqrt(max(1.0f - square, 0.0f)) - light.distance * line.cosine);
      break;
    }
    case Emitter::Kind::matter:
      break;
  }
  return photon;
}
TYN_HD Photon emit(const Lights& lights, const Box& box, RandomBlock first, RandomBlock aim) {
  return emit(choose(lights, first.a), box, first, aim);
}

/// The same of a light far away that is aimed at a clump: as if that were all there is. A line that
/// passes through several could come of each of them, and has its share of their power. It starts
/// where it enters the first.
TYN_HD Photon emit_at_clump(const Emitter& light, const Lights& lights, RandomBlock first,
                            RandomBlock aim) {
  const Clump& own = lights.clumps[light.clump];
  Box shown;
  shown.extent = own.size;
  Photon photon = emit(light, shown, first, aim);
  const Vec3f from = photon.ray.origin + own.low;
  float start = 0.0f;
  int met = 1;
  for (int i = 0; i < lights.clump_count; ++i) {
    float enters;
    if (i == light.clump || !lights.clumps[i].meets(from, photon.ray.direction, enters)) continue;
    ++met;
    start = min(start, enters);
  }
  photon.ray.origin = from + start * photon.ray.direction;
  photon.weight = (1.0f / static_cast<float>(met)) * photon.weight;
  return photon;
}

/// Event 0 of a photon from matter that shines: a cell in proportion to its bound, an even point of
/// it, and a test of what shines there against the bound. \return of weight 0 where that fails.
template <class Medium>
TYN_HD Photon emit_from_matter(const Emitter& light, const Medium& medium, RandomBlock first,
                               RandomBlock aim, RandomBlock place) {
  const int cell = light.cells.choose(first.b);
  const Vec3f p = light.cells.point(cell, uniform(place.a), uniform(place.b), uniform(place.c));
  const float u = uniform_symmetric(aim.a), v = uniform_symmetric(aim.b);
  Photon photon{{p, direction_around({0, 0, 1}, 1.0f - 2.0f * u, v)}, {0, 0, 0}};
  const auto& component = medium.component(light.component);
  TreeNodes nodes;
  const float sigma_t = component.sigma_t(p, nodes);
  if (!(sigma_t > 0.0f)) return photon;
  const Vec3f radiance = component.emitted(p);
  const float most = largest(radiance), bound = light.cells.bound(cell);
  TYN_EXPECT(sigma_t * most <= bound);
  if (uniform(place.d) * bound < sigma_t * most) photon.weight = (1.0f / most) * radiance;
  return photon;
}

}  // namespace tyndall
