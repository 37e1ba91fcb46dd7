#include "app/failure.h"

#include <exception>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "session/console.h"
#include "session/signals.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"

namespace tyndall::app {
namespace {

int fail(std::string_view who, ExitCode code, std::string_view message) {
  // Messages about a scene start with the place in its file, for editors to jump to.
  const char* prefix = code == ExitCode::scene_invalid && who.empty() ? "" : "tyndall: ";
  session::say(fmt::format("{}{}{}\n", prefix, who, message));
  return static_cast<int>(code);
}

}  // namespace

int report_failure(std::string_view who) {
  try {
    throw;
  } catch (const Stopped&) {
    session::say("tyndall: stopped by a signal; nothing was written\n");
    return 128 + session::caught_signal();
  } catch (const Error& error) {
    // A call that a signal interrupts fails; the signal is the reason.
    const int code = fail(who, error.code(), error.what());
    return session::is_cut_short() ? 128 + session::caught_signal() : code;
  } catch (const std::bad_alloc&) {
    return fail(who, ExitCode::out_of_memory,
                "out of memory; lower camera.resolution or the resolutions of the grids");
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::resource_unavailable_try_again)
      return fail(who, ExitCode::internal, fmt::format("internal error: {}", error.what()));
    return fail(who, ExitCode::out_of_memory,
                "the system cannot start another thread: raise its limit of processes (ulimit -u) "
                "or of memory (ulimit -v)");
  } catch (const std::exception& error) {
    return fail(who, ExitCode::internal, fmt::format("internal error: {}", error.what()));
  }
}

}  // namespace tyndall::app
