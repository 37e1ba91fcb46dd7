#include <cstdio>

#include "free_paths.h"

int main() {
  const tyndall::Scene scene = cloud_scene();
  const tyndall::PreparedScene prepared = tyndall::prepare(scene, 0);
  const auto& cloud = std::get<Cloud>(prepared.medium);
  constexpr unsigned photons = 100000;
  double sum = 0;
  unsigned through = 0;
  for (unsigned i = 0; i < photons; ++i) {
    const float length = fly(cloud, i);
    if (length > 1)
      ++through;
    else
      sum += length;
  }
  std::printf("%u photons: %u through, the others fly %.6f on average\n", photons, through,
              sum / (photons - through));
}
