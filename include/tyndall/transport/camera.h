/// \file
/// Cameras: from a sample of the image to its ray.
#pragma once

#include "tyndall/transport/walk.h"

namespace tyndall {

/// The crop window: the rectangle of the image that is rendered. Samples have the random numbers of
/// the whole image, so that a crop has the same bits.
struct CropWindow {
  int whole_width = 1, whole_height = 1;  ///< [pixel]
  int left = 0, top = 0;
  int width = 1, height = 1;

  TYN_HD std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }

  /// \return the random stream of a sample of a pixel of the window: that of the whole image.
  TYN_HD std::uint64_t stream(std::uint64_t pixel, std::uint64_t sample) const {
    const std::uint64_t columns = static_cast<std::uint64_t>(width);
    const std::uint64_t row = pixel / columns + static_cast<std::uint64_t>(top);
    const std::uint64_t column = pixel % columns + static_cast<std::uint64_t>(left);
    const std::uint64_t rows = sample * static_cast<std::uint64_t>(whole_height) + row;
    return rows * static_cast<std::uint64_t>(whole_width) + column;
  }

  // The pixel of a stream, in the whole image:
  TYN_HD int column(std::uint64_t stream) const {
    return static_cast<int>(stream % static_cast<std::uint64_t>(whole_width));
  }
  TYN_HD int row(std::uint64_t stream) const {
    return static_cast<int>(stream / static_cast<std::uint64_t>(whole_width)
                            % static_cast<std::uint64_t>(whole_height));
  }

  /// \return the pixel of the window for a stream.
  TYN_HD std::uint64_t pixel(std::uint64_t stream) const {
    return static_cast<std::uint64_t>(row(stream) - top) * static_cast<std::uint64_t>(width)
           + static_cast<std::uint64_t>(column(stream) - left);
  }
};

/// Filter importance sampling: a pixel's samples are distributed as its filter. Each has weight 1
/// and belongs to this pixel alone. The distribution is the same across and down.
struct PixelFilter {
  const float* quantiles = nullptr;  ///< [intervals + 1] from the pixel's edge [pixel], equally
                                     ///< spaced in probability
  int intervals = 0;

  TYN_HD float place(float u) const {
    const float x = u * static_cast<float>(intervals);
    const int i = clamp(static_cast<int>(x), 0, intervals - 1);
    return lerp(quantiles[i], quantiles[i + 1], x - static_cast<float>(i));
  }
};

/// The surface where the rays of a distant camera begin, next to the medium, since floats lose its
/// digits at the camera. It is a plane across the view, or a sphere about a spherical camera, and
/// all of the medium lies beyond. Positions on it are relative to one pixel, to keep their digits,
/// too.
struct FarView {
  float distance = 0;    ///< from the camera, along the view; spherical: its radius [length]
  Vec3f point{0, 0, 0};  ///< where the ray through (column + x, row + y) begins
  int column = 0, row = 0;
  float x = 0, y = 0;     ///< in [0, 1)
  Vec3f across{0, 0, 0};  ///< from one pixel to the next; not for spherical cameras [length]
  Vec3f down{0, 0, 0};
  float blur = 0;  ///< fraction of an offset on the lens that is left there
};

/// A camera. Points (u, v) of the image run from 0 to 1, from the top left.
struct Camera {
  enum class Kind {
    perspective,   ///< along forward + (2u - 1) right + (1 - 2v) up
    orthographic,  ///< along forward, from position + (2u - 1) right + (1 - 2v) up
    spherical,     ///< all directions: u is the longitude, v the latitude from `up` downwards
  };

  Kind kind = Kind::perspective;
  Vec3f position{0, 0, 0};
  Vec3f forward{0, 0, 1};   ///< unit length; `right` and `up` are perpendicular to it
  Vec3f right{1, 0, 0};     ///< perspective: times the tangent of half the angle of view;
  Vec3f up{0, 1, 0};        ///< orthographic: half the image [length]
  Vec3f lens_x{0, 0, 0};    ///< perspective: radius of the lens along `right` [length]
  Vec3f lens_y{0, 0, 0};    ///< and along `up`
  float inverse_focus = 0;  ///< [1/length] 1 over the distance of the plane in focus; 0: a
                            ///< pinhole, all is in focus
  PixelFilter filter;
  CropWindow window;
  bool is_far = false;  ///< rays begin at `far_view`
  FarView far_view;

  /// The ray of the pixel sample with stream `random`. \param first its block (0, emission)
  TYN_HD Ray sample(const RandomStream& random, RandomBlock first) const {
    const Place place{window.column(random.index), window.row(random.index),
                      filter.place(uniform(first.a)), filter.place(uniform(first.b))};
    if (inverse_focus == 0.0f) return ray(place);
    const RandomBlock aim = random.block(0, Purpose::aim);
    const Vec3f offset = on_lens(uniform(aim.a), uniform(aim.b));
    Ray through = ray_through_lens(u(place), v(place), offset);
    if (is_far) through.origin = far_origin(place) + far_view.blur * offset;
    return through;
  }

  /// The ray through the middle of a pixel of the window.
  TYN_HD Ray middle(std::uint64_t pixel) const {
    const std::uint64_t stream = window.stream(pixel, 0);
    return ray(Place{window.column(stream), window.row(stream), 0.5f, 0.5f});
  }

  /// \return the distance from the camera (or its lens) to the origin of its rays [length]
  TYN_HD float before(Vec3f direction) const {
    if (!is_far) return 0.0f;
    return kind == Kind::spherical ? far_view.distance
                                   : divide(far_view.distance, dot(direction, forward));
  }

  /// The ray at (u, v), through the middle of the lens, if there is one.
  TYN_HD Ray ray(float u, float v) const {
    const float x = 2.0f * u - 1.0f, y = 1.0f - 2.0f * v;
    switch (kind) {
      case Kind::perspective:
        break;
      case Kind::orthographic:
        return {position + x * right + y * up, forward};
      case Kind::spherical: {
        const SinCos longitude = sin_cos_turn(u), latitude = sin_cos_turn(0.5f * v);
        const Vec3f across = -longitude.cos * forward - longitude.sin * right;
        return {position, normalize(latitude.sin * across + latitude.cos * up)};
      }
    }
    return {position, normalize(forward + x * right + y * up)};
  }

  /// The ray through a point of a thin lens, uniform for uniform (a, b) in (0, 1). It hits the
  /// plane in focus at the same point as the ray through the middle of the lens.
  TYN_HD Ray ray_through_lens(float u, float v, float a, float b) const {
    return ray_through_lens(u, v, on_lens(a, b));
  }
  TYN_HD Ray ray_through_lens(float u, float v, Vec3f offset) const {
    const Vec3f middle = forward + (2.0f * u - 1.0f) * right + (1.0f - 2.0f * v) * up;
    return {position + offset, normalize(middle - inverse_focus * offset)};
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    filter.quantiles = copy(filter.quantiles, static_cast<std::size_t>(filter.intervals) + 1);
  }

 private:
  /// A pixel of the whole image, and a point relative to its top left [pixel].
  struct Place {
    int column, row;
    float x, y;
  };
  TYN_HD float u(const Place& p) const {
    return (static_cast<float>(p.column) + p.x) / static_cast<float>(window.whole_width);
  }
  TYN_HD float v(const Place& p) const {
    return (static_cast<float>(p.row) + p.y) / static_cast<float>(window.whole_height);
  }

  TYN_HD Ray ray(const Place& p) const {
    Ray r = ray(u(p), v(p));
    if (is_far) r.origin = far_origin(p);
    return r;
  }

  TYN_HD Vec3f on_lens(float a, float b) const {
    const SinCos turn = sin_cos_turn(b);
    const float radius = sqrt(a);
    return radius * turn.cos * lens_x + radius * turn.sin * lens_y;
  }

  /// The point where the ray through the middle of the lens hits the plane or sphere of `far_view`.
  TYN_HD Vec3f far_origin(const Place& p) const {
    const float x = static_cast<float>(p.column - far_view.column) + (p.x - far_view.x);
    const float y = static_cast<float>(p.row - far_view.row) + (p.y - far_view.y);
    if (kind != Kind::spherical) return far_view.point + x * far_view.across + y * far_view.down;
    // Differences of sines and cosines as products keep their digits for small angles.
    const Place from{far_view.column, far_view.row, far_view.x, far_view.y};
    const float u0 = u(from), du = 0.5f * x / static_cast<float>(window.whole_width),
                v0 = 0.5f * v(from), dv = 0.25f * y / static_cast<float>(window.whole_height);
    const SinCos half_u = sin_cos_turn(du), mean_u = sin_cos_turn(u0 + du),
                 end_u = sin_cos_turn(u0 + 2.0f * du);
    const SinCos half_v = sin_cos_turn(dv), mean_v = sin_cos_turn(v0 + dv),
                 begin_v = sin_cos_turn(v0);
    const Vec3f outwards = -end_u.cos * forward - end_u.sin * right;
    const Vec3f sidewards = mean_u.sin * forward - mean_u.cos * right;
    const Vec3f half = half_v.sin * (mean_v.cos * outwards - mean_v.sin * up)
                       + begin_v.sin * half_u.sin * sidewards;
    return far_view.point + 2.0f * far_view.distance * half;
  }
};

}  // namespace tyndall
