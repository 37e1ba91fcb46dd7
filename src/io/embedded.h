/// \file
/// The text files of src/io/look, compiled in.
#pragma once

namespace tyndall::io {

extern const char* const light_glsl;  ///< GLSL functions that sample baked light
extern const char* const look_html;   ///< a page that displays a cloud

}  // namespace tyndall::io
