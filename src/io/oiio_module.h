/// \file
/// OpenImageIO sits in a module (io/plugin/oiio.h) that is loaded at its first use only: it takes
/// longer to start than everything else together.
#pragma once

#include <string>

namespace tyndall::io {

/// \return the function of the module, which stays loaded; null with the reason in `problem`, which
/// says where it looked.
void* oiio_function(const char* name, std::string& problem);

}  // namespace tyndall::io
