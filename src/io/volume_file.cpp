#include "io/volume_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/helper/protocol.h"
#include "io/json_text.h"
#include "io/reader_process.h"
#include "tyndall/scene/limits.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// ---- Messages about the helper's reports

std::string quoted_whole(const std::string& name) {
  return Json(name).dump(-1, ' ', false, Json::error_handler_t::replace);
}
std::string quoted(const std::string& name) { return quoted_whole(cut(name)); }

/// "density" (float, fog volume, 4224 voxels), ...
std::string listed(const Json& grids) {
  std::string text;
  std::size_t shown = 0;
  for (const Json& grid : grids) {
    if (++shown > 20) return text + fmt::format(", and {} more", grids.size() - 20);
    text += text.empty() ? "" : ", ";
    text += quoted(grid.value("unique_name", "")) + " (" + cut(grid.value("type", "?"), 30);
    if (const std::string name = grid.value("class", ""); !name.empty() && name != "unknown")
      text += ", " + name;
    if (grid.contains("voxels"))
      text += fmt::format(", {} voxels", grid["voxels"].get<std::uint64_t>());
    text += ")";
  }
  return text;
}

/// \return the edit distance (Levenshtein) of two names, ignoring the case of ASCII letters.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (small(a[i]) == small(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

/// \return advice which grid to write in the scene: the one with the name nearest to `wanted`, or
/// else the first numeric one.
std::string remedy(const Json& grids, const std::string& wanted) {
  constexpr std::size_t longest = 200;  // of names that are compared or shown in full
  const Json* best = nullptr;
  std::size_t fewest = wanted.size() / 3 + 1;
  for (const Json& grid : grids) {
    const std::string type = grid.value("type", ""), name = grid.value("name", "");
    if ((!is_numeric(type) && !is_color(type)) || std::max(name.size(), wanted.size()) > longest)
      continue;
    const std::size_t distance = edit_distance(name, wanted);
    if (distance < fewest || (distance == fewest && best == nullptr))
      best = &grid, fewest = distance;
  }
  for (const Json& grid : grids)
    if (best == nullptr && is_numeric(grid.value("type", ""))) best = &grid;
  if (best == nullptr) return "; none of them can be a density (a grid of floats)";
  const std::string name = best->value("unique_name", "");
  if (name.size() > longest)
    return fmt::format("; write \"grid\" and the whole name, of {} bytes", name.size());
  return fmt::format("; write \"grid\": {}", quoted_whole(name));
}

/// \param wanted the grid's name
[[noreturn]] void fail_as_reported(const std::string& path, const Json& report,
                                   const std::string& wanted) {
  const std::string kind = report.value("error", ""), message = report.value("message", "");
  const char* format = fs::path(path).extension() == ".nvdb" ? "NanoVDB" : "VDB";
  if (kind == error_format) {
    if (message.find("version") != message.npos)  // the helper's own message is complete
      fail_reading(path, message);
    fail_reading(path, fmt::format("not a {} file: {}", format, message));
  }
  if (kind == error_choice) {
    const Json grids = report.value("grids", Json::array());
    if (grids.empty()) fail_reading(path, message);
    fail_reading(path,
                 fmt::format("{}; its grids: {}{}", message, listed(grids), remedy(grids, wanted)));
  }
  if (kind == error_memory && fs::path(path).extension() == ".obj")
    fail_reading(path, "too large: " + message);
  if (kind == error_memory) fail_reading(path, "damaged, or too large: " + message);
  fail_reading(path, "damaged: " + cut(message, 300));
}

// ---- Files

/// \return the grid that the helper wrote to the memory file. \throws DamagedVolume, std::bad_alloc
std::shared_ptr<const Volume> adopt(const Descriptor& memory, const Json& loaded) {
  const std::size_t size = memory.size();
  if (size == 0 || loaded.value("grid_bytes", std::uint64_t{0}) > size)
    throw DamagedVolume("reading it returned no grid");
  void* p = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memory.number(), 0);
  if (p == MAP_FAILED) throw std::bad_alloc();
  const std::shared_ptr<std::byte> bytes(static_cast<std::byte*>(p),
                                         [size](std::byte* b) { ::munmap(b, size); });
  if (loaded.value("checksum", "") != checksum(bytes.get(), size))
    throw DamagedVolume("the grid that its reader returned has a wrong checksum");
  return std::make_shared<const Volume>(bytes, size);
}

void add_warnings(LoadedVolume& out) {
  const MendedValues& mended = out.volume->mended();
  const auto warn = [&](const MendedValues::Voxels& found, const std::string& what) {
    if (found.count > 0)
      out.warnings.push_back(fmt::format("{} of {} active voxels {} (the first: index {}, {}, {})",
                                         found.count, out.volume->active_voxels(), what,
                                         found.first.x, found.first.y, found.first.z));
  };
  warn(mended.not_numbers, "are no numbers (NaN): taken as 0");
  const auto taken = [](float value, const char* which) {
    return fmt::format("taken as {:.4g}{}", value,
                       std::abs(value) < 1e12f ? fmt::format(", the {} of the others", which) : "");
  };
  warn(mended.above, "are infinite or beyond 1e12: " + taken(mended.largest, "largest"));
  warn(mended.below, "are minus infinity or below -1e12: " + taken(mended.smallest, "smallest"));
  if (mended.background)
    out.warnings.push_back("the background is no number or beyond 1e12: taken as 0");
}

/// \return the warning about thin walls. Interpolated distances would lose them, so each voxel
/// stores the fraction of it that they fill. \param fraction of the area of the faces
/// \param width [voxel]
std::string thin_walls(double fraction, double width, int voxels) {
  const double wanted = std::ceil(1.5 * voxels / width);
  return fmt::format(
      "{:.2g} % of its faces bound walls thinner than a voxel and a half: the density is the "
      "filled fraction of each voxel, which blurs faces by one voxel; {}",
      100 * fraction,
      limits::mesh_voxels.contains(wanted)
          ? fmt::format("\"voxels\": {:.0f} keeps them sharp", wanted)
          : fmt::format("no \"voxels\" up to {:.0f} keeps them sharp", limits::mesh_voxels.high));
}

/// \param voxels see limits_for()
LoadedVolume load(const std::string& path, std::vector<std::string> words,
                  Emptiness emptiness = Emptiness::refused, int voxels = 0) {
  const auto start = Clock::now();
  const Descriptor file = open_input(path), memory = memory_file(path);
  const std::string wanted = words.back();
  const Json report = call_helper(path, file, memory, std::move(words), voxels);
  if (report.contains("error")) fail_as_reported(path, report, wanted);
  const Json loaded = report.value("loaded", Json::object());
  LoadedVolume out;
  out.path = path;
  out.child_memory = report.value("resident", std::uint64_t{0});
  out.is_open = !loaded.value("closed", true);
  if (out.is_open)
    out.warnings.push_back("an open mesh: a shell two voxels thick along its faces, empty inside");
  if (const double fraction = loaded.value("thin_walls", 0.0); fraction > 0)
    out.warnings.push_back(thin_walls(fraction, loaded.value("thin_width", 1.0), voxels));
  try {
    out.volume = adopt(memory, loaded);
  } catch (const DamagedVolume& damage) {
    fail_reading(path, std::string("damaged: ") + damage.what());
  }
  add_warnings(out);
  const Volume& v = *out.volume;
  out.is_absent = report.value("absent", false);
  if (v.active_voxels() == 0 && emptiness == Emptiness::refused)
    fail_reading(path,
                 fmt::format("nothing to render: grid {} has no active voxels", quoted(v.name())));
  // A remap may make negative values positive; the densities that stay negative are clamped to 0.
  if (const auto n = loaded.value("negative", std::uint64_t{0}); n > 0 && !v.is_level_set())
    out.warnings.push_back(fmt::format(
        "{} of {} active voxels are negative, down to {:.4g}: {}", n, v.active_voxels(),
        v.minimum(),
        v.is_color() ? "taken as black" : "taken as 0 unless a remap makes them positive"));
  out.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return out;
}

std::string format_of(const std::string& path) {
  return fs::path(path).extension() == ".nvdb" ? "nvdb" : "vdb";
}

}  // namespace

LoadedVolume load_volume(const std::string& path, const std::string& fallback,
                         const std::optional<std::string>& grid, Emptiness emptiness) {
  std::vector<std::string> words{emptiness == Emptiness::allowed ? "load-any" : "load",
                                 format_of(path), fallback};
  if (grid) words.push_back(*grid);
  return load(path, std::move(words), emptiness);
}

LoadedVolume load_mesh(const std::string& path, int voxels) {
  return load(path, {"mesh", std::to_string(voxels)}, Emptiness::refused, voxels);
}

VolumeContents list_grids(const std::string& path) {
  const Descriptor file = open_input(path), memory = memory_file(path);
  const Json report = call_helper(path, file, memory, {"list", format_of(path), ""});
  if (report.contains("error")) fail_as_reported(path, report, "");
  using Texts = std::map<std::string, std::string>;
  VolumeContents contents;
  contents.metadata = report.value("metadata", Texts());
  for (const Json& grid : report.value("grids", Json::array())) {
    contents.grids.push_back({grid.value("unique_name", ""), grid.value("type", ""),
                              grid.value("class", ""), grid.value("voxels", std::uint64_t{0}),
                              grid.value("transform", std::vector<double>{}),
                              grid.value("metadata", Texts())});
  }
  return contents;
}

std::string encode_grids(const std::string& path, bool nano, const std::vector<GridToWrite>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata,
                         bool half) {
  const auto bytes_of = [](const GridToWrite& grid) {
    if (grid.stored) return grid.stored->size();
    return sizeof(float) * static_cast<std::size_t>(grid.channels)
           * static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1])
           * static_cast<std::size_t>(grid.size[2]);
  };
  Json header{{"half", half}, {"metadata", Json::object()}, {"grids", Json::array()}};
  for (const auto& [key, text] : metadata) header["metadata"][key] = text;
  std::uint64_t at = 0;
  for (const GridToWrite& grid : grids) {
    Json rows = Json::array();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) rows.push_back(grid.to_world[column][row]);
    Json entry{{"name", grid.name}, {"channels", grid.channels}, {"transform", rows}, {"at", at}};
    if (grid.stored)
      entry["bytes"] = bytes_of(grid), entry["scale"] = grid.scale;
    else
      entry["size"] = grid.size;
    header["grids"].push_back(entry);
    at += bytes_of(grid);
  }
  const std::string text = header.dump();
  const std::uint64_t length = text.size();

  const Descriptor parcel = memory_file(path), written = memory_file(path);
  const auto put = [&](const void* from, std::size_t size) {
    const char* bytes = static_cast<const char*>(from);
    while (size > 0) {
      const ssize_t n = ::write(parcel.number(), bytes, size);
      if (n <= 0) throw std::bad_alloc();
      bytes += n;
      size -= static_cast<std::size_t>(n);
    }
  };
  put(&length, sizeof length);
  put(text.data(), text.size());
  for (const GridToWrite& grid : grids)
    put(grid.stored ? static_cast<const void*>(grid.stored->bytes()) : grid.values, bytes_of(grid));

  const auto fail_writing = [&](const std::string& why) {
    throw Error(ExitCode::output_failed,
                fmt::format("{}: {} could not write it: {}", path, volume_helper, why));
  };
  Json report;
  try {
    report = call_helper(path, parcel, written, {"write", nano ? "nvdb" : "vdb"});
  } catch (const Error& error) {
    fail_writing(error.what());
  }
  if (report.contains("error")) fail_writing(report.value("message", ""));
  std::string bytes(written.size(), '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::pread(written.number(), bytes.data() + done, bytes.size() - done,
                              static_cast<off_t>(done));
    if (n <= 0) fail_writing(std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

bool is_volume_file(const std::string& path) {
  const fs::path extension = fs::path(path).extension();
  return extension == ".vdb" || extension == ".nvdb";
}

}  // namespace tyndall::io
