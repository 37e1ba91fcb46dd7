#include "io/oiio_module.h"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* module_name = "tyndall_oiio.so";

/// Beside the executable (a build), or where an installation puts it, seen from there.
std::vector<fs::path> module_places() {
  const fs::path bin = fs::read_symlink("/proc/self/exe").parent_path();
  std::vector<fs::path> places{bin / module_name};
#ifdef TYNDALL_PLUGIN_DIR
  places.push_back((bin / TYNDALL_PLUGIN_DIR / module_name).lexically_normal());
#endif
  return places;
}

}  // namespace

void* oiio_function(const char* name, std::string& problem) {
  std::string looked;
  for (const fs::path& place : module_places()) {
    std::error_code error;
    if (!fs::exists(place, error)) {
      looked += (looked.empty() ? "" : ", ") + place.parent_path().string();
      continue;
    }
    void* module = ::dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* function = module != nullptr ? ::dlsym(module, name) : nullptr;
    if (function == nullptr) problem = ::dlerror();
    return function;
  }
  problem = fmt::format("{} was not found in {}", module_name, looked);
  return nullptr;
}

}  // namespace tyndall::io
