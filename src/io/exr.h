/// \file
/// Pictures as OpenEXR files. exr.cpp alone knows OpenEXR.
#pragma once

#include <string>

#include "tyndall/render/picture.h"

namespace tyndall::io {

/// \return the bytes of an EXR file: R, G, B, A in 32-bit floats at the root, ZIP, Rec. 709
/// chromaticities, the provenance as text attributes. The same picture gives the same bytes.
std::string encode_exr(const Picture& picture);

/// A file with the channels R, G, B, A; its provenance is every text attribute named "tyndall.*",
/// sorted. \throws Error(input_missing): no such file, damaged, other channels.
Picture read_exr(const std::string& path);

}  // namespace tyndall::io
