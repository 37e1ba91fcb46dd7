#include "kernels.cuh"

namespace tyndall {

#define TYNDALL_INSTANTIATE(Medium)                                                   \
  template std::uint64_t run_pass(const GatherPass<Medium, SuperVoxel>&, IndexRange,  \
                                  const Interrupts&, std::uint64_t);                  \
  template std::uint64_t run_pass(const GatherPass<Medium, Woodcock>&, IndexRange,    \
                                  const Interrupts&, std::uint64_t);                  \
  template std::uint64_t run_pass(const GatherPass<Medium, RayMarching>&, IndexRange, \
                                  const Interrupts&, std::uint64_t)
TYNDALL_FOR_ALL_MEDIA(TYNDALL_INSTANTIATE);

}  // namespace tyndall
