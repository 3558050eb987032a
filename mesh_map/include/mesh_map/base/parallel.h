#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace mesh_map {

/// Threads to use: `requested`, or all cores where that is 0.
unsigned resolveThreads(unsigned requested);

/// A worker's share of a loop: handles the items [begin, end).
using RangeBody = std::function<void(std::size_t begin, std::size_t end)>;

/// Runs [0, count) in chunks on `threads` threads (0 = all cores). `make_worker` is called once in
/// each thread, so that a worker can own its scratch memory. Chunks are handed out as workers
/// become free. The first exception of a worker is rethrown here after all have ended; where no
/// further thread can be started, the ones that run do the work.
void parallelFor(std::size_t count, std::size_t chunk, unsigned threads,
                 const std::function<RangeBody()>& make_worker);

/// Calls body(i) for each item of [0, count), as parallelFor(). The body is copied into each
/// thread: capture pointers by value where the loop shall be fast.
template <class Body>
void parallelEach(std::size_t count, std::size_t chunk, unsigned threads, const Body& body)
{
  parallelFor(count, chunk, threads, [&body]() -> RangeBody {
    return [body](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        body(i);
      }
    };
  });
}

/// Runs independent jobs side by side on up to `threads` threads (0 = all cores).
void parallelJobs(const std::vector<std::function<void()>>& jobs, unsigned threads);

}  // namespace mesh_map
