/// \file
/// `tyndall render --frames`: the pictures of a sequence, one after the other.
#pragma once

#include <string>

#include "app/render_arguments.h"
#include "tyndall/render/error.h"

namespace tyndall::app {

/// \return the text with runs of two or more # as the frame's number, with as many digits at least,
/// "{frame}" as its number and "{t}" as the share of the sequence before it.
std::string of_frame(const std::string& text, int frame, double t);

/// Reads the scenes of `range`, and says what is wrong with each.
/// \return as render_frames() \throws Error where it is wrong with all of them
ExitCode validate_frames(const SceneArguments& arguments, const FrameRange& range);

/// Renders arguments.frames. Frames whose pictures are there are left out, so that the same line
/// goes on after a stop; where only the camera moves the photons are shot once. Frames that cannot
/// be read are left out, too, and listed at the end.
/// \return done; input_missing or scene_invalid where frames could not be read; 128 and the signal
/// \throws Error, Stopped
ExitCode render_frames(const RenderArguments& arguments);

}  // namespace tyndall::app
