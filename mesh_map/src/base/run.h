#ifndef MESH_MAP_SRC_BASE_RUN_H
#define MESH_MAP_SRC_BASE_RUN_H

#include <mesh_map/base/parallel.h>
#include <mesh_map/base/run_options.h>

#include <cstddef>
#include <functional>
#include <mutex>

namespace mesh_map {

/// A long computation: its threads, whether it is cancelled, how far it is.
class Run
{
 public:
  explicit Run(const BvhOptions& options) : options_(options) {}

  /// Throws Cancelled where that was asked for.
  void check() const
  {
    if (options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed)) {
      throw Cancelled();
    }
  }

  /// A loop over [0, count) in chunks on all threads that takes this share of the whole run.
  void loop(std::size_t count, std::size_t chunk, double share,
            const std::function<RangeBody()>& make_worker);

  /// Says that a further share of the whole is done.
  void advance(double share);

  /// Says that all is done.
  void finish();

 private:
  const BvhOptions& options_;
  std::mutex mutex_;
  double done_ = 0.0, told_ = -1.0;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_BASE_RUN_H
