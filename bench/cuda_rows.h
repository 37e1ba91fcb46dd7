/// \file
/// The published samplers on a CUDA device.
#pragma once

#include <memory>
#include <vector>

#include "rows.h"

namespace tyndall::bench {

/// \return rows with one thread per photon, as was usual in 2011. Defined only in builds with CUDA.
/// \throws Error(device)
std::vector<std::unique_ptr<Row>> published_cuda_rows(Stage& stage);

/// \return `tyndall` with fused, approximate and flushed arithmetic: its bits differ; it compares
/// the time.
std::unique_ptr<Row> fast_math_cuda_row(Stage& stage);

}  // namespace tyndall::bench
