#include "io/detectors.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/account.h"

namespace tyndall::io {
namespace {

/// \return an RGB power as a list.
std::string watts(const RenderResult& result, const std::int64_t* sum) {
  const double unit = std::ldexp(result.photon_power, -24);
  return fmt::format("[{}, {}, {}]", unit * static_cast<double>(sum[0]),
                     unit * static_cast<double>(sum[1]), unit * static_cast<double>(sum[2]));
}

/// \return the RGB powers of `count` bins as a list of lists.
std::string watts(const RenderResult& result, std::size_t begin, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = begin; i < begin + count; ++i)
    text += (i == begin ? "" : ", ") + watts(result, result.detected.data() + 3 * i);
  return text + "]";
}

/// \return the power balance: the emitted power, and the terms that add up to it.
std::string account(const RenderResult& result) {
  using Count = Ledger::Count;
  const std::pair<const char*, Count Balance::*> terms[] = {
      {"shot", &Balance::shot},          {"missed", &Balance::missed},
      {"escaped", &Balance::escaped},    {"absorbed", &Balance::absorbed},
      {"roulette", &Balance::rouletted}, {"stalled", &Balance::stalled}};
  std::string text = R"({"unit": "W")";
  for (const auto& [name, term] : terms) {
    Count sums[3];
    for (int c = 0; c < 3; ++c) sums[c] = power_balance(result.ledger, c).*term;
    text += fmt::format(", \"{}\": {}", name, watts(result, sums));
  }
  return text + "}";
}

std::string flux(const RenderResult& result) {
  const Detectors& d = result.frame.detectors;
  const std::size_t cells = d.length_begin() / 6;
  std::string text = fmt::format(R"({{"size": [{}, {}], "unit": "W")", d.flux_u, d.flux_v);
  for (std::size_t face = 0; face < 6; ++face)
    text += fmt::format(",\n    \"{}\": {}", scene::face_names[face],
                        watts(result, face * cells, cells));
  return text + "}";
}

/// \param step the width of a bin
std::string histogram(const RenderResult& result, std::size_t begin, int bins, double step,
                      const char* unit) {
  std::vector<double> from;
  for (int i = 0; i < bins; ++i) from.push_back(step * i);
  return fmt::format(
      "{{\"from\": [{}], \"from_unit\": \"{}\", \"unit\": \"W\",\n    \"power\": {}}}",
      fmt::join(from, ", "), unit, watts(result, begin, static_cast<std::size_t>(bins)));
}

}  // namespace

std::string detectors_json(const Run& run) {
  const RenderResult& result = run.result;
  const Detectors& d = result.frame.detectors;
  std::vector<std::string> members{fmt::format("\"scene\": \"{:016x}\"", result.frame.scene_hash),
                                   fmt::format("\"tallies\": \"{:016x}\"", result.hashes.tallies),
                                   fmt::format("\"photons\": {}", result.ledger.shot),
                                   "\"account\": " + account(result)};
  if (d.flux_u > 0) members.push_back("\"flux\": " + flux(result));
  if (d.lengths > 0) {
    members.push_back("\"path_length\": "
                      + histogram(result, d.length_begin(), d.lengths,
                                  result.frame.longest_path / d.lengths, "length"));
  }
  if (d.scatterings > 0) {
    members.push_back("\"scatterings\": "
                      + histogram(result, d.scattering_begin(), d.scatterings, 1, ""));
  }
  if (d.angles > 0) {
    members.push_back("\"exit_angle\": "
                      + histogram(result, d.angle_begin(), d.angles, 1.0 / d.angles, "cosine"));
  }
  if (d.nx > 0) {
    members.push_back(fmt::format(
        "\"absorbed\": {{\"size\": [{}, {}, {}], \"unit\": \"W\",\n    \"power\": {}}}", d.nx, d.ny,
        d.nz, watts(result, d.absorbed_begin(), d.count() - d.absorbed_begin())));
  }
  return fmt::format("{{\n  {}\n}}\n", fmt::join(members, ",\n  "));
}

}  // namespace tyndall::io
