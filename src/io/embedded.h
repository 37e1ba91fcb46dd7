/// \file
/// The text files of src/io/look, compiled in.
#pragma once

namespace tyndall::io {

extern const char* const light_glsl;  ///< looks light up in a shader
extern const char* const look_html;   ///< a page for a cloud

}  // namespace tyndall::io
