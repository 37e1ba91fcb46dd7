/// \file
/// Environment lights: radiance from all directions, constant or from an image.
#pragma once

#include "tyndall/transport/lights/light_parts.h"

namespace tyndall::lights {

/// Constant radiance from all directions. Its photons enter through one face of the box.
struct ConstantEnvironment {
  static constexpr bool is_delta = false, is_distant = true;

  Vec3f radiance{0, 0, 0};  ///< [W/(area sr)]
  Face face = 0;

  /// The direction is cosine-distributed.
  TYN_HD Photon emit(const Box& box, RandomBlock first, RandomBlock aim) const {
    return {{point_on_face(box, face, uniform(first.b), uniform(first.c)),
             direction_around(inward_normal(face), sqrt(uniform_symmetric(aim.a)),
                              uniform_symmetric(aim.b))}};
  }

  TYN_HD LightSample sample(Vec3f, RandomBlock random) const {
    LightSample out{direction_in_cone({0, 0, 1}, 2.0f, uniform_symmetric(random.b),
                                      uniform_symmetric(random.c))};
    out.pdf = cone_pdf(2.0f);
    out.irradiance = (4.0f * pi) * radiance;
    return out;
  }

  TYN_HD LightHit intersect(const Ray&, float, float) const {
    return {true, radiance, cone_pdf(2.0f)};
  }
};

/// Radiance from an image in longitude and latitude. Its rows go from +y to -y. Seen from within
/// with +y up, the middle column is at +z, and the column a quarter to its left is at +x, unless
/// the image is rotated. Radiance is linear between the centres of texels, also across the ends of
/// a row, and constant beyond the centres of the first and the last row.
///
/// Directions are sampled by a table of integer weights: first a texel, then a point about its
/// centre from the tent of the interpolation, so that the pdf interpolates the weights. A weight is
/// at least the texel's largest channel times the largest sine of the polar angle within its tent,
/// in units of `unit`. So the radiance never exceeds the bound that the pdf is proportional to.
struct ImageEnvironment {
  static constexpr bool is_delta = false, is_distant = true;

  const Vec3f* texels = nullptr;        ///< [width height], from the top left
  const std::uint32_t* ends = nullptr;  ///< [width height] sums of the weights up to a texel
  int width = 0, height = 0;
  float shift = 0.5f;    ///< [turn] column at +z
  float unit = 0;        ///< radiance times sine at weight 1
  float irradiance = 0;  ///< integral of the bound of the radiance over all directions [W/area]
  Vec3f scale{1, 1, 1};  ///< of the image
  float area_bound = 0;  ///< of the open faces' projected area along any direction

  TYN_HD int count() const { return width * height; }

  TYN_HD Photon emit(const Box& box, RandomBlock first, RandomBlock aim) const {
    const Sample s = sample_image(aim.a, aim.b);
    Photon photon{{{0, 0, 0}, -1.0f * s.direction},
                  {min(s.fraction.x, 1.0f), min(s.fraction.y, 1.0f), min(s.fraction.z, 1.0f)}};
    start_on_faces(box, area_bound, first, aim, photon);
    return photon;
  }

  TYN_HD LightSample sample(Vec3f, RandomBlock random) const {
    const Sample s = sample_image(random.b, random.c);
    LightSample out{s.direction};
    out.pdf = min(s.pdf, highest_pdf);
    out.irradiance = irradiance * (s.fraction * scale);
    return out;
  }

  TYN_HD LightHit intersect(const Ray& ray, float, float) const {
    const Vec3f d = ray.direction;
    const float sine = sqrt(d.x * d.x + d.z * d.z);
    const Place place{fraction(shift - turn_of(d.z, d.x)), min(2.0f * turn_of(d.y, sine), 1.0f),
                      sine};
    return {true, scale * radiance(place), min(pdf(place, weight_at(place)), highest_pdf)};
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    texels = copy(texels, static_cast<std::size_t>(count()));
    ends = copy(ends, static_cast<std::size_t>(count()));
  }

 private:
  struct Place {
    float u, v;  ///< in [0, 1]: longitude and polar angle over the width and height
    float sine;  ///< of the polar angle
  };
  struct Sample {
    Vec3f direction;
    Vec3f fraction;  ///< radiance over its bound; times `irradiance`, radiance over pdf
    float pdf;       ///< [1/sr]
  };

  TYN_HD Sample sample_image(std::uint32_t texel, std::uint32_t offset) const {
    const int chosen = sample_discrete(ends, count(), texel);
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

  TYN_HD Vec3f radiance(Place place) const {
    const Square s = square(place);
    const auto row = [&](int j) {
      return (1.0f - s.x) * texels[j * width + s.i0] + s.x * texels[j * width + s.i1];
    };
    return (1.0f - s.y) * row(s.j0) + s.y * row(s.j1);
  }

  /// The four texels about a place, and the position between them.
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

  /// Samples the tent on (-1, 1). \param step one of 2^16 equally likely steps
  TYN_HD static float tent(float step) {
    const float s = (step + 0.5f) * (1.0f / 32768.0f);  // in (0, 2)
    return s < 1.0f ? sqrt(s) - 1.0f : 1.0f - sqrt(2.0f - s);
  }
  TYN_HD static float fraction(float x) { return x - floor(x); }
};

}  // namespace tyndall::lights
