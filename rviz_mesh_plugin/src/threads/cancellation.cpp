#include "threads/cancellation.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <system_error>

namespace rviz_mesh_plugin {

Cancellation::Cancellation() : event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK))
{
  if (event_ < 0) {
    throw std::system_error(errno, std::generic_category(), "eventfd");
  }
}

Cancellation::~Cancellation()
{
  close(event_);
}

void Cancellation::set()
{
  flag_ = true;
  const std::uint64_t one = 1;
  // It can fail only by having been set 2^64 times before.
  [[maybe_unused]] const auto written = write(event_, &one, sizeof(one));
}

bool Cancellation::wait(int socket, short events, int milliseconds) const
{
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::milliseconds(milliseconds);
  while (true) {
    int left = -1;
    if (milliseconds >= 0) {
      const auto rest = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
      left = rest.count() > 0 ? static_cast<int>(rest.count()) : 0;
    }
    pollfd watched[] = {{event_, POLLIN, 0}, {socket, events, 0}};  // negative: ignored
    const int ready = poll(watched, 2, left);
    if (flag_) {
      throw Canceled();
    }
    if (ready < 0 && errno != EINTR) {
      throw std::system_error(errno, std::generic_category(), "poll");
    }
    if (ready > 0) {
      return true;
    }
    if (ready == 0 && milliseconds >= 0 && Clock::now() >= end) {
      return false;
    }
  }
}

}  // namespace rviz_mesh_plugin
