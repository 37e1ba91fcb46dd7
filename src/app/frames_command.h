/// \file
/// `tyndall render --frames`: the pictures of a sequence, one after the other.
#pragma once

#include "app/render_command.h"

namespace tyndall::app {

/// \return the text with runs of two or more # as the frame's number, with as many digits at least,
/// "{frame}" as its number and "{t}" as the share of the sequence before it.
std::string of_frame(const std::string& text, int frame, double t);

/// Renders arguments.frames. Frames whose pictures are there are left out, so that the same line
/// goes on after a stop; where only the camera moves the photons are shot once.
/// \throws Error, Stopped
ExitCode frames_command(const RenderArguments& arguments);

}  // namespace tyndall::app
