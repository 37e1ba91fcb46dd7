#include "render/read_out.h"

#include "tyndall/render/huge_pages.h"

namespace tyndall {

std::vector<float> read_out_matter(const PreparedScene& scene,
                                   const std::vector<std::int64_t>& matter) {
  const Vec3f size = scene.cell_size;
  const double points = 8.0 * scene.strata * scene.strata * scene.strata;
  const double volume =
      double{size.x} * double{size.y} * double{size.z} / (points * double{scene.matter_scale});
  std::vector<float> out;
  out.reserve(matter.size());
  advise_huge_pages(out.data(), matter.size() * sizeof(float));
  for (const std::int64_t d : matter)
    out.push_back(static_cast<float>(static_cast<double>(d) * volume));
  return out;
}

void read_out_light(const std::vector<std::int64_t>& sums, double photon_power,
                    std::vector<float>& out) {
  out.clear();
  if (out.capacity() < sums.size()) {
    out.reserve(sums.size());
    advise_huge_pages(out.data(), sums.size() * sizeof(float));
  }
  for (const std::int64_t n : sums) out.push_back(light_of(n, photon_power));
}

}  // namespace tyndall
