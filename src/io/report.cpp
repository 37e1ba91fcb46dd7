#include "io/report.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/account.h"

namespace tyndall::io {
namespace {

using Count = Ledger::Count;

std::string hex(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

double ratio(double part, double whole) { return whole == 0.0 ? 0.0 : part / whole; }

bool power_closes(const Ledger& ledger) {
  return power_balance(ledger, 0).closes() && power_balance(ledger, 1).closes()
         && power_balance(ledger, 2).closes();
}

/// \return [W] of `units` of the ledger's power.
double watt(const RenderResult& result, Count units) {
  return std::ldexp(static_cast<double>(units), -24) * result.photon_power;
}

std::string audit_text(const Audit& audit) {
  const auto tentative = static_cast<double>(audit.tentative);
  const auto real = static_cast<double>(audit.real);
  return fmt::format(
      "{:.3g} % virtual collisions, {:.3g} look-ups per real one, {:.3g} cells per flight",
      100 * ratio(tentative - real, tentative), ratio(static_cast<double>(audit.lookups), real),
      ratio(static_cast<double>(audit.cells), static_cast<double>(audit.flights)));
}

// ---- Facts, common to the header and the JSON report. ----

/// \return `text` as JSON.
std::string quoted(std::string_view text) {
  std::string json = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\')
      json += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20)
      json += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      json += c;
  }
  return json + '"';
}

struct Fact {
  std::string key;
  std::string value;
  bool is_text = false;  // otherwise the value is JSON

  std::string json() const { return is_text ? quoted(value) : value; }
};

template <class List>
std::string list(const List& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

std::string watts(const RenderResult& result, const Count (&units)[3]) {
  const double channels[] = {watt(result, units[0]), watt(result, units[1]),
                             watt(result, units[2])};
  return list(channels);
}

/// \return a list of RGB powers for the first `count` faces or components.
template <std::size_t n>
std::string watts(const RenderResult& result, const Count (&units)[n][3], std::size_t count) {
  std::vector<std::string> lists;
  for (std::size_t i = 0; i < count; ++i) lists.push_back(watts(result, units[i]));
  return list(lists);
}

/// Adds facts such as "audit.shoot.real". Keys stay below 32 characters including "tyndall.": old
/// readers refuse EXR files with longer ones.
void add_audit(std::vector<Fact>& facts, const char* pass, const Audit& audit) {
  const std::pair<const char*, Count> counts[] = {
      {"flights", audit.flights},      {"cells", audit.cells},
      {"tentative", audit.tentative},  {"real", audit.real},
      {"lookups", audit.lookups},      {"octaves", audit.octaves},
      {"violations", audit.violations}};
  facts.push_back({fmt::format("audit.{}", pass), audit_text(audit), true});
  for (const auto& [name, count] : counts)
    facts.push_back({fmt::format("audit.{}.{}", pass, name), fmt::format("{}", count)});
}

std::vector<Fact> facts_of(const RenderResult& result) {
  const Frame& frame = result.frame;
  const Ledger& ledger = result.ledger;
  const auto components = static_cast<std::size_t>(frame.components);
  const auto number = [](auto value) { return fmt::format("{}", value); };
  const std::vector<Count> absorbed(ledger.absorbed, ledger.absorbed + components);
  std::vector<std::string> warnings;
  for (const std::string& warning : result.warnings) warnings.push_back(quoted(warning));

  std::vector<Fact> facts{
      {"version", TYNDALL_VERSION, true},
      {"arithmetic_version", number(frame.arithmetic)},
      {"scene_hash", hex(frame.scene_hash), true},
      {"seed", number(frame.seed)},
      {"photons", number(frame.photons)},
      {"samples", number(frame.samples)},
      {"complete", number(result.is_complete)},
      {"noise", std::isfinite(result.noise) ? fmt::format("{:.4g}", result.noise) : "null"},
      {"preview", number(result.is_preview)},
      {"limit", result.limit.empty() ? "null" : result.limit, !result.limit.empty()},
      {"ranges.photons", result.photons.text(), true},
      {"ranges.samples", result.samples.text(), true},
      {"hash.tallies", hex(result.hashes.tallies), true},
      {"hash.pixels", hex(result.hashes.pixels), true},
      {"ledger.count.shot", number(ledger.shot)},
      {"ledger.count.missed", number(ledger.missed)},
      {"ledger.count.escaped", list(ledger.escaped)},
      {"ledger.count.absorbed", list(absorbed)},
      {"ledger.count.rouletted", number(ledger.rouletted)},
      {"ledger.count.stalled", number(ledger.stalled)},
      {"ledger.count.closes", number(photon_balance(ledger).closes())},
      {"ledger.watt.shot", watts(result, ledger.shot_power)},
      {"ledger.watt.missed", watts(result, ledger.missed_power)},
      {"ledger.watt.escaped", watts(result, ledger.escaped_power, 6)},
      {"ledger.watt.absorbed", watts(result, ledger.absorbed_power, components)},
      {"ledger.watt.roulette", watts(result, ledger.roulette_power)},
      {"ledger.watt.stalled", watts(result, ledger.stalled_power)},
      {"ledger.watt.closes", number(power_closes(ledger))},
      {"ledger.watt.unshot", list(result.unshot_power)},
      {"unlit_replicates", number(result.unlit_replicates)},
  };
  add_audit(facts, "shoot", result.shoot);
  add_audit(facts, "gather", result.gather);
  facts.push_back({"clamped", number(result.clamped)});
  facts.push_back({"warnings", list(warnings)});
  return facts;
}

// ---- Lines for people. ----

/// \return "870", "870 k", "8.7 M": three digits are enough for a speed.
std::string short_number(double value) {
  if (value >= 1e9) return fmt::format("{:.3g} G", value * 1e-9);
  if (value >= 1e6) return fmt::format("{:.3g} M", value * 1e-6);
  if (value >= 1e3) return fmt::format("{:.3g} k", value * 1e-3);
  return fmt::format("{:.3g}", value);
}

std::string balance_line(const double (&fractions)[5], bool closes) {
  return fmt::format(
      "{:.3g} % missed, {:.3g} % escaped, {:.3g} % absorbed, {:.3g} % roulette, {:.3g} % stalled; "
      "{}\n",
      100 * fractions[0], 100 * fractions[1], 100 * fractions[2], 100 * fractions[3],
      100 * fractions[4], closes ? "the account closes" : "THE ACCOUNT DOES NOT CLOSE");
}

std::string photon_line(const Ledger& ledger) {
  const Balance sum = photon_balance(ledger);
  const auto fraction = [&](Count part) {
    return ratio(static_cast<double>(part), static_cast<double>(sum.shot));
  };
  return fmt::format("photons  {} shot: ", sum.shot)
         + balance_line({fraction(sum.missed), fraction(sum.escaped), fraction(sum.absorbed),
                         fraction(sum.rouletted), fraction(sum.stalled)},
                        sum.closes());
}

/// \return "3 W", or "3, 2, 1 W" for red, green and blue if they differ.
std::string channels_text(const double (&watts)[3]) {
  return watts[0] == watts[1] && watts[1] == watts[2]
             ? fmt::format("{:.4g} W", watts[0])
             : fmt::format("{:.4g}, {:.4g}, {:.4g} W", watts[0], watts[1], watts[2]);
}

/// Powers are shown per channel; the fractions are of the sum of the channels.
std::string power_line(const RenderResult& result) {
  double shot[3] = {}, fractions[5] = {};
  for (int channel = 0; channel < 3; ++channel) {
    const Balance sum = power_balance(result.ledger, channel);
    const Count parts[5] = {sum.missed, sum.escaped, sum.absorbed, sum.rouletted, sum.stalled};
    shot[channel] = watt(result, sum.shot);
    for (int i = 0; i < 5; ++i) fractions[i] += watt(result, parts[i]);
  }
  for (double& fraction : fractions) fraction = ratio(fraction, shot[0] + shot[1] + shot[2]);
  const double* const unshot = result.unshot_power;
  const std::string passing =
      unshot[0] + unshot[1] + unshot[2] > 0
          ? fmt::format(" ({} more pass by the medium)", channels_text(result.unshot_power))
          : "";
  return fmt::format("power    {} shot{}: ", channels_text(shot), passing)
         + balance_line(fractions, power_closes(result.ledger));
}

/// Squeezed look-ups evaluate the density only if they are audited (is_audited() in
/// tyndall/transport/walk.h), so the count covers only audited look-ups.
std::string bounds_line(const RenderResult& result) {
  if (!result.frame.has_bounds) return "bounds   not used\n";
  return fmt::format("bounds   {} violations; one look-up in 256 is audited\n",
                     violations(result.shoot, result.gather));
}

double photons_per_second(const RenderResult& result) {
  return ratio(static_cast<double>(result.ledger.shot), result.seconds.photons);
}

/// \return pixel samples per second.
double samples_per_second(const RenderResult& result) {
  const double pixels =
      static_cast<double>(result.picture.width) * static_cast<double>(result.picture.height);
  return ratio(pixels * static_cast<double>(result.samples.count()), result.seconds.pixels);
}

/// \return a line about reading a volume; the second size is the memory of the helper process.
std::string volume_line(const LoadedVolume& v) {
  return fmt::format("volume   {}: {} active voxels, {}B, read in {:.2f} s by a process of {}B\n",
                     v.path, short_number(static_cast<double>(v.volume->active_voxels())),
                     short_number(static_cast<double>(v.volume->size())), v.seconds,
                     short_number(static_cast<double>(v.child_memory)));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> provenance(const RenderResult& result) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const Fact& fact : facts_of(result)) pairs.emplace_back("tyndall." + fact.key, fact.value);
  return pairs;
}

std::string report_json(const Run& run) {
  const PassSeconds& seconds = run.result.seconds;
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  std::vector<Fact> facts = facts_of(run.result);
  facts.insert(facts.end(), {{"scene", run.scene_path, true},
                             {"device", run.device, true},
                             {"seconds.bounds", number(seconds.bounds)},
                             {"seconds.photons", number(seconds.photons)}});
  for (const measurement::Id id : measurement::ids)
    facts.push_back(
        {fmt::format("seconds.{}", measurement::rows[id].name), number(seconds.measured[id])});
  facts.insert(facts.end(), {{"seconds.pixels", number(seconds.pixels)},
                             {"photons_per_second", number(photons_per_second(run.result))},
                             {"samples_per_second", number(samples_per_second(run.result))}});
  std::vector<std::string> volumes;
  for (const LoadedVolume& v : run.volumes) {
    std::vector<std::string> warnings;
    for (const std::string& warning : v.warnings) warnings.push_back(quoted(warning));
    volumes.push_back(fmt::format(
        R"({{"file": {}, "grid": {}, "active_voxels": {}, "bytes": {}, "seconds": {:.4g}, "reader_bytes": {}, "warnings": {}}})",
        quoted(v.path), quoted(v.volume->name()), v.volume->active_voxels(), v.volume->size(),
        v.seconds, v.child_memory, list(warnings)));
  }
  facts.push_back({"volumes", list(volumes)});
  std::vector<std::string> members;
  for (const Fact& fact : facts)
    members.push_back(fmt::format("  {}: {}", quoted(fact.key), fact.json()));
  return fmt::format("{{\n{}\n}}\n", fmt::join(members, ",\n"));
}

std::string report_lines(const Run& run) {
  const RenderResult& result = run.result;
  const PassSeconds& seconds = result.seconds;
  std::string lines;
  for (const LoadedVolume& volume : run.volumes) lines += volume_line(volume);
  // Photons take no time if the light was reused.
  const std::string speed =
      seconds.photons > 0 ? fmt::format(" ({}/s)", short_number(photons_per_second(result))) : "";
  lines += fmt::format(
      "time     bounds {:.2f} s, photons {:.2f} s{}, medium {:.2f} s, pixels {:.2f} s ({} "
      "samples/s), depth {:.2f} s\n",
      seconds.bounds, seconds.photons, speed, seconds.measured[measurement::scattering],
      seconds.pixels, short_number(samples_per_second(result)),
      seconds.measured[measurement::depth]);
  if (!result.limit.empty()) {
    const std::string noise =
        std::isfinite(result.noise) ? fmt::format("; noise {:.3g}", result.noise) : "";
    lines += fmt::format("limit    {} ended the render; {} of {} samples are done{}\n",
                         result.limit, result.samples.count(), result.frame.samples, noise);
  }
  lines += photon_line(result.ledger) + power_line(result);
  lines += bounds_line(result);
  lines += fmt::format("walks    photons: {}\n         pixels: {}\n", audit_text(result.shoot),
                       audit_text(result.gather));
  if (result.clamped > 0) lines += fmt::format("film     {} samples clamped\n", result.clamped);
  lines += fmt::format("hash     tallies {:016x} pixels {:016x} scene {:016x}\n",
                       result.hashes.tallies, result.hashes.pixels, result.frame.scene_hash);
  return lines;
}

}  // namespace tyndall::io
