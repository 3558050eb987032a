#include <mesh_map/base/parallel.h>

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

namespace mesh_map {
namespace {

constexpr int BACKGROUND_NICENESS = 10;  // above that of the process: a tenth of a contested core

thread_local bool in_background = false;

/// Linux has a niceness for each thread; elsewhere, and where it cannot be set, nothing happens.
void lowerPriority()
{
#ifdef __linux__
  const auto self = static_cast<id_t>(syscall(SYS_gettid));
  const int niceness = getpriority(PRIO_PROCESS, self) + BACKGROUND_NICENESS;
  setpriority(PRIO_PROCESS, self, niceness);
#endif
}

}  // namespace

BackgroundLoops::BackgroundLoops() : before_(in_background)
{
  in_background = true;
}

BackgroundLoops::~BackgroundLoops()
{
  in_background = before_;
}

unsigned resolveThreads(unsigned requested)
{
  return requested > 0 ? requested : std::max(1u, std::thread::hardware_concurrency());
}

void parallelFor(std::size_t count, std::size_t chunk, unsigned threads,
                 const std::function<RangeBody()>& make_worker)
{
  if (count == 0) {
    return;
  }
  chunk = std::max<std::size_t>(chunk, 1);
  const std::size_t chunks = (count + chunk - 1) / chunk;
  const std::size_t workers = std::min<std::size_t>(resolveThreads(threads), chunks);

  std::atomic<std::size_t> next_chunk{0};
  std::mutex error_mutex;
  std::exception_ptr error;
  const auto work = [&]() {
    try {
      const RangeBody body = make_worker();
      for (std::size_t i = next_chunk++; i < chunks; i = next_chunk++) {
        body(i * chunk, std::min(count, (i + 1) * chunk));
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(error_mutex);
      error = error ? error : std::current_exception();
      next_chunk = chunks;
    }
  };

  const bool background = in_background;
  const std::size_t helpers = background ? workers : workers - 1;
  std::vector<std::thread> others;
  others.reserve(helpers);
  try {
    while (others.size() < helpers) {
      others.emplace_back([&]() {
        if (background) {
          lowerPriority();
        }
        work();
      });
    }
  } catch (const std::exception&) {
    // No more threads (std::system_error) or no memory for them (std::bad_alloc): those that run,
    // and this one, take all chunks.
  }
  if (others.empty() || !background) {
    work();
  }
  for (std::thread& thread : others) {
    thread.join();
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

void parallelJobs(const std::vector<std::function<void()>>& jobs, unsigned threads)
{
  parallelEach(jobs.size(), 1, threads, [&jobs](std::size_t i) { jobs[i](); });
}

}  // namespace mesh_map
