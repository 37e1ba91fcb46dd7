/// \file
/// Instances of the measurement passes.
#include "kernels.cuh"
#include "tyndall/transport/depth.h"

namespace tyndall {

#define TYNDALL_INSTANTIATE(Medium)                                                         \
  template std::uint64_t run_pass(const MatterPass<Medium>&, IndexRange, const Interrupts&, \
                                  Scratch&, std::uint64_t);                                 \
  template std::uint64_t run_pass(const DepthPass<Medium>&, IndexRange, const Interrupts&,  \
                                  Scratch&, std::uint64_t);
#define TYNDALL_INSTANTIATE_SINGLE(Field, name) TYNDALL_INSTANTIATE(SingleMedium<Field>)
TYN_FOR_EACH_FIELD(TYNDALL_INSTANTIATE_SINGLE)
TYNDALL_INSTANTIATE(MixedMedium)

void require_kernels() {
  cudaFuncAttributes attributes;
  require(cudaFuncGetAttributes(&attributes, run_indices<DepthPass<SingleMedium<Solid>>>),
          "looking for code for this device (CMAKE_CUDA_ARCHITECTURES)");
}

}  // namespace tyndall
