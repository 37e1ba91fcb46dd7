#include "kernels.cuh"

namespace tyndall {

#define TYNDALL_INSTANTIATE(Medium)                                                       \
  template void run_pass(const GatherPass<Medium, SuperVoxel>&, IndexRange, const Stop&); \
  template void run_pass(const GatherPass<Medium, Woodcock>&, IndexRange, const Stop&);   \
  template void run_pass(const GatherPass<Medium, RayMarching>&, IndexRange, const Stop&)
TYNDALL_FOR_ALL_MEDIA(TYNDALL_INSTANTIATE);

}  // namespace tyndall
