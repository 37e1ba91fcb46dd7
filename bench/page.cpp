#include "page.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

namespace tyndall::bench {
namespace {

const std::map<std::string, const char*> colors = {{"ray_marching", "#9a9a9a"},
                                                   {"woodcock", "#d0883a"},
                                                   {"woodcock_squeezed", "#e8bd8a"},
                                                   {"super_voxel_2011", "#4878b0"},
                                                   {"super_voxel_2011/32", "#7ea3cc"},
                                                   {"super_voxel_2011/64", "#afc7e2"},
                                                   {"tyndall", "#b03048"}};

std::string color(const std::string& sampler) {
  const auto found = colors.find(sampler);
  return found == colors.end() ? "#000" : found->second;
}

/// Position on a logarithmic axis from 10^low to 10^high.
double at(double value, double low, double high, double length) {
  return length * (std::log10(std::max(value, 1e-300)) - low) / (high - low);
}

std::string title(const Case& c) {
  return fmt::format("Table {}: {}, {}&sup3;", c.table, c.scene, c.effective_resolution());
}

std::string bars(const std::vector<Result>& rows) {
  double low = 1e300, high = 0;
  for (const Result& r : rows) {
    low = std::min(low, r.photons_per_second.least);
    high = std::max(high, r.photons_per_second.most);
  }
  low = std::floor(std::log10(low)) - 0.2, high = std::ceil(std::log10(high));
  const int height = 24 * static_cast<int>(rows.size()) + 24;
  std::string svg = fmt::format("<svg viewBox='0 0 760 {}' width='760'>", height);
  for (double decade = std::ceil(low); decade <= high; ++decade) {
    const double x = 170 + at(std::pow(10, decade), low, high, 470);
    svg += fmt::format(
        "<line x1='{0:.1f}' x2='{0:.1f}' y1='0' y2='{1}' stroke='#ddd'/><text x='{0:.1f}' "
        "y='{2}' text-anchor='middle'>10^{3:.0f}</text>",
        x, height - 20, height - 6, decade);
  }
  double y = 2;
  for (const Result& r : rows) {
    const double width = at(r.photons_per_second.median, low, high, 470);
    svg += fmt::format(
        "<text x='165' y='{:.1f}' text-anchor='end'>{}</text><rect x='170' y='{:.1f}' "
        "width='{:.1f}' "
        "height='18' fill='{}'/><text x='{:.1f}' y='{:.1f}'>{:.3g} /s</text>",
        y + 14, r.sampler, y, width, color(r.sampler), 176 + width, y + 14,
        r.photons_per_second.median);
    y += 24;
  }
  return svg + "</svg>";
}

/// Photons per second over the effective resolution, both logarithmic.
std::string scaling(const std::vector<Result>& rows) {
  std::map<std::string, std::map<int, double>> lines;
  double low = 1e300, high = 0;
  for (const Result& r : rows) {
    lines[r.sampler][r.which.octaves] = r.photons_per_second.median;
    low = std::min(low, r.photons_per_second.median);
    high = std::max(high, r.photons_per_second.median);
  }
  low = std::floor(std::log10(low)), high = std::ceil(std::log10(high));
  const auto x = [](int octaves) { return 60.0 + 70.0 * (octaves - 8); };
  const auto y = [&](double rate) { return 300 - at(rate, low, high, 280); };
  std::string svg = "<svg viewBox='0 0 760 340' width='760'>";
  for (double decade = low; decade <= high; ++decade) {
    svg += fmt::format(
        "<line x1='60' x2='550' y1='{0:.1f}' y2='{0:.1f}' stroke='#ddd'/><text x='54' "
        "y='{0:.1f}' text-anchor='end'>10^{1:.0f}</text>",
        y(std::pow(10, decade)), decade);
  }
  for (const int octaves : {8, 9, 11, 12, 13, 15})
    svg += fmt::format("<text x='{:.1f}' y='320' text-anchor='middle'>{}&sup3;</text>", x(octaves),
                       1 << octaves);
  for (const auto& [sampler, points] : lines) {
    std::string path, dots;
    for (const auto& [octaves, rate] : points) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x(octaves), y(rate));
      dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>", x(octaves), y(rate),
                          color(sampler));
    }
    svg += fmt::format(
        "<path d='{}' fill='none' stroke='{}' stroke-width='2'/>{}<text x='{:.1f}' "
        "y='{:.1f}' fill='{}'>{}</text>",
        path, color(sampler), dots, x(points.rbegin()->first) + 8, y(points.rbegin()->second) + 4,
        color(sampler), sampler);
  }
  return svg + "</svg>";
}

}  // namespace

std::string page(const std::vector<Result>& results) {
  std::string body;
  for (const char* scene : {"LV", "HV"}) {
    std::vector<Result> rows;
    for (const Result& r : results)
      if (r.which.table == 2 && r.which.scene == scene) rows.push_back(r);
    if (!rows.empty())
      body += fmt::format("<h2>{}: photons per second over the resolution</h2>{}", scene,
                          scaling(rows));
  }
  for (std::size_t i = 0; i < results.size();) {
    std::size_t end = i;
    const auto same = [&](const Result& r) {
      return r.which.table == results[i].which.table && r.which.scene == results[i].which.scene
             && r.which.octaves == results[i].which.octaves;
    };
    while (end < results.size() && same(results[end])) ++end;
    const std::vector<Result> rows(results.begin() + static_cast<std::ptrdiff_t>(i),
                                   results.begin() + static_cast<std::ptrdiff_t>(end));
    body += fmt::format("<h2>{}</h2>{}", title(results[i].which), bars(rows));
    i = end;
  }
  return "<!doctype html><meta charset='utf-8'><title>tyndall-bench</title><style>body{font:14px "
         "sans-serif;margin:2em;max-width:800px}svg text{font:12px sans-serif}h2{font-size:16px}"
         "</style><h1>Photons per second</h1><p>Axes are logarithmic. Bars are medians of "
         "interleaved repeats.</p>"
         + body + "\n";
}

}  // namespace tyndall::bench
