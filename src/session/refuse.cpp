#include "session/refuse.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "tyndall/render/error.h"

namespace tyndall::session {

namespace fs = std::filesystem;

void usage_error(const std::string& message) { throw Error(ExitCode::usage, message); }

void refuse_repeats(const std::vector<std::string>& outputs) {
  std::vector<fs::path> places;
  for (const std::string& path : outputs) {
    std::error_code error;
    const fs::path from_root = fs::absolute(path, error);
    fs::path place = error ? fs::path() : fs::weakly_canonical(from_root, error);
    if (!error && std::find(places.begin(), places.end(), place) != places.end())
      usage_error(fmt::format("{}: is asked for twice", path));
    places.push_back(std::move(place));
  }
}

void refuse_inputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                   const char* first, const char* others) {
  for (const std::string& path : outputs) {
    for (const std::string& input : inputs) {
      std::error_code error;
      if (!fs::equivalent(input, path, error)) continue;
      usage_error(fmt::format("{}: is {}", path, input == inputs.front() ? first : others));
    }
  }
}

}  // namespace tyndall::session
