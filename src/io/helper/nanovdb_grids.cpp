#include "io/helper/nanovdb_grids.h"

#include <algorithm>
#include <map>
#include <string>

#include <blosc.h>
#include <fmt/format.h>
#include <nanovdb/util/IO.h>
#include <zlib.h>

#include "io/helper/grid_memory.h"
#include "io/helper/input.h"

namespace tyndall::io {
namespace {

std::string type_name(nanovdb::GridType type) {
  using nanovdb::GridType;
  switch (type) {
    case GridType::Fp4:
      return "fp4";
    case GridType::Fp8:
      return "fp8";
    case GridType::Fp16:
      return "fp16";
    case GridType::FpN:
      return "fpn";
    case GridType::Vec3f:
      return "vec3s";
    case GridType::Vec3d:
      return "vec3d (NanoVDB)";
    case GridType::Double:
      return "double (NanoVDB)";
    default:
      return type < GridType::End ? nanovdb::toStr(type)
                                  : fmt::format("type {}", static_cast<unsigned>(type));
  }
}

nanovdb::io::Header read_header(std::uint64_t at) {
  const auto header = read_value<nanovdb::io::Header>(at);
  // Some writers use another digit in the last byte.
  if ((header.magic ^ NANOVDB_MAGIC_NUMBER) << 8 != 0) damaged("a segment without a header");
  const auto version = header.version.getMajor();
  if (version != NANOVDB_MAJOR_VERSION_NUMBER)
    throw Failure{error_format, fmt::format("NanoVDB version {}; this build reads {}", version,
                                            NANOVDB_MAJOR_VERSION_NUMBER)};
  return header;
}

}  // namespace

NanoFile::NanoFile() {
  const std::uint64_t end = input_size();
  std::map<std::string, int> known;
  for (std::uint64_t at = 0; at < end;) {
    const nanovdb::io::Header header = read_header(at);
    at += sizeof header;
    const std::size_t first = places_.size();
    for (int i = 0; i < header.gridCount; ++i) {
      const auto meta = read_value<nanovdb::io::MetaData>(at);
      at += sizeof meta;
      if (meta.nameSize > end - std::min(end, at)) damaged("a name extends beyond its end");
      std::string name(meta.nameSize, '\0');
      read_at(at, name.data(), name.size());
      at += name.size();
      name = name.c_str();
      name = name.substr(0, longest_name);
      const int repeat = known[name]++;
      Json d;
      d["unique_name"] = repeat == 0 ? name : fmt::format("{}[{}]", name, repeat);
      d["name"] = name;
      d["type"] = type_name(meta.gridType);
      d["class"] = meta.gridClass < nanovdb::GridClass::End ? nanovdb::toStr(meta.gridClass) : "?";
      d["voxels"] = meta.voxelCount;
      grids_.push_back(d);
      places_.push_back(
          {static_cast<std::uint16_t>(header.codec), 0, meta.fileSize, meta.gridSize});
    }
    for (std::size_t i = first; i < places_.size(); ++i) {
      if (places_[i].file_size > end - std::min(end, at)) damaged("its end is missing");
      places_[i].at = at;
      at += places_[i].file_size;
    }
  }
}

/// \return a compressed chunk, which is stored after its length.
std::string NanoFile::chunk(const Place& grid, std::uint64_t at) {
  const std::uint64_t end = grid.at + grid.file_size;
  if (end - at < sizeof(std::uint64_t)) damaged("a part of it is missing");
  const auto size = read_value<std::uint64_t>(at);
  if (size > end - at - sizeof(std::uint64_t)) damaged("a part of it is missing");
  std::string packed(size, '\0');
  read_at(at + sizeof(std::uint64_t), packed.data(), size);
  return packed;
}

Json NanoFile::load(std::size_t i) const {
  const Place& grid = places_[i];
  GridBuffer buffer(grid.size);
  if (grid.size == 0) damaged("an empty buffer");
  if (grid.codec == 0) {
    if (grid.file_size < grid.size) damaged("shorter than its header claims");
    read_at(grid.at, buffer.data(), grid.size);
  } else if (grid.codec == 1) {
    const std::string packed = chunk(grid, grid.at);
    uLongf size = grid.size;
    if (::uncompress(buffer.data(), &size, reinterpret_cast<const Bytef*>(packed.data()),
                     packed.size())
            != Z_OK
        || size != grid.size)
      damaged("its zipped data cannot be unpacked");
  } else if (grid.codec == 2) {
    constexpr std::uint64_t most = 1u << 30;
    std::uint64_t at = grid.at;
    for (std::uint64_t done = 0; done < grid.size;) {
      const std::string packed = chunk(grid, at);
      const std::uint64_t wanted = std::min(most, grid.size - done);
      std::size_t size = 0;
      if (::blosc_cbuffer_validate(packed.data(), packed.size(), &size) != 0 || size != wanted
          || ::blosc_decompress_ctx(packed.data(), buffer.data() + done, wanted, 1)
                 != static_cast<int>(wanted))
        damaged("its Blosc data cannot be unpacked");
      done += wanted;
      at += sizeof(std::uint64_t) + packed.size();
    }
  } else {
    throw Failure{error_format, fmt::format("packed by method {}, unknown here", grid.codec)};
  }
  return {{"checksum", checksum(buffer.data(), buffer.size())}, {"grid_bytes", buffer.size()}};
}

}  // namespace tyndall::io
