#ifndef MESH_MSGS_HDF5_SRC_PARALLEL_H
#define MESH_MSGS_HDF5_SRC_PARALLEL_H

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace mesh_msgs_hdf5 {

/// Threads at most, whatever the machine has: beyond that, memory is the limit.
constexpr unsigned MOST_THREADS = 8;

/// Calls worker(i) once for each i below count, on `threads` threads (0 = as many as there are
/// cores). make_worker() is called in each thread, so that a worker can own its scratch memory.
/// All threads have ended when this returns. The first exception is rethrown then; where the system
/// gives no more threads, the ones that run do the work.
template <class MakeWorker>
void forEach(std::size_t count, unsigned threads, const MakeWorker& make_worker)
{
  if (threads == 0) {
    threads = std::max(1u, std::thread::hardware_concurrency());
  }
  const std::size_t workers = std::min<std::size_t>({threads, MOST_THREADS, count});
  std::atomic<std::size_t> next{0};
  std::mutex error_mutex;
  std::exception_ptr error;
  const auto work = [&]() {
    try {
      auto worker = make_worker();
      for (std::size_t i = next++; i < count; i = next++) {
        worker(i);
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(error_mutex);
      error = error ? error : std::current_exception();
      next = count;
    }
  };

  std::vector<std::thread> others;
  others.reserve(workers);
  try {
    while (others.size() + 1 < workers) {
      others.emplace_back(work);
    }
  } catch (const std::system_error&) {
    // The ones that run, and this one, take all.
  }
  work();
  for (std::thread& thread : others) {
    thread.join();
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

}  // namespace mesh_msgs_hdf5

#endif  // MESH_MSGS_HDF5_SRC_PARALLEL_H
