#include "page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

namespace tyndall::bench {
namespace {

std::string color(const std::string& sampler) {
  static const std::map<std::string, const char*> colors = {
      {"ray_marching", "#777777"},        {"woodcock", "#b8651b"},
      {"woodcock_squeezed", "#8a7a1a"},   {"super_voxel_2011", "#1f4e8c"},
      {"super_voxel_2011/32", "#2f86c8"}, {"super_voxel_2011/64", "#1f9090"},
      {"tyndall/avx2", "#d98a96"},        {"tyndall", "#b03048"}};
  const auto found = colors.find(sampler);
  return found == colors.end() ? "#000" : found->second;
}

/// \return the value with three digits: "683 k".
std::string short_number(double value) {
  if (value >= 999.5e3) return fmt::format("{:.3g} M", value / 1e6);
  if (value >= 999.5) return fmt::format("{:.3g} k", value / 1e3);
  return fmt::format("{:.3g}", value);
}

/// A logarithmic axis of whole decades between two coordinates of the drawing [px].
struct Axis {
  double low, high;  ///< powers of 10
  double from, to;

  Axis(double least, double most, double begin, double end)
      : low(std::floor(std::log10(least))),
        high(std::max(std::ceil(std::log10(most)), low + 1)),
        from(begin),
        to(end) {}
  double operator()(double value) const {
    return from + (to - from) * (std::log10(value) - low) / (high - low);
  }
};

/// \return the factor of the paper's rates, which are of a GPU of 2011: it makes the rates of
/// super-voxels equal in the first row that has both. 0 if none has.
double paper_scale(const std::vector<Result>& rows) {
  for (const Result& r : rows)
    if (r.sampler == "super_voxel_2011" && r.paper > 0)
      return r.photons_per_second.median / r.paper;
  return 0;
}

/// \return the least and the greatest rate, the paper's included.
std::pair<double, double> extremes(const std::vector<Result>& rows) {
  double least = 1e300, most = 0;
  const double scale = paper_scale(rows);
  for (const Result& r : rows) {
    least = std::min(least, r.photons_per_second.least);
    most = std::max(most, r.photons_per_second.most);
    if (scale * r.paper > 0) least = std::min(least, scale * r.paper);
    most = std::max(most, scale * r.paper);
  }
  return {least, most};
}

std::string open_drawing(double height) {
  return fmt::format(
      "<svg viewBox='0 0 760 {0:.0f}' width='760' height='{0:.0f}' font-family='sans-serif' "
      "font-size='12'>",
      height);
}

std::string text(double x, double y, const char* anchor, const std::string& content,
                 const std::string& fill = "#000") {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='{}' fill='{}'>{}</text>", x, y,
                     anchor, fill, content);
}

std::string line(double x1, double y1, double x2, double y2, const char* stroke) {
  return fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='{}'/>", x1, y1,
                     x2, y2, stroke);
}

std::string diamond(double x, double y, const std::string& stroke) {
  return fmt::format("<path d='M{:.1f} {:.1f}l5 5l-5 5l-5 -5z' fill='#fff' stroke='{}'/>", x, y - 5,
                     stroke);
}

/// \param points "x,y x,y ..."
std::string polyline(const std::string& points, const std::string& stroke, const char* style) {
  return fmt::format("<polyline points='{}' fill='none' stroke='{}' {}/>", points, stroke, style);
}

/// \return a bar for each sampler of one case.
std::string bars(const std::vector<Result>& rows) {
  constexpr double step = 24;
  const double bottom = 4 + step * static_cast<double>(rows.size());
  const auto [least, most] = extremes(rows);
  const Axis x(least, most, 160, 620);
  const double scale = paper_scale(rows);
  std::string svg = open_drawing(bottom + 40);
  for (double decade = x.low; decade <= x.high; ++decade) {
    const double rate = std::pow(10, decade);
    svg += line(x(rate), 0, x(rate), bottom, "#ddd");
    svg += text(x(rate), bottom + 15, "middle", short_number(rate));
  }
  svg += text(0.5 * (x.from + x.to), bottom + 33, "middle", "photons per second");
  double y = 4;
  for (const Result& r : rows) {
    const Spread& rate = r.photons_per_second;
    svg += text(x.from - 6, y + 13, "end", r.sampler);
    svg += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='18' fill='{}' fill-opacity='0.7'/>",
        x.from, y, x(rate.median) - x.from, color(r.sampler));
    svg += line(x(rate.least), y + 9, x(rate.most), y + 9, "#000");
    if (scale * r.paper > 0) svg += diamond(x(scale * r.paper), y + 9, "#000");
    svg += text(755, y + 13, "end", short_number(rate.median));
    y += step;
  }
  return svg + "</svg>";
}

/// \return photons per second over the effective resolution, both logarithmic, as a line for each
/// sampler.
std::string scaling(const std::vector<Result>& rows) {
  const auto [least, most] = extremes(rows);
  const Axis y(least, most, 300, 24);
  const auto x = [](int octaves) { return 60 + 500 * (octaves - 8) / 7.0; };
  const double left = x(8), right = x(15), scale = paper_scale(rows);
  std::string svg = open_drawing(345);
  for (double decade = y.low; decade <= y.high; ++decade) {
    const double rate = std::pow(10, decade);
    svg += line(left, y(rate), right, y(rate), "#ddd");
    svg += text(left - 8, y(rate) + 4, "end", short_number(rate));
  }
  svg += text(5, 10, "start", "photons per second");
  svg += text(0.5 * (left + right), 340, "middle", "effective resolution");

  struct Line {
    std::string ours, papers, marks;
    double end = 0;
  };
  std::map<std::string, Line> lines;
  std::set<int> resolutions;
  for (const Result& r : rows) {
    Line& l = lines[r.sampler];
    const double at = x(r.which.octaves);
    l.end = y(r.photons_per_second.median);
    l.ours += fmt::format("{:.1f},{:.1f} ", at, l.end);
    l.marks += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>", at, l.end,
                           color(r.sampler));
    if (scale * r.paper > 0) {
      l.papers += fmt::format("{:.1f},{:.1f} ", at, y(scale * r.paper));
      l.marks += diamond(at, y(scale * r.paper), color(r.sampler));
    }
    resolutions.insert(r.which.octaves);
  }
  for (const int octaves : resolutions)
    svg += text(x(octaves), 320, "middle", fmt::format("{}&sup3;", 1 << octaves));
  std::multimap<double, std::string> names;  // by where their lines end
  for (const auto& [sampler, l] : lines) {
    svg += polyline(l.papers, color(sampler), "stroke-dasharray='5 4'");
    svg += polyline(l.ours, color(sampler), "stroke-width='2'") + l.marks;
    names.emplace(l.end, sampler);
  }
  double free = 0;  // below the names so far
  for (const auto& [end, sampler] : names) {
    free = std::max(end, free);
    svg += text(right + 12, free + 4, "start", sampler, color(sampler));
    free += 14;
  }
  return svg + "</svg>";
}

}  // namespace

std::string page(const std::vector<Result>& results) {
  // Of the second table every scene is one plot, of the others every resolution; LV before HV.
  std::map<std::tuple<int, int, bool>, std::vector<Result>> plots;
  for (const Result& r : results) {
    const Case& c = r.which;
    plots[{c.table, c.table == 2 ? 0 : c.octaves, c.scene == "HV"}].push_back(r);
  }
  std::string body;
  for (const auto& [key, rows] : plots) {
    const Case& c = rows.front().which;
    if (c.table == 2)
      body += fmt::format("<h2>Table 2: {}</h2>{}\n", c.scene, scaling(rows));
    else
      body += fmt::format("<h2>Table {}: {}, {}&sup3;</h2>{}\n", c.table, c.scene,
                          c.effective_resolution(), bars(rows));
  }
  return fmt::format(
      "<!doctype html><html lang='en'><meta charset='utf-8'><title>tyndall-bench</title>\n"
      "<style>body{{font:14px sans-serif;margin:2em;max-width:760px}}h2{{font-size:16px}}</style>\n"
      "<h1>Photons per second</h1>\n"
      "<p>{}, {} thread{}. Medians of interleaved repeats, all axes logarithmic; thin lines in the "
      "bars go from the least to the most. Diamonds are the paper's figures, scaled so that its "
      "super-voxels equal <code>super_voxel_2011</code> (in table 2 at the lowest "
      "resolution).</p>\n{}</html>\n",
      results.front().device, results.front().threads, results.front().threads == 1 ? "" : "s",
      body);
}

}  // namespace tyndall::bench
