#include "kernels.cuh"
#include "tyndall/transport/depth.h"

namespace tyndall {

#define TYNDALL_INSTANTIATE(Medium)                                           \
  template void run_pass(const MatterPass<Medium>&, IndexRange, const Stop&); \
  template void run_pass(const DepthPass<Medium>&, IndexRange, const Stop&)
TYNDALL_FOR_ALL_MEDIA(TYNDALL_INSTANTIATE);

}  // namespace tyndall
