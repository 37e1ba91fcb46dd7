/// \file
/// Checks of every backend: renders that are observed, interrupted and resumed, in pieces of all
/// sizes, give the results of one undisturbed render on the CPU.
#pragma once

#include <functional>
#include <memory>

#include "tyndall/render/backend.h"

namespace tyndall::test {

using MakeBackend = std::function<std::unique_ptr<Backend>()>;

/// Takes the tallies after each batch and reads the light so far.
void expect_whole_when_looked_at(const MakeBackend& make);
/// Changes the camera (Renderer::look): a larger picture, a crop, a lens.
void expect_same_through_other_cameras(const MakeBackend& make);
/// Uses ray marching, with more flights than a device has lanes, in batches, and along paths.
void expect_same_in_fixed_steps(const MakeBackend& make);
/// Traces more paths than a device holds at once, with pauses.
void expect_same_of_many_paths(const MakeBackend& make);

}  // namespace tyndall::test
