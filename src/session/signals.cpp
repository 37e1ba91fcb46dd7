#include "session/signals.h"

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <ctime>

#include "io/output_file.h"

namespace tyndall::session {
namespace {

// Read by all threads. A signal handler may use only lock-free atomics.
std::atomic<int> caught = 0, leaving = 0, wanted = 0, resting = 0;
static_assert(std::atomic<int>::is_always_lock_free);

[[noreturn]] void leave(int signal) {
  io::remove_temporaries();
  ::_exit(128 + signal);
}

/// Ends the program if the render does not stop in time: one photon may walk for minutes.
timer_t patience;
itimerspec as_long{};

extern "C" void on_signal(int signal) {
  if (caught != 0 || leaving != 0) leave(signal);
  caught = signal;
  if (resting == 0 && ::timer_settime(patience, 0, &as_long, nullptr) != 0)
    ::alarm(1);  // the system gave no timer
}

extern "C" void on_timeout(int) {
  constexpr char message[] =
      "tyndall: stopped by a signal in the midst of a batch; nothing more was written\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message, sizeof message - 1);
  leave(caught);
}

extern "C" void on_request(int) { wanted = 1; }

}  // namespace

void catch_signals(double seconds) {
  as_long.it_value.tv_sec = static_cast<time_t>(seconds);
  as_long.it_value.tv_nsec = static_cast<long>(1e9 * std::fmod(seconds, 1.0));
  struct sigaction timeout {};
  timeout.sa_handler = on_timeout;
  ::sigaction(SIGALRM, &timeout, nullptr);
  ::timer_create(CLOCK_MONOTONIC, nullptr, &patience);  // sends SIGALRM
  struct sigaction action {};
  action.sa_handler = on_signal;
  // No SA_RESTART: a blocking call (a pipe without a reader) fails instead.
  for (int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  struct sigaction hangup {};
  ::sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);  // not under nohup
  std::signal(SIGPIPE, SIG_IGN);
}

void expect_requests() {
  struct sigaction request {};
  request.sa_handler = on_request;
  request.sa_flags = SA_RESTART;
  ::sigaction(SIGUSR1, &request, nullptr);
}

bool is_cut_short() noexcept { return caught != 0 && resting == 0; }

void end_patience() noexcept {
  resting = 1;
  constexpr itimerspec never{};
  ::timer_settime(patience, 0, &never, nullptr);
}

bool take_request_for_picture() noexcept { return wanted.exchange(0) != 0; }

void ignore_signals() {
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) std::signal(signal, SIG_IGN);
}

void leave_on_signal() noexcept { leaving = 1; }

int end_catching(int code) noexcept {
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    ::sigaction(signal, nullptr, &action);
    if (action.sa_handler == on_signal) std::signal(signal, SIG_DFL);
  }
  return code == 0 && caught != 0 ? 128 + caught : code;
}

int caught_signal() noexcept { return caught; }

}  // namespace tyndall::session
