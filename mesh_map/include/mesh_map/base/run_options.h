#pragma once

#include <atomic>
#include <functional>
#include <stdexcept>

namespace mesh_map {

/// Thrown out of a build or a batch of queries whose cancel flag was set.
class Canceled : public std::runtime_error
{
 public:
  Canceled() : std::runtime_error("cancelled") {}
};

/// Whether something that may be canceled (not null) is.
inline bool isSet(const std::atomic<bool>* cancel)
{
  return cancel != nullptr && cancel->load(std::memory_order_relaxed);
}

/// How to run something long.
struct BvhOptions
{
  unsigned threads = 0;                           ///< 0: all cores
  const std::atomic<bool>* cancel = nullptr;      ///< looked at every few milliseconds
  std::function<void(double fraction)> progress;  ///< from 0 to 1, never falling; from any thread,
                                                  ///< one call at a time
};

}  // namespace mesh_map
