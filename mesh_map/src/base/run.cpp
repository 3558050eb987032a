#include "base/run.h"

#include <algorithm>

namespace mesh_map {

namespace {

/// Smaller steps are not told.
constexpr double STEP = 0.01;

}  // namespace

void Run::loop(std::size_t count, std::size_t chunk, double share,
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

void Run::advance(double share)
{
  if (options_.progress) {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = std::min(done_ + share, 1.0);
    if (done_ >= told_ + STEP && done_ < 1.0) {
      told_ = done_;
      options_.progress(done_);
    }
  }
}

void Run::finish()
{
  check();
  if (options_.progress) {
    options_.progress(1.0);
  }
}

}  // namespace mesh_map
