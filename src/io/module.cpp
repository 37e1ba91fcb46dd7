#include "io/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

/// \return the possible paths: beside the executable (in a build), or relative to it in an
/// installation.
std::vector<fs::path> places_of(const char* module) {
  const fs::path bin = fs::read_symlink("/proc/self/exe").parent_path();
  std::vector<fs::path> places{bin / module};
#ifdef TYNDALL_PLUGIN_DIR
  places.push_back((bin / TYNDALL_PLUGIN_DIR / module).lexically_normal());
#endif
  return places;
}

}  // namespace

void* module_function(const char* module, const char* name, std::string& problem) {
  std::string looked;
  for (const fs::path& place : places_of(module)) {
    std::error_code error;
    if (!fs::exists(place, error)) {
      looked += (looked.empty() ? "" : ", ") + place.parent_path().string();
      continue;
    }
    // RTLD_GLOBAL because Open MPI loads plug-ins that need its symbols.
    void* loaded = ::dlopen(place.c_str(), RTLD_NOW | RTLD_GLOBAL);
    void* function = loaded != nullptr ? ::dlsym(loaded, name) : nullptr;
    if (function == nullptr) problem = ::dlerror();
    return function;
  }
  problem = fmt::format("{} was not found in {}", module, looked);
  return nullptr;
}

}  // namespace tyndall::io
