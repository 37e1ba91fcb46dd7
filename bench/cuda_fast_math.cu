// The kernel of `tyndall` compiled with --use_fast_math, to measure the cost of strict arithmetic.
#include "cuda_row.cuh"
#include "cuda_rows.h"

namespace tyndall::bench {
namespace {

/// A separate type, so that the linker keeps its kernel apart from that of SuperVoxel.
struct FastMath : SuperVoxel {};

}  // namespace

std::unique_ptr<Row> fast_math_cuda_row(Stage& stage) {
  return std::make_unique<CudaRow<FastMath>>("tyndall/fast_math", stage.usual, FastMath{});
}

}  // namespace tyndall::bench
