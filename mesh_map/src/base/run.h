#pragma once

#include <mesh_map/base/parallel.h>
#include <mesh_map/base/run_options.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <mutex>
#include <utility>

namespace mesh_map {

/// A long computation: its threads, whether it is canceled, how far it is.
class Run
{
 public:
  explicit Run(BvhOptions options) : options_(std::move(options)) {}

  /// How many threads its loops have at most.
  unsigned threads() const { return resolveThreads(options_.threads); }

  /// Throws Canceled where that was asked for.
  void check() const
  {
    if (isSet(options_.cancel)) {
      throw Canceled();
    }
  }

  /// A loop over [0, count) in chunks on all threads that takes this share of the whole run.
  void loop(std::size_t count, std::size_t chunk, double share,
            const std::function<RangeBody()>& make_worker)
  {
    check();
    parallelFor(count, chunk, options_.threads, [&]() -> RangeBody {
      return [this, share, count, body = make_worker()](std::size_t begin, std::size_t end) {
        check();
        body(begin, end);
        advance(share * static_cast<double>(end - begin) / static_cast<double>(count));
      };
    });
  }

  /// Calls body(i) for each item of such a loop, see eachItem().
  template <class Body>
  void each(std::size_t count, std::size_t chunk, double share, const Body& body)
  {
    loop(count, chunk, share, eachItem(body));
  }

  /// Says that a further share of the whole is done.
  void advance(double share)
  {
    constexpr double step = 0.01;  // smaller ones are not told
    if (options_.progress) {
      const std::lock_guard<std::mutex> lock(mutex_);
      done_ = std::min(done_ + share, 1.0);
      if (done_ >= told_ + step && done_ < 1.0) {
        told_ = done_;
        options_.progress(done_);
      }
    }
  }

  /// Says that all is done.
  void finish()
  {
    check();
    if (options_.progress) {
      options_.progress(1.0);
    }
  }

 private:
  const BvhOptions options_;
  std::mutex mutex_;
  double done_ = 0.0, told_ = -1.0;
};

}  // namespace mesh_map
