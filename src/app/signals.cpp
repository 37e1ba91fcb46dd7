#include "app/signals.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

#include "io/output_file.h"

namespace tyndall::app {
namespace {

// Read by all threads; without locks, as a handler must be.
std::atomic<int> caught = 0, leaving = 0;
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void on_signal(int signal) {
  if (caught != 0 || leaving != 0) {
    io::remove_temporaries();
    ::_exit(128 + signal);
  }
  caught = signal;
}

}  // namespace

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  // No SA_RESTART: a call that waits (a pipe without a reader) gives up.
  for (int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  struct sigaction hangup {};
  ::sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);  // not under nohup
  std::signal(SIGPIPE, SIG_IGN);
}

void leave_on_signal() noexcept { leaving = 1; }

int caught_signal() noexcept { return caught; }

}  // namespace tyndall::app
