/// \file
/// The protocol between Tyndall and its helpers, separate processes because damaged files may crash
/// the libraries: tyndall-vdb reads and writes volumes, tyndall-image reads images.
///
///   HELPER COMMAND MEMORY SECONDS [ARGUMENT...]
///
/// MEMORY [byte] and SECONDS of processor time are its limits. Standard input is the file. The
/// helper writes one JSON object to standard output, and its result to the file descriptor
/// `memory_descriptor`, an empty memory file. Commands:
///
///   image                             an environment image, by tyndall-image
///   list FORMAT                       the list of grids
///   load FORMAT DEFAULT [GRID]        the grid named GRID; without GRID, the one named DEFAULT
///   load-any FORMAT DEFAULT [GRID]    as load, or a grid without voxels if the file lacks it
///   mesh VOXELS                       the interior of an .obj mesh, VOXELS along its longest side
///   write FORMAT                      from a parcel on standard input to a volume file
///
/// FORMAT is vdb or nvdb. A parcel consists of the length of a JSON text in 8 bytes, the text, and
/// arrays of floats (x fastest) or NanoVDB buffers, whose offsets "at" [byte] count from the end of
/// the text: {"half": bool, "metadata": {KEY: TEXT}, "grids": [{"name", "channels": 1 or 3,
/// "transform": index to world space, 3 rows of 4, "at", and "size": [nx, ny, nz], or "bytes" and
/// "scale" of a buffer}]}
///
/// The JSON object has "error" and "message" after a failure. Otherwise it has "grids" and
/// "metadata" (list, load), "loaded" (load, mesh) with "checksum", the Hasher's hash of the memory
/// file's words in hexadecimal, and "absent" if load-any did not find the grid. "resident" is the
/// peak resident size of the helper [byte]. For an image it has "image" ("width", "height" and
/// "checksum" of its RGB floats, linear Rec. 709 from the top left), or a "problem" if the image
/// cannot be an environment; "warnings"; and "told", its metadata for people.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include <fmt/format.h>

#include "tyndall/base/hash.h"

namespace tyndall::io {

inline constexpr int memory_descriptor = 3;
inline constexpr const char* input_path = "/proc/self/fd/0";  ///< for libraries that need a name
/// The largest 16-bit float; larger numbers are clamped to it.
inline constexpr float largest_half = 65504.0f;
inline constexpr const char* volume_helper = "tyndall-vdb";
inline constexpr const char* image_helper = "tyndall-image";

// Values of "error".
inline constexpr const char* error_damaged = "damaged";
inline constexpr const char* error_format = "format";  ///< another format; the message names it
inline constexpr const char* error_choice = "choice";  ///< no grid, several, or of a wrong type
inline constexpr const char* error_memory = "memory";

inline constexpr std::size_t longest_name = 65536;  ///< of a grid [byte]; longer names are cut

/// \return whether `type`, as the helper names it, is a type of scalar values.
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
