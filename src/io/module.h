/// \file
/// Modules for large libraries, loaded at their first use. OpenImageIO (io/plugin/oiio.h), which
/// only the helper loads, starts more slowly than everything else together. MPI (mpi/mpi_module.h)
/// is needed only for several machines.
#pragma once

#include <string>

namespace tyndall::io {

/// \return the function `name` of `module` ("tyndall_oiio.so"), which stays loaded; null on
/// failure. \param[out] problem the reason, with the folders that were searched
void* module_function(const char* module, const char* name, std::string& problem);

}  // namespace tyndall::io
