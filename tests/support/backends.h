/// \file
/// What every backend must come to: renders that are looked at, left and taken up in the midst, in
/// pieces of all sizes, with the results of one undisturbed render on the CPU.
#pragma once

#include <functional>
#include <memory>

#include "tyndall/render/backend.h"

namespace tyndall::test {

using MakeBackend = std::function<std::unique_ptr<Backend>()>;

/// Tallies are taken after each batch, and the light so far is looked at.
void expect_whole_when_looked_at(const MakeBackend& make);
/// From one camera to the next (Renderer::look): a larger picture, a crop, a lens.
void expect_same_through_other_cameras(const MakeBackend& make);
/// Flights of fixed steps, more of them than a device has lanes, in batches, and along paths.
void expect_same_in_fixed_steps(const MakeBackend& make);
/// More paths than wait at once on a device, paused now and then.
void expect_same_of_many_paths(const MakeBackend& make);

}  // namespace tyndall::test
