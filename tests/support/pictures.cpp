#include "support/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "io/pfm.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

/// Relative rounding error of a pixel's sums: the same samples can differ by it.
constexpr double rounding = 1e-6;

double welch_p(const Series& a, const Series& b) {
  const double difference = a.mean() - b.mean();
  if (std::abs(difference) <= rounding * std::abs(a.mean())) return 1;
  const double va = a.variance() / static_cast<double>(a.count()),
               vb = b.variance() / static_cast<double>(b.count());
  if (va + vb == 0) return 0;
  const double freedom = (va + vb) * (va + vb)
                         / (va * va / static_cast<double>(a.count() - 1)
                            + vb * vb / static_cast<double>(b.count() - 1));
  return student_p(difference / std::sqrt(va + vb), std::max(1, static_cast<int>(freedom)));
}

void write(const Picture& picture, const std::string& path) {
  const std::string bytes = io::encode_pfm(picture);
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
  std::printf("written: %s\n", path.c_str());
}

}  // namespace

double pictures_p(const std::vector<RenderResult>& first, const std::vector<RenderResult>& second,
                  const std::string& name, double level) {
  Picture means[3] = {first.at(0).picture, first[0].picture, first[0].picture};
  std::vector<double> p;
  for (std::size_t i = 0; i < means[0].rgba.size(); ++i) {
    const auto value = [i](const RenderResult& r) { return double{r.picture.rgba[i]}; };
    const Series a = series(first, value), b = series(second, value);
    means[0].rgba[i] = static_cast<float>(a.mean());
    means[1].rgba[i] = static_cast<float>(b.mean());
    means[2].rgba[i] = static_cast<float>(b.mean() - a.mean());
    p.push_back(welch_p(a, b));
  }
  const double all = sidak_p(p);
  if (all < level) {
    const char* build = std::getenv("TYNDALL_BUILD_DIR");
    const std::filesystem::path folder =
        std::filesystem::path(build ? build : ".") / "failed_pictures";
    std::filesystem::create_directories(folder);
    const char* suffixes[3] = {"_first.pfm", "_second.pfm", "_difference.pfm"};
    for (int i = 0; i < 3; ++i) write(means[i], (folder / (name + suffixes[i])).string());
  }
  return all;
}

}  // namespace tyndall::test
