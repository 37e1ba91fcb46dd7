/// \file
/// What crosses the border between Tyndall and its helpers, which read files that may be damaged
/// and may die of them: tyndall-vdb reads and writes volumes, tyndall-image reads images.
///
///   HELPER COMMAND MEMORY SECONDS [ARGUMENT...]
///
/// MEMORY [byte] and SECONDS of processor time are its limits. Standard input is the file, standard
/// output gets one JSON object. File descriptor `memory_descriptor` is an empty memory file for
/// what is read. Commands:
///
///   image                     an image of the sky, by tyndall-image
///   list                      what grids the file has
///   load DEFAULT [GRID]       the grid named GRID, or the one named DEFAULT
///   load-any DEFAULT [GRID]   the same, or one without voxels where the file has no such grid
///   mesh VOXELS               the body within a mesh (.obj), VOXELS along its longest side
///   write vdb|nvdb            standard input is a parcel, the memory file gets the file
///
/// A parcel is the length of a JSON text, in 8 bytes, that text, and arrays of floats (x fastest)
/// or NanoVDB buffers, each "at" so many bytes from the text's end:
/// {"half": bool, "metadata": {KEY: TEXT}, "grids": [{"name", "channels": 1 or 3, "transform":
/// index to world space, 3 rows of 4, "at", and "size": [nx, ny, nz], or "bytes" and "scale" of a
/// buffer}]}
///
/// The object has "error" and "message", or "grids" and "metadata" (list, load), "loaded" (load,
/// mesh) and "checksum" (load, mesh): Hasher's of the memory file's words, in hexadecimal; "absent"
/// where load-any found no such grid. And "resident" [byte], the most that the helper had. An image
/// is "image" ("width", "height" and "checksum" of its RGB floats, linear Rec. 709 from the top
/// left), or a "problem" that keeps it from being a sky; "warnings", and "told": what the file says
/// of it, for people.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include <fmt/format.h>

#include "tyndall/base/hash.h"

namespace tyndall::io {

inline constexpr int memory_descriptor = 3;
inline constexpr const char* input_path = "/proc/self/fd/0";  ///< for libraries that want a name
/// Larger numbers are cut, where floats have 16 bits.
inline constexpr float largest_half = 65504.0f;
inline constexpr const char* volume_helper = "tyndall-vdb";
inline constexpr const char* image_helper = "tyndall-image";

// Values of "error".
inline constexpr const char* error_damaged = "damaged";
inline constexpr const char* error_format = "format";  ///< of another format, which is named
inline constexpr const char* error_choice = "choice";  ///< no grid, or several, or of a wrong type
inline constexpr const char* error_memory = "memory";

inline constexpr std::size_t longest_name = 65536;  ///< [byte] of a grid; more is cut

/// Whether a grid of values of `type`, in the helper's words, is one of numbers.
inline bool is_numeric(const std::string& type) {
  return type == "float" || type == "double" || type == "fp4" || type == "fp8" || type == "fp16"
         || type == "fpn";
}
inline bool is_color(const std::string& type) { return type == "vec3s" || type == "vec3d"; }

inline std::string checksum(const void* data, std::uint64_t size) {
  Hasher hash;
  for (std::uint64_t at = 0; at + 8 <= size; at += 8) {
    std::uint64_t word;
    std::memcpy(&word, static_cast<const char*>(data) + at, sizeof word);
    hash.add(word);
  }
  return fmt::format("{:016x}", hash.value());
}

}  // namespace tyndall::io
