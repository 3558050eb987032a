#pragma once

#include <mesh_map/base/parallel.h>
#include <mesh_map/base/run_options.h>

#include <cstddef>
#include <functional>
#include <mutex>

namespace mesh_map {

/// A long computation: its threads, whether it is canceled, how far it is.
class Run
{
 public:
  explicit Run(const BvhOptions& options) : options_(options) {}

  /// Throws Canceled where that was asked for.
  void check() const
  {
    if (isSet(options_.cancel)) {
      throw Canceled();
    }
  }

  /// A loop over [0, count) in chunks on all threads that takes this share of the whole run.
  void loop(std::size_t count, std::size_t chunk, double share,
            const std::function<RangeBody()>& make_worker);

  /// Calls body(i) for each item of such a loop. The body is copied into each thread.
  template <class Body>
  void each(std::size_t count, std::size_t chunk, double share, const Body& body)
  {
    loop(count, chunk, share, [&body]() -> RangeBody {
      return [body](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          body(i);
        }
      };
    });
  }

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
