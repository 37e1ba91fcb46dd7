/// \file
/// SIGINT, SIGTERM and SIGHUP end a render; SIGUSR1 requests its picture.
#pragma once

namespace tyndall::session {

/// From here on the first signal is recorded, so that the render can stop in order. If it has not
/// stopped after `patience` [s], or at a second signal, the handler removes the temporaries and
/// exits immediately. SIGPIPE is ignored: writing to a closed pipe is an error.
void catch_signals(double patience = 0.6);

/// From here on all these signals are ignored.
void ignore_signals();

/// From here on the first signal exits immediately: only atomic renames are left.
void leave_on_signal() noexcept;

/// Turns off the time limit after a signal: the render has stopped in order and writes its outputs.
void end_patience() noexcept;

/// From here on SIGUSR1 requests the picture; main() ignores the signal until then.
void expect_requests();

/// \return whether SIGUSR1 has come since the last call.
bool take_request_for_picture() noexcept;

/// Restores the default actions of the signals: the last steps of the program could hang.
/// \return `code`; 128 + the signal if `code` is 0 and a signal was recorded.
int end_catching(int code) noexcept;

/// \return the number of the recorded signal; 0: none.
int caught_signal() noexcept;

/// \return whether a signal was recorded before end_patience(): it explains any failure.
bool is_cut_short() noexcept;

}  // namespace tyndall::session
