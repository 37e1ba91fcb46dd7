#include "kernels.cuh"
#include "tyndall/transport/depth.h"

namespace tyndall {

#define TYNDALL_INSTANTIATE(Medium)                                                         \
  template std::uint64_t run_pass(const MatterPass<Medium>&, IndexRange, const Interrupts&, \
                                  Scratch&, std::uint64_t);                                 \
  template std::uint64_t run_pass(const DepthPass<Medium>&, IndexRange, const Interrupts&,  \
                                  Scratch&, std::uint64_t)
TYNDALL_INSTANTIATE(SingleMedium<Solid>);
TYNDALL_INSTANTIATE(SingleMedium<NoiseCloud>);
TYNDALL_INSTANTIATE(SingleMedium<DenseGrid>);
TYNDALL_INSTANTIATE(SingleMedium<SparseGrid>);
TYNDALL_INSTANTIATE(MixedMedium);

void require_kernels() {
  cudaFuncAttributes attributes;
  require(cudaFuncGetAttributes(&attributes, run_indices<DepthPass<SingleMedium<Solid>>>),
          "looking for code for this device (CMAKE_CUDA_ARCHITECTURES)");
}

}  // namespace tyndall
