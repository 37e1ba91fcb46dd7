/// \file
/// SIGINT, SIGTERM and SIGHUP, which end a render, and SIGUSR1, which asks for its picture.
#pragma once

namespace tyndall::session {

/// From here on the first of the signals is noted, for the render to stop in order. Where it has
/// not stopped after `patience` [s], or at the second signal, the temporaries are removed and the
/// program leaves at once. SIGPIPE is ignored: a closed pipe is an error of writing.
void catch_signals(double patience = 0.6);

/// From here on none of the signals does anything.
void ignore_signals();

/// From here on the first of the signals leaves at once: what remains are a few renames, each of
/// them whole.
void leave_on_signal() noexcept;

/// The render has stopped in order: what it still has to write takes its time.
void end_patience() noexcept;

/// From here on SIGUSR1 asks for the picture: sooner it would end the program.
void expect_requests();

/// \return whether SIGUSR1 has come since the last call.
bool take_request_for_picture() noexcept;

/// From here on the signals end the program as if it had never caught them: what it does last could
/// hang. \return `code`, or that of a signal which was noted where all went well in spite of it.
int end_catching(int code) noexcept;

/// \return number of the signal that was noted, 0 for none.
int caught_signal() noexcept;

/// \return whether a signal was noted before end_patience(): then it is the reason of what fails.
bool is_cut_short() noexcept;

}  // namespace tyndall::session
