/// \file
/// Paths in SIMD lanes: the walk of tyndall/transport, with each stage as a loop over many paths
/// that the compiler vectorises. The loops run the code of the plain passes, so the results are
/// identical, bit for bit.
#pragma once

#include <cstdint>
#include <string>

#include "tyndall/render/parallel.h"
#include "tyndall/transport/passes.h"

namespace tyndall {

/// Calls pass(index) for [begin, end). \pre for walks, the sides of the box are open
/// \param instruction_set see make_cpu_backend(). \throws Stopped
template <class Medium>
void run_lanes(const ShootPass<Medium, SuperVoxel>& pass, std::uint64_t begin, std::uint64_t end,
               const Stop& stop = {}, const std::string& instruction_set = {});
template <class Medium>
void run_lanes(const GatherPass<Medium, SuperVoxel>& pass, std::uint64_t begin, std::uint64_t end,
               const Stop& stop = {}, const std::string& instruction_set = {});

template <class Medium>
void run_lanes(const MatterPass<Medium>& pass, std::uint64_t begin, std::uint64_t end,
               const Stop& stop = {}, const std::string& instruction_set = {});

}  // namespace tyndall
