#include "bindings/bindings.h"

#include <pthread.h>
#include <unistd.h>
#include <csignal>
#include <cstdio>
#include <thread>

#include <cerrno>
#include <chrono>

namespace mesh_map {
namespace {

/// Waits for SIGINT or SIGTERM on a pipe, to which Python's handler writes in whatever thread it
/// interrupts; then ends the process when its time is over. It needs nothing of Python, whose lock
/// may be held for ever by a plugin in native code.
void endAfterSignal(int pipe, double seconds)
{
  unsigned char number = 0;
  while (number != SIGINT && number != SIGTERM) {
    const ssize_t count = read(pipe, &number, 1);
    if (count == 0 || (count < 0 && errno != EINTR)) {
      return;
    }
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  std::fprintf(stderr,
               "error: something, perhaps a plugin, has kept process %d for %g s from its end on "
               "signal %d: ended without it\n",
               static_cast<int>(getpid()), seconds, static_cast<int>(number));
  _exit(128 + number);
}

void startEndWatch(int pipe, double seconds)
{
  // Signals are for the other threads: those of Python's main thread end its waiting.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread(endAfterSignal, pipe, seconds).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace

void bindSignals(py::module_& module)
{
  module.def("_start_end_watch", &startEndWatch);
}

}  // namespace mesh_map
