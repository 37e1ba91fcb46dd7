/// \file
/// What crosses the border between Tyndall and its helper, tyndall-vdb, which reads files that may
/// be damaged and may die of them.
///
///   tyndall-vdb COMMAND MEMORY SECONDS [ARGUMENT...]
///
/// MEMORY [byte] and SECONDS of processor time are its limits. Standard input is the file, standard
/// output gets one JSON object. File descriptor `grid_descriptor` is an empty memory file for the
/// grid. Commands:
///
///   list                      what grids the file has
///   load DEFAULT [GRID]       the grid named GRID, or the one named DEFAULT
///   mesh VOXELS               the body within a mesh (.obj), VOXELS along its longest side
///
/// The object has "error" and "message", or "grids" (list, load), "loaded" (load, mesh) and
/// "checksum" (load, mesh): Hasher's of the memory file's words, in hexadecimal.
#pragma once

namespace tyndall::io {

inline constexpr int grid_descriptor = 3;
inline constexpr const char* helper_name = "tyndall-vdb";

// Values of "error".
inline constexpr const char* error_damaged = "damaged";
inline constexpr const char* error_format = "format";  ///< of another format, which is named
inline constexpr const char* error_choice = "choice";  ///< no grid, or several, or of a wrong type
inline constexpr const char* error_memory = "memory";

}  // namespace tyndall::io
