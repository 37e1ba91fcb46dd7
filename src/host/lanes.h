/// \file
/// Paths side by side: the walk of tyndall/transport, each stage of it a loop over many paths,
/// which the compiler turns into SIMD. The text in the loops is the text of the plain passes, so
/// the results are the same, bit for bit.
#pragma once

#include <cstdint>
#include <string>

#include "tyndall/render/parallel.h"
#include "tyndall/transport/passes.h"

namespace tyndall {

/// Calls pass(index) for [begin, end). Walks: in a box with open sides. \param instruction_set see
/// make_cpu_backend(). \throws Stopped
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
