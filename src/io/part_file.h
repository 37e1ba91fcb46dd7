/// \file
/// Parts of results in files (.tyn): what a checkpoint, a machine's share and light to gather from
/// have in common. docs/format.md describes the bytes.
#pragma once

#include <cstdint>
#include <string>

#include "io/output_file.h"
#include "tyndall/render/part.h"

namespace tyndall::io {

inline constexpr std::uint32_t part_version = 3;

/// Appends `part` to `file`, without committing it. \throws Error(output_failed)
void write_part(const Partial& part, OutputFile& file);

/// \param most_bytes of memory that the file may ask for
/// \throws Error(input_missing) where it is not there, of another version, or damaged: names the
/// chunk; Error(out_of_memory) where it asks for more
Partial read_part(const std::string& path, std::uint64_t most_bytes);
/// The same for the bytes of a file, which `name` stands for in messages.
Partial parse_part(std::string_view bytes, const std::string& name, std::uint64_t most_bytes);

}  // namespace tyndall::io
