/// \file
/// `tyndall render --frames`: renders the pictures of a sequence, one after the other.
#pragma once

#include <string>

#include "app/render_arguments.h"
#include "tyndall/render/error.h"

namespace tyndall::app {

/// \return `text` with runs of two or more # replaced by the frame's number with at least as many
/// digits, "{frame}" by its number, and "{t}" by `t`, the fraction of the sequence before it.
std::string of_frame(const std::string& text, int frame, double t);

/// Reads the scenes of `range` and reports the errors of each.
/// \return as render_frames() \throws Error for an error of all frames
ExitCode validate_frames(const SceneArguments& arguments, const FrameRange& range);

/// Renders arguments.frames. Skips frames whose pictures exist, so the same command resumes a
/// stopped sequence. Shoots the photons once if only the camera moves. Skips unreadable frames and
/// lists them at the end.
/// \return done; input_missing or scene_invalid if frames could not be read; 128 + the signal
/// \throws Error, Stopped
ExitCode render_frames(const RenderArguments& arguments);

}  // namespace tyndall::app
