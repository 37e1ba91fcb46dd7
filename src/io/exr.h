/// \file
/// Pictures as OpenEXR files. Only exr.cpp uses OpenEXR here.
#pragma once

#include <string>

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \return the bytes of an EXR file: R, G, B, A in 32-bit floats at the root, ZIP, Rec. 709
/// chromaticities, the provenance as text attributes. The same picture gives the same bytes.
std::string encode_exr(const Picture& picture);

/// Reads a file with the channels R, G, B, A. The provenance is all text attributes named
/// "tyndall.*", sorted. \throws Error(input_missing): no such file, damaged, other channels.
Picture read_exr(const std::string& path);

}  // namespace tyndall::io
