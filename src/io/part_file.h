/// \file
/// Parts of results in files (.tyn). Checkpoints, one machine's part of a render and light that is
/// reused have this format. docs/format.md describes the bytes.
#pragma once

#include <cstdint>
#include <string>

#include "io/output_file.h"
#include "tyndall/render/part.h"

namespace tyndall::io {

inline constexpr std::uint32_t part_version = 3;

/// Appends `part` to `file`, without committing it. \throws Error(output_failed)
void write_part(const Partial& part, OutputFile& file);

/// \param most_bytes of memory for the arrays of the file
/// \throws Error(input_missing) if the file is missing, of another version, or damaged (the error
/// names the chunk); Error(out_of_memory) if its arrays need more than `most_bytes`
Partial read_part(const std::string& path, std::uint64_t most_bytes);
/// Parses the bytes of a file as read_part() does. \param name of the file in messages
Partial parse_part(std::string_view bytes, const std::string& name, std::uint64_t most_bytes);

}  // namespace tyndall::io
