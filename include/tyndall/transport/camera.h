/// \file
/// Cameras: from a sample of the picture to the ray that gathers it.
#pragma once

#include "tyndall/transport/walk.h"

namespace tyndall {

/// The pixels that are rendered, a rectangle of the whole picture's. A sample has the random
/// numbers of the whole picture's, so that a part of a picture has its bits.
struct CropWindow {
  int whole_width = 1, whole_height = 1;  ///< [pixel]
  int left = 0, top = 0;
  int width = 1, height = 1;

  TYN_HD std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }

  /// \return the stream of a sample of a pixel of the window: the same of the whole picture.
  TYN_HD std::uint64_t stream(std::uint64_t pixel, std::uint64_t sample) const {
    const std::uint64_t columns = static_cast<std::uint64_t>(width);
    const std::uint64_t row = pixel / columns + static_cast<std::uint64_t>(top);
    const std::uint64_t column = pixel % columns + static_cast<std::uint64_t>(left);
    const std::uint64_t rows = sample * static_cast<std::uint64_t>(whole_height) + row;
    return rows * static_cast<std::uint64_t>(whole_width) + column;
  }

  // Of the whole picture:
  TYN_HD int column(std::uint64_t stream) const {
    return static_cast<int>(stream % static_cast<std::uint64_t>(whole_width));
  }
  TYN_HD int row(std::uint64_t stream) const {
    return static_cast<int>(stream / static_cast<std::uint64_t>(whole_width)
                            % static_cast<std::uint64_t>(whole_height));
  }

  /// \return the pixel of the window that a stream belongs to.
  TYN_HD std::uint64_t pixel(std::uint64_t stream) const {
    return static_cast<std::uint64_t>(row(stream) - top) * static_cast<std::uint64_t>(width)
           + static_cast<std::uint64_t>(column(stream) - left);
  }
};

/// Where the samples of a pixel lie: distributed as its filter, each of weight 1 and of this pixel
/// alone. The same across and down.
struct PixelFilter {
  const float* quantiles = nullptr;  ///< [intervals + 1] from the pixel's edge on [pixel], evenly
                                     ///< spaced in probability
  int intervals = 0;

  TYN_HD float place(float u) const {
    const float x = u * static_cast<float>(intervals);
    const int i = clamp(static_cast<int>(x), 0, intervals - 1);
    return lerp(quantiles[i], quantiles[i + 1], x - static_cast<float>(i));
  }
};

/// Points (u, v) of the picture run from 0 to 1, from the top left.
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
  Vec3f up{0, 1, 0};        ///< orthographic: half the picture [length]
  Vec3f lens_x{0, 0, 0};    ///< perspective: radius of the lens along `right` [length]
  Vec3f lens_y{0, 0, 0};    ///< and along `up`
  float inverse_focus = 0;  ///< [1/length] over the distance of the plane in focus; 0: a
                            ///< pinhole, all is in focus
  PixelFilter filter;
  CropWindow window;

  /// The ray of the pixel sample that `random` belongs to. \param first its block (0, emission)
  TYN_HD Ray sample(const RandomStream& random, RandomBlock first) const {
    const float column = static_cast<float>(window.column(random.index));
    const float row = static_cast<float>(window.row(random.index));
    const float u =
        (column + filter.place(uniform(first.a))) / static_cast<float>(window.whole_width);
    const float v =
        (row + filter.place(uniform(first.b))) / static_cast<float>(window.whole_height);
    if (inverse_focus == 0.0f) return ray(u, v);
    const RandomBlock aim = random.block(0, Purpose::aim);
    return ray_through_lens(u, v, uniform(aim.a), uniform(aim.b));
  }

  /// Through the middle of a pixel of the window.
  TYN_HD Ray middle(std::uint64_t pixel) const {
    const std::uint64_t stream = window.stream(pixel, 0);
    const float column = static_cast<float>(window.column(stream)) + 0.5f;
    const float row = static_cast<float>(window.row(stream)) + 0.5f;
    return ray(column / static_cast<float>(window.whole_width),
               row / static_cast<float>(window.whole_height));
  }

  /// Through the middle of the lens, if there is one.
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

  /// Through a point of a thin lens, even for even (a, b) in (0, 1): where the ray through its
  /// middle meets the plane in focus, this one does.
  TYN_HD Ray ray_through_lens(float u, float v, float a, float b) const {
    const SinCos turn = sin_cos_turn(b);
    const float radius = sqrt(a);
    const Vec3f offset = radius * turn.cos * lens_x + radius * turn.sin * lens_y;
    const Vec3f middle = forward + (2.0f * u - 1.0f) * right + (1.0f - 2.0f * v) * up;
    return {position + offset, normalize(middle - inverse_focus * offset)};
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    filter.quantiles = copy(filter.quantiles, static_cast<std::size_t>(filter.intervals) + 1);
  }
};

}  // namespace tyndall
