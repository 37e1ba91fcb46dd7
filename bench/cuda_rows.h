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

}  // namespace tyndall::bench
