#include "tyndall/render/image.h"

#include <utility>

#include "tyndall/base/hash.h"

namespace tyndall {

Image::Image(int width, int height, std::vector<Vec3f> texels)
    : width_(width), height_(height), texels_(std::move(texels)) {
  Hasher hasher;
  hasher.add(static_cast<std::uint64_t>(width));
  hasher.add(static_cast<std::uint64_t>(height));
  for (Vec3f& texel : texels_) {
    bool good = true;
    for (float* channel : {&texel.x, &texel.y, &texel.z}) {
      if (!(*channel >= 0.0f && *channel <= largest_texel)) {
        *channel = *channel > largest_texel ? largest_texel : 0.0f;
        good = false;
      }
      largest_ = max(largest_, *channel);
      hasher.add(float_bits(*channel + 0.0f));  // -0 is 0
    }
    if (!good) ++mended_;
  }
  hash_ = hasher.value();
}

}  // namespace tyndall
