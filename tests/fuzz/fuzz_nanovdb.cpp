// NanoVDB buffers, as the process that reads volumes hands them over, which may itself have been
// led astray by a file.
#include <cstring>

#include "fuzz/fuzz.h"
#include "tyndall/render/volume.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace tyndall;
  if (size == 0 || size > (std::size_t{64} << 20)) return 0;
  const std::size_t room = (size + 31) / 32 * 32;
  const std::shared_ptr<std::byte> buffer(static_cast<std::byte*>(std::aligned_alloc(32, room)),
                                          std::free);
  std::memset(buffer.get(), 0, room);
  std::memcpy(buffer.get(), bytes, size);
  try {
    const Volume volume(buffer, size, 1);
    // Look-ups everywhere, in and out of its box.
    const auto look = [&](const auto& view) {
      TreeNodes nodes;
      float sum = 0;
      for (int i = 0; i < 64; ++i) {
        const auto at = [&](int axis) {
          const auto extent = static_cast<float>(view.extent[axis]);
          return extent * (static_cast<float>((i >> (2 * axis)) % 4) / 2.0f - 0.25f);
        };
        sum += view.density(Vec3f{at(0), at(1), at(2)}, nodes);
      }
      return sum;
    };
    if (!volume.is_color()) look(volume.view());
    active_box(volume, volume.to_world());
  } catch (const DamagedVolume& damage) {
    if (damage.what()[0] == '\0') std::abort();
  }
  return 0;
}
