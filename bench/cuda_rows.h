/// \file
/// The methods as published, on a CUDA device.
#pragma once

#include <memory>
#include <vector>

#include "rows.h"

namespace tyndall::bench {

/// One thread a photon, as was usual then; defined where there is a CUDA compiler. \throws
/// Error(device)
std::vector<std::unique_ptr<Row>> published_cuda_rows(Stage& stage);

/// `tyndall` with fused, approximate and flushed arithmetic: other bits, to compare the time.
std::unique_ptr<Row> fast_math_cuda_row(Stage& stage);

}  // namespace tyndall::bench
