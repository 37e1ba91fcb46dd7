/// \file
/// tyndall-bench: the paper's tables, on this machine.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>
#include <regex>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "io/output_file.h"
#include "measure.h"
#include "page.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"

namespace tyndall::bench {
namespace {

std::string title(const Case& c) {
  return fmt::format("{}/{}^3", c.scene, c.effective_resolution());
}

std::string row_name(const Case& c, const std::string& sampler) {
  return fmt::format("table{}/{}/{}", c.table, title(c), sampler);
}

/// \return the denominator of the ratios: the rate of the fastest variant of the paper's method.
double published(const std::vector<Result>& results) {
  double best = 0;
  for (const Result& r : results)
    if (r.sampler.starts_with("super_voxel_2011"))
      best = std::max(best, r.photons_per_second.median);
  return best;
}

void print(const std::vector<Result>& results) {
  const double base = published(results);
  double paper_base = 0;
  for (const Result& r : results)
    if (r.sampler == "super_voxel_2011") paper_base = r.paper;
  std::printf("  %-21s %12s %23s %12s %12s %23s %8s %8s | %9s %8s %8s %8s %8s\n", "sampler",
              "photons/s", "least .. most", "RGB order 1", "collisions/s", "least .. most", "ratio",
              "paper's", "tent/real", "look-ups", "octaves", "cells", "scatter");
  for (const Result& r : results) {
    const Audit& a = r.account.audit;
    const auto flights = static_cast<double>(std::max<Audit::Count>(a.flights, 1));
    std::printf(
        "  %-21s %12.4g %10.4g .. %9.4g %12.4g %12.4g %10.4g .. %9.4g %8s %8s | %9.3f %8.3f %8.2f "
        "%8.2f %8.2f\n",
        r.sampler.c_str(), r.photons_per_second.median, r.photons_per_second.least,
        r.photons_per_second.most, r.photons_per_second_color.median,
        r.collisions_per_second.median, r.collisions_per_second.least, r.collisions_per_second.most,
        base > 0 ? fmt::format("{:.3g}", r.photons_per_second.median / base).c_str() : "-",
        r.paper > 0 && paper_base > 0 ? fmt::format("{:.3g}", r.paper / paper_base).c_str() : "-",
        r.per_real(a.tentative), r.per_real(a.lookups), r.per_real(a.octaves),
        static_cast<double>(a.cells) / flights,
        static_cast<double>(a.real) / static_cast<double>(r.photons));
  }
  std::fflush(stdout);
}

std::string json(const std::vector<Result>& results) {
  std::string text = "[\n";
  for (const Result& r : results) {
    const Audit& a = r.account.audit;
    text += fmt::format(
        "{}  {{\"table\": {}, \"scene\": \"{}\", \"effective_resolution\": {}, \"sampler\": "
        "\"{}\", "
        "\"device\": \"{}\", \"threads\": {}, \"photons_per_second\": {:.6g}, "
        "\"photons_per_second_least\": {:.6g}, \"photons_per_second_most\": {:.6g}, "
        "\"photons_per_second_rgb_order_1\": {:.6g}, \"real_collisions_per_second\": {:.6g}, "
        "\"real_collisions_per_second_least\": {:.6g}, \"real_collisions_per_second_most\": "
        "{:.6g}, "
        "\"tentative_per_real\": {:.6g}, \"lookups_per_real\": {:.6g}, \"octaves_per_real\": "
        "{:.6g}, "
        "\"cells_per_flight\": {:.6g}, \"scatterings_per_photon\": {:.6g}, \"paper\": {:.6g}}}",
        text.size() > 2 ? ",\n" : "", r.which.table, r.which.scene, r.which.effective_resolution(),
        r.sampler, r.device, r.threads, r.photons_per_second.median, r.photons_per_second.least,
        r.photons_per_second.most, r.photons_per_second_color.median,
        r.collisions_per_second.median, r.collisions_per_second.least, r.collisions_per_second.most,
        r.per_real(a.tentative), r.per_real(a.lookups), r.per_real(a.octaves),
        static_cast<double>(a.cells) / static_cast<double>(std::max<Audit::Count>(a.flights, 1)),
        static_cast<double>(a.real) / static_cast<double>(r.photons), r.paper);
  }
  return text + "\n]\n";
}

const char* const samplers[] = {"ray_marching",         "woodcock",
                                "woodcock_squeezed",    "super_voxel_2011",
                                "super_voxel_2011/32",  "super_voxel_2011/64",
                                "super_voxel_squeezed", "tyndall/avx2",
                                "tyndall/fast_math",    "tyndall"};

bool is_on(bool cpu, std::string_view sampler) {
  if (cpu) return sampler != "tyndall/fast_math";
  return !sampler.ends_with("squeezed") && sampler != "tyndall/avx2";
}

/// Accepts a number in [low, high], such as 1e4; rejects NaN.
CLI::Validator number(double low, double high) {
  return {[=](std::string& text) -> std::string {
            double x = 0;
            const char* end = text.data() + text.size();
            const auto [stop, error] = std::from_chars(text.data(), end, x);
            if (error == std::errc() && stop == end && low <= x && x <= high) return "";
            return fmt::format("expected a number in [{}, {}], got '{}'", low, high, text);
          },
          ""};
}

int run(int argc, char** argv) {
  CLI::App app{
      "Times photons in the paper's media [SzirmayKalos2011]: ray marching, Woodcock tracking, "
      "super-voxels as published, and what tyndall does."};
  std::string table = "all", filter, json_file, html_file;
  Options options;
  bool list = false;
  app.add_option("--table", table, "1, 2, 3 or all")->check(CLI::IsMember({"1", "2", "3", "all"}));
  double photons = 0;
  app.add_option("--photons", photons,
                 "photons per row and repeat (0, the default: as many as fit the time)")
      ->check(number(0, 1e11));
  app.add_option("--seconds", options.seconds, "time per row (default 2)")
      ->check(number(1e-3, 1e6));
  app.add_option("--repeats", options.repeats, "interleaved repeats (default 5)")
      ->check(CLI::Range(1, 1000));
  app.add_option("--threads", options.threads, "threads; 0: one per hardware thread (default 1)")
      ->check(CLI::Range(0, 4096));
  app.add_option("--device", options.device, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}));
  app.add_option("--filter", filter, "only rows whose name matches this regular expression");
  app.add_option("--json", json_file, "write the rows as JSON");
  app.add_option("--html", html_file, "write a page with plots");
  app.add_flag("--list", list, "print the names of the rows and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  options.photons = static_cast<std::uint64_t>(photons);
  options.threads = thread_count(options.threads);
  const bool on_cpu = options.device == "cpu";
#if !TYNDALL_CUDA
  if (!on_cpu) throw Error(ExitCode::device, "--device cuda: this build has no CUDA");
#endif
  std::regex wanted;
  try {
    wanted = std::regex(filter);
  } catch (const std::regex_error&) {
    throw Error(ExitCode::usage, fmt::format("--filter: '{}' is no regular expression", filter));
  }

  // Reports unwritable outputs before any timing.
  std::optional<io::OutputFile> json_output, html_output;
  if (!list && !json_file.empty()) json_output.emplace(json_file);
  if (!list && !html_file.empty()) html_output.emplace(html_file);

  std::vector<Result> results;
  std::set<std::string> checked;
  for (const Case& which : cases()) {
    if (table != "all" && which.table != table[0] - '0') continue;
    const auto is_wanted = [&](const std::string& sampler) {
      return is_on(on_cpu, sampler) && std::regex_search(row_name(which, sampler), wanted);
    };
    if (std::none_of(std::begin(samplers), std::end(samplers), is_wanted)) continue;
    if (list) {
      for (const char* sampler : samplers)
        if (is_wanted(sampler)) std::printf("%s\n", row_name(which, sampler).c_str());
      continue;
    }
    Stage stage(which, thread_count(0), options.device);
    std::printf("Table %d, %s: %s, %d thread%s\n", which.table, title(which).c_str(),
                options.device.c_str(), options.threads, options.threads == 1 ? "" : "s");
    stage.threads = options.threads;
    if (checked.insert(title(which)).second) {
      const Verdict verdict = check(stage, options.device);
      for (const std::string& line : verdict.lines) std::printf("%s\n", line.c_str());
      std::fflush(stdout);
      if (!verdict.agree)
        throw Error(ExitCode::internal, "the samplers do not agree: nothing was timed");
    }
    const std::vector<Result> own = measure(stage, options, is_wanted);
    print(own);
    results.insert(results.end(), own.begin(), own.end());
  }
  if (list) return 0;
  if (results.empty()) throw Error(ExitCode::usage, "--filter, --table: no row matches");
  if (json_output) json_output->write(json(results)), json_output->commit();
  if (html_output) html_output->write(page(results)), html_output->commit();
  return 0;
}

}  // namespace
}  // namespace tyndall::bench

int main(int argc, char** argv) {
  try {
    return tyndall::bench::run(argc, argv);
  } catch (const tyndall::Error& error) {
    std::fprintf(stderr, "tyndall-bench: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tyndall-bench: %s\n", error.what());
    return 1;
  }
}
