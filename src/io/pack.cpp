// The only file outside the helper that uses zlib.
#include "io/pack.h"

#include <algorithm>
#include <limits>
#include <new>

#include <zlib.h>

#include "tyndall/render/error.h"

namespace tyndall::io {

std::string pack(std::string_view bytes, Packing packing) {
  const bool is_gzip = packing == Packing::gzip;
  z_stream stream{};
  if (deflateInit2(&stream, is_gzip ? Z_BEST_COMPRESSION : 6, Z_DEFLATED, is_gzip ? 15 + 16 : 15,
                   is_gzip ? 9 : 8, Z_DEFAULT_STRATEGY)
      != Z_OK)
    throw std::bad_alloc();
  std::string packed;
  try {
    packed.resize(deflateBound(&stream, bytes.size()));
  } catch (...) {
    deflateEnd(&stream);
    throw;
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  std::size_t in = bytes.size(), out = packed.size();
  int result = Z_OK;
  constexpr std::size_t most = std::numeric_limits<uInt>::max();
  do {  // zlib's counters have 32 bits
    if (stream.avail_in == 0) in -= stream.avail_in = static_cast<uInt>(std::min(in, most));
    if (stream.avail_out == 0) out -= stream.avail_out = static_cast<uInt>(std::min(out, most));
    result = deflate(&stream, in == 0 ? Z_FINISH : Z_NO_FLUSH);
  } while (result == Z_OK);
  packed.resize(packed.size() - out - stream.avail_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw Error(ExitCode::internal, "zlib did not pack the data");
  return packed;
}

std::uint32_t crc(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace tyndall::io
