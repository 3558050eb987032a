#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace mesh_map {

/// Threads to use: `requested`, or all cores where that is 0.
unsigned resolveThreads(unsigned requested);

/// While one exists, the loops of this thread run in threads of lower priority, which leave the
/// cores to whoever else wants them, and this thread waits for them. It keeps its own priority: it
/// may hold what others wait for. To be destroyed by the thread that made it, the last one first.
class BackgroundLoops
{
 public:
  BackgroundLoops();
  ~BackgroundLoops();
  BackgroundLoops(const BackgroundLoops&) = delete;
  BackgroundLoops& operator=(const BackgroundLoops&) = delete;

 private:
  bool before_;
};

/// A worker's share of a loop: handles the items [begin, end).
using RangeBody = std::function<void(std::size_t begin, std::size_t end)>;

/// Runs [0, count) in chunks on `threads` threads (0 = all cores). `make_worker` is called once in
/// each thread, so that a worker can own its scratch memory. Chunks are handed out as workers
/// become free. The first exception of a worker is rethrown here after all have ended; where no
/// further thread can be started, the ones that run do the work.
void parallelFor(std::size_t count, std::size_t chunk, unsigned threads,
                 const std::function<RangeBody()>& make_worker);

/// Makes workers that call body(i) for each of their items. The body is copied into each thread:
/// what it captures by value is the thread's own, and pointers so captured make the loop fast.
template <class Body>
std::function<RangeBody()> eachItem(const Body& body)
{
  return [&body]() -> RangeBody {
    return [own = body](std::size_t begin, std::size_t end) mutable {
      for (std::size_t i = begin; i < end; ++i) {
        own(i);
      }
    };
  };
}

/// Calls body(i) for each item of [0, count), as parallelFor() with eachItem().
template <class Body>
void parallelEach(std::size_t count, std::size_t chunk, unsigned threads, const Body& body)
{
  parallelFor(count, chunk, threads, eachItem(body));
}

/// Runs independent jobs side by side on up to `threads` threads (0 = all cores).
void parallelJobs(const std::vector<std::function<void()>>& jobs, unsigned threads);

}  // namespace mesh_map
