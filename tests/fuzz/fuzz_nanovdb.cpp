// NanoVDB buffers as the helper returns them; a damaged file may have corrupted the helper. Even
// the smallest buffer has 300 kB, mostly zeros, so an input is a list of changes to a ball: offset
// (4 bytes), count (1), bytes.
#include <algorithm>
#include <cstring>

#include <nanovdb/util/Primitives.h>

#include "fuzz/fuzz.h"
#include "tyndall/render/volume.h"

namespace {

const nanovdb::GridHandle<>& ball() {
  static const auto handle = nanovdb::createFogVolumeSphere<float>(3.0);
  return handle;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* changes, std::size_t count) {
  using namespace tyndall;
  std::size_t size = ball().size();
  const std::shared_ptr<std::byte> buffer(
      static_cast<std::byte*>(std::aligned_alloc(32, (size + 31) / 32 * 32)), std::free);
  std::memcpy(buffer.get(), ball().data(), size);
  while (count >= 5) {
    std::uint32_t at = 0;
    std::memcpy(&at, changes, 4);
    const std::size_t many = std::min<std::size_t>(changes[4] % 32 + 1, count - 5);
    changes += 5, count -= 5;
    // The headers of the grid lie at its beginning, which gets half of the changes.
    const std::size_t place = at % 2 == 0 ? at / 2 % 1000 : at / 2 % size;
    std::memcpy(buffer.get() + place, changes, std::min(many, size - place));
    changes += many, count -= many;
  }
  if (count > 0) size -= changes[0];  // truncates the buffer
  try {
    const Volume volume(buffer, size, 1);
    TreeNodes nodes;
    if (!volume.is_color()) {
      const SparseGrid grid = volume.view();
      for (int i = 0; i < 64; ++i) {  // inside and outside its box
        const auto at = [&](int axis) {
          return grid.extent[axis] * (static_cast<float>((i >> (2 * axis)) % 4) / 2.0f - 0.25f);
        };
        static_cast<void>(grid.density({at(0), at(1), at(2)}, nodes));
      }
    }
    active_box(volume, volume.to_world());
  } catch (const DamagedVolume& damage) {
    if (damage.what()[0] == '\0') std::abort();
  }
  return 0;
}
