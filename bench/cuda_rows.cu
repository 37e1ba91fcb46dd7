#include "cuda_row.cuh"
#include "cuda_rows.h"
#include "samplers.h"

namespace tyndall::bench {

std::vector<std::unique_ptr<Row>> published_cuda_rows(Stage& stage) {
  std::vector<std::unique_ptr<Row>> rows;
  const auto add_row = [&](const char* name, const PreparedScene& scene, auto sampler) {
    rows.push_back(std::make_unique<CudaRow<decltype(sampler)>>(name, scene, sampler));
  };
  add_row("ray_marching", stage.scene16, RayMarching{finest_voxel(stage.which)});
  add_row("woodcock", stage.scene16, Woodcock2011{});
  add_row("super_voxel_2011", stage.scene16, SuperVoxel2011{});
  add_row("super_voxel_2011/32", stage.scene32, SuperVoxel2011{});
  add_row("super_voxel_2011/64", stage.scene64, SuperVoxel2011{});
  return rows;
}

}  // namespace tyndall::bench
