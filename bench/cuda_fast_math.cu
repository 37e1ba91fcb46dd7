// What strict arithmetic costs: the kernel of `tyndall`, compiled with --use_fast_math.
#include "cuda_row.cuh"
#include "cuda_rows.h"

namespace tyndall::bench {
namespace {

/// Another type, so that the linker takes its kernel for another.
struct FastMath : SuperVoxel {};

}  // namespace

std::unique_ptr<Row> fast_math_cuda_row(Stage& stage) {
  return std::make_unique<CudaRow<FastMath>>("tyndall/fast_math", stage.usual, FastMath{});
}

}  // namespace tyndall::bench
