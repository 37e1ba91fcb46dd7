#include "app/options.h"

#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "tyndall/render/error.h"

namespace tyndall::app {
namespace {

CLI::Validator whole_number(std::uint64_t most, const std::string& expected, std::uint64_t least) {
  const auto rewrite = [=](std::string& text) -> std::string {
    const char* end = text.data() + text.size();
    std::uint64_t digits = 0;
    if (const auto [stop, error] = std::from_chars(text.data(), end, digits);
        error == std::errc() && stop == end && digits >= least && digits <= most)
      return "";
    double value = -1.0;
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    const bool whole = error == std::errc() && stop == end && value >= 0.0 && value < 0x1p64
                       && value == std::floor(value);
    if (!whole || static_cast<std::uint64_t>(value) > most
        || static_cast<std::uint64_t>(value) < least)
      return fmt::format("expected {}, got '{}'", expected, text);
    text = fmt::format("{}", static_cast<std::uint64_t>(value));
    return "";
  };
  return {rewrite, ""};
}

/// Reads "A:B", whose numbers may be written as 2e6.
IndexRange read_range(const std::string& option, const std::string& text) {
  const std::size_t colon = text.find(':');
  std::string begin = text.substr(0, colon),
              end = colon == std::string::npos ? "" : text.substr(colon + 1);
  const CLI::Validator number = count();
  if (!number(begin).empty() || !number(end).empty() || std::stoull(begin) >= std::stoull(end)) {
    throw Error(ExitCode::usage,
                fmt::format("{}: expected A:B with A below B, the first and one beyond the last, "
                            "got '{}'",
                            option, text));
  }
  return {std::stoull(begin), std::stoull(end)};
}

/// Reads "A:B" or "A:B:STEP".
FrameRange read_frames(const std::string& text) {
  FrameRange range;
  int* const numbers[] = {&range.first, &range.last, &range.step};
  const char *at = text.data(), *end = at + text.size();
  int count = 0;
  while (count < 3) {
    const auto [stop, error] = std::from_chars(at, end, *numbers[count]);
    if (error != std::errc()) break;
    ++count;
    at = stop;
    if (at == end || *at != ':') break;
    ++at;
  }
  if (count == 1) range.last = range.first;
  if (text.find('-') != text.npos)
    throw Error(ExitCode::usage,
                fmt::format("--frames {}: frame numbers start at 0; renumber the files, or write "
                            "values that depend on the frame with {{t}}",
                            text));
  if (at != end || text.ends_with(':') || count < 1 || range.first < 0 || range.last < range.first
      || range.step < 1 || range.last > 100000000) {
    throw Error(
        ExitCode::usage,
        fmt::format("--frames: expected A, A:B or A:B:STEP, the first and the last frame, got "
                    "'{}'",
                    text));
  }
  return range;
}

}  // namespace

CLI::Validator count(std::uint64_t most, std::uint64_t least) {
  return whole_number(most, fmt::format("an integer in [{}, {}]", least, most), least);
}

CLI::Validator count(const Range& range) {
  return whole_number(static_cast<std::uint64_t>(range.high), describe(range),
                      static_cast<std::uint64_t>(range.low));
}

CLI::Validator duration(bool may_be_zero) {
  const auto rewrite = [=](std::string& text) -> std::string {
    const char* end = text.data() + text.size();
    double value = -1;
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    const std::string_view unit(stop, static_cast<std::size_t>(end - stop));
    const double scale = unit.empty() || unit == "s" ? 1
                         : unit == "m"               ? 60
                         : unit == "h"               ? 3600
                                                     : 0;
    if (error != std::errc() || scale == 0 || !(value >= 0 && value < 1e12)
        || (value == 0 && !may_be_zero))
      return fmt::format("expected a time {}such as 90s, 5m or 1.5h, got '{}'",
                         may_be_zero ? "" : "above 0 ", text);
    text = fmt::format("{}", value * scale);
    return "";
  };
  return {rewrite, ""};
}

CLI::Validator fraction() {
  const auto check = [](const std::string& text) -> std::string {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && stop == end && value > 0 && value < 1) return "";
    return fmt::format("expected a number above 0 and below 1, such as 0.01 for 1 %, got '{}'",
                       text);
  };
  return {check, ""};
}

void add_scene(CLI::App& command, SceneArguments& arguments) {
  command.add_option("SCENE", arguments.scene, "Scene file (JSON)")->required()->type_name("");
  command
      .add_option("-D,--define", arguments.overrides,
                  "Replaces a value of the scene, e.g. -D camera.fov=30")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
}

void add_override(CLI::App& command, SceneArguments& arguments, const std::string& flags,
                  const std::string& key, const CLI::Validator& validator,
                  const std::string& help) {
  const auto override = [&arguments, key](const std::string& value) {
    arguments.overrides.push_back(key + "=" + value);
  };
  command.add_option_function<std::string>(flags, override, help)
      ->transform(validator)
      ->type_name("N");
}

void add_work(CLI::App& command, session::WorkArguments& arguments) {
  command.add_option("-t,--threads", arguments.threads, "Threads (0: all of the machine's)")
      ->type_name("N")
      ->transform(count(4096));
  command
      .add_option(
          "--device", arguments.device,
          "auto (all CUDA devices if there are any, else the CPU), cpu, cuda (all) or cuda:N")
      ->type_name("NAME");
  command
      .add_option("--progress", arguments.progress, "auto (a bar on terminals), bar, plain or none")
      ->type_name("STYLE")
      ->check(CLI::IsMember({"auto", "bar", "plain", "none"}).description(""));
}

void add_range(CLI::App& command, std::optional<IndexRange>& range, const std::string& flag,
               const std::string& help) {
  command
      .add_option_function<std::string>(
          flag, [&range, flag](const std::string& text) { range = read_range(flag, text); }, help)
      ->type_name("A:B");
}

void add_frames(CLI::App& command, std::optional<FrameRange>& frames, const std::string& help) {
  command
      .add_option_function<std::string>(
          "--frames", [&frames](const std::string& text) { frames = read_frames(text); }, help)
      ->type_name("A[:B[:STEP]]");
}

}  // namespace tyndall::app
