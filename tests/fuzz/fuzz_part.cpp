// Parts of renders. Half of the inputs get checksums that are right, or nothing else would ever be
// looked at.
#include "io/part_file.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>

#include "fuzz/fuzz.h"
#include "tyndall/render/render.h"

namespace {

/// Makes each chunk's checksum that of its bytes.
std::string with_checksums(std::string bytes) {
  for (std::size_t at = 12; at + 40 <= bytes.size();) {
    std::uint64_t stored = 0;
    std::memcpy(&stored, &bytes[at + 24], 8);
    if (stored > bytes.size() - at - 40) break;
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    XXH3_64bits_update(&state, &bytes[at], 32);
    XXH3_64bits_update(&state, &bytes[at + 40], stored);
    const std::uint64_t sum = XXH3_64bits_digest(&state);
    std::memcpy(&bytes[at + 32], &sum, 8);
    at += 40 + stored;
  }
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace tyndall;
  return fuzz::expect_an_error_at_most([&] {
    std::string input(reinterpret_cast<const char*>(bytes), size);
    if (size % 2 == 0) input = with_checksums(std::move(input));
    const Partial part = io::parse_part(input, "part", std::uint64_t{256} << 20);
    if (!part.film.pixels.empty()) develop(part);
    hash_tallies(part);
  });
}
