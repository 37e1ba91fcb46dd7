/// \file
/// Large libraries sit in modules that are loaded at their first use only: OpenImageIO
/// (io/plugin/oiio.h), which only the helper loads, takes longer to start than everything else
/// together, MPI (mpi/mpi_module.h) is no business of a machine that works alone.
#pragma once

#include <string>

namespace tyndall::io {

/// \return the function `name` of `module` ("tyndall_oiio.so"), which stays loaded; null with the
/// reason in `problem`, which says where it looked.
void* module_function(const char* module, const char* name, std::string& problem);

}  // namespace tyndall::io
