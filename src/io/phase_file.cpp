#include "io/phase_file.h"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "scene/phases.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view blanks = " \t\r";

/// Removes a number, and the blanks before it, from the front of `text`. \return whether it is one.
bool take(std::string_view& text, double& number) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const auto length = static_cast<std::size_t>(end - text.data());
  const bool ends = length == text.size() || blanks.find(text[length]) != blanks.npos;
  text.remove_prefix(length);
  return error == std::errc() && ends;
}

}  // namespace

std::shared_ptr<const scene::PhaseTable> read_phase_file(const std::string& path) {
  const auto fail = [&](const std::string& why) {
    throw Error(ExitCode::input_missing, fmt::format("{}: {}", path, why));
  };
  std::error_code error;
  if (fs::is_directory(path, error)) fail("is a folder, expected a table of a phase function");
  std::ifstream file(path);
  if (!file) fail(fs::exists(path, error) ? "cannot be read" : "no such file");

  const auto table = std::make_shared<scene::PhaseTable>();
  std::vector<int> lines;  // of the rows
  const auto fail_at = [&](int line, const std::string& why) {
    throw Error(ExitCode::input_missing, fmt::format("{}:{}: {}", path, line, why));
  };
  int line = 0;
  for (std::string text; std::getline(file, text);) {
    ++line;
    std::string_view rest = std::string_view(text).substr(0, text.find('#'));
    if (rest.find_first_not_of(blanks) == rest.npos) continue;
    double cosine = 0, value = 0;
    if (!take(rest, cosine) || !take(rest, value) || rest.find_first_not_of(blanks) != rest.npos)
      fail_at(line, fmt::format("expected \"cosine value\", got \"{}\"", text.substr(0, 60)));
    table->cosines.push_back(cosine);
    table->values.push_back(value);
    lines.push_back(line);
    if (lines.size() > limits::phase_rows.high) break;
  }
  if (file.bad()) fail("cannot be read");
  if (const scene::PhaseTableProblem problem = phase_table_problem(*table);
      !problem.message.empty())
    fail_at(lines.empty() ? line : lines[problem.row], problem.message);
  return table;
}

}  // namespace tyndall::io
