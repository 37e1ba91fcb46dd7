#include "kernels.cuh"
#include "tyndall/transport/depth.h"

namespace tyndall {

#define TYNDALL_INSTANTIATE(Medium)                                                         \
  template std::uint64_t run_pass(const MatterPass<Medium>&, IndexRange, const Interrupts&, \
                                  std::uint64_t);                                           \
  template std::uint64_t run_pass(const DepthPass<Medium>&, IndexRange, const Interrupts&,  \
                                  std::uint64_t)
TYNDALL_FOR_ALL_MEDIA(TYNDALL_INSTANTIATE);

}  // namespace tyndall
