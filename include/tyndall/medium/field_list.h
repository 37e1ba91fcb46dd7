/// \file
/// The types of fields. AnyField, AnyMedium, the declarations of the bounds, the SIMD lanes and the
/// CUDA kernels (src/CMakeLists.txt reads the lines) follow from this list.
#pragma once

#include "tyndall/medium/dense_grid.h"
#include "tyndall/medium/noise_cloud.h"
#include "tyndall/medium/solid.h"
#include "tyndall/medium/sparse_grid.h"

/// Calls X(type, name) for each type of field; `name` is its member of AnyField.
#define TYN_FOR_EACH_FIELD(X) \
  X(Solid, solid)             \
  X(NoiseCloud, noise_cloud)  \
  X(DenseGrid, dense_grid)    \
  X(SparseGrid, sparse_grid)
