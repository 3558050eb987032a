#include <mesh_map/wave_front.h>

#include <mesh_map/parallel.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "wave_front_spread.h"

namespace mesh_map {
namespace {

constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 4096;

/// Width of a bucket in mean edges: in wider ones, more labels are lowered again.
constexpr double WIDTH = 0.35;

void require(bool condition, const std::string& message)
{
  if (!condition) {
    throw std::invalid_argument(message);
  }
}

bool isSet(const std::atomic<bool>* cancel)
{
  return cancel != nullptr && cancel->load();
}

/// The middle one of a sample of those that are open and above 0, for the width of buckets.
double middleSlowness(ArrayView<float> slowness)
{
  std::vector<float> sample;
  for (std::size_t v = 0; v < slowness.size(); v += slowness.size() / 4096 + 1) {
    if (slowness[v] > 0.0f && slowness[v] < std::numeric_limits<float>::infinity()) {
      sample.push_back(slowness[v]);
    }
  }
  if (sample.empty()) {
    return 1.0;
  }
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
  std::nth_element(sample.begin(), middle, sample.end());
  return *middle;
}

/// One stretch of a front.
template <bool HAS_COSTS>
class Run
{
 public:
  Run(const FrontMesh& mesh, WaveFrontBuffers& buffers, ArrayView<float> slowness,
      const WaveFrontStop& stop)
      : mesh_(mesh),
        buffers_(buffers),
        slowness_(slowness),
        spread_(mesh, buffers, slowness),
        stop_(stop)
  {
  }

  /// What has to be final, by the labels so far: infinite while a target has none.
  double wanted()
  {
    if (stop_.targets.empty()) {
      return stop_.max_distance;
    }
    double farthest = 0.0;
    for (; first_open_ < stop_.targets.size(); ++first_open_) {
      if (buffers_.labels[stop_.targets[first_open_]] == NOT_REACHED) {
        return stop_.max_distance;
      }
    }
    for (const std::uint32_t v : stop_.targets) {
      farthest = std::max(farthest, buffers_.labels[v]);
    }
    return std::min(stop_.max_distance, farthest + stop_.offset);
  }

  /// False if it was cancelled. `limit` becomes what is final then.
  bool march(double& limit)
  {
    WaveFrontQueue& queue = buffers_.queue;
    double next_look = 0.0;
    for (std::uint32_t steps = 1; queue.open();) {
      if (queue.floor() >= next_look && isEnough(limit, next_look)) {
        return true;
      }
      for (WaveFrontEntry entry; queue.pop(entry); ++steps) {
        spread_.prefetch();
        if (entry.label == buffers_.labels[entry.vertex]) {
          spread_.push(entry.vertex);
        }
        if (steps % STEPS_PER_CANCEL_CHECK == 0 && isSet(stop_.cancel)) {
          return false;
        }
      }
    }
    double farthest = 0.0;
    for (const std::uint32_t v : buffers_.touched) {
      farthest = std::max(farthest, buffers_.labels[v] < NOT_REACHED ? buffers_.labels[v] : 0.0);
    }
    limit = farthest <= stop_.max_distance ? NOT_REACHED : std::max(limit, stop_.max_distance);
    return true;
  }

 private:
  bool isEnough(double& limit, double& next_look)
  {
    const double enough = wanted();
    const double floor = buffers_.queue.floor();
    if (floor < enough) {
      next_look = first_open_ < stop_.targets.size() ? floor : enough;
      return false;
    }
    const double reached = finalLimit<HAS_COSTS>(mesh_, buffers_, slowness_);
    next_look = floor + (enough - reached);
    if (reached < enough) {
      return false;
    }
    limit = std::max(limit, std::min(reached, stop_.max_distance));
    return true;
  }

  const FrontMesh& mesh_;
  WaveFrontBuffers& buffers_;
  ArrayView<float> slowness_;
  WaveFrontSpread<HAS_COSTS> spread_;
  const WaveFrontStop& stop_;
  std::size_t first_open_ = 0;  // target that was not yet reached when it was looked at last
};

template <bool HAS_COSTS>
bool march(const FrontMesh& mesh, WaveFrontBuffers& buffers, ArrayView<float> slowness,
           const WaveFrontStop& stop, double& limit)
{
  Run<HAS_COSTS> run(mesh, buffers, slowness, stop);
  if (run.wanted() <= limit) {
    return true;
  }
  return !isSet(stop.cancel) && run.march(limit);
}

}  // namespace

WaveFrontField::WaveFrontField(std::shared_ptr<WaveFrontPool> pool,
                               std::vector<WaveFrontSeed> seeds, ArrayView<float> slowness)
    : pool_(std::move(pool)), seeds_(std::move(seeds))
{
  checkSlowness(slowness, {});
  prepareSeeds();
  buffers_ = pool_->take();
  start(slowness);
}

WaveFrontField::~WaveFrontField()
{
  pool_->giveBack(std::move(buffers_));
}

void WaveFrontField::checkSlowness(ArrayView<float> slowness,
                                   ArrayView<std::uint32_t> changed) const
{
  const std::size_t count = pool_->mesh().vertexCount();
  require(slowness.empty() || slowness.size() == count,
          "there are " + std::to_string(slowness.size()) + " values of slowness for " +
              std::to_string(count) + " vertices");
  const auto is_negative = [](float s) { return s < 0.0f; };
  const auto* wrong = slowness.end();
  if (changed.empty()) {
    bool any = false;  // in a loop without an end in between, which is fast
    for (const float s : slowness) {
      any |= is_negative(s);
    }
    wrong = any ? std::find_if(slowness.begin(), slowness.end(), is_negative) : wrong;
  }
  for (const std::uint32_t v : changed) {
    require(v < count, "changed vertex " + std::to_string(v) + " does not exist");
    if (!slowness.empty() && is_negative(slowness[v])) {
      wrong = &slowness[v];
      break;
    }
  }
  require(wrong == slowness.end(),
          "the slowness of vertex " + std::to_string(wrong - slowness.begin()) + " is negative");
}

void WaveFrontField::prepareSeeds()
{
  for (std::size_t i = 0; i < seeds_.size(); ++i) {
    require(seeds_[i].vertex < pool_->mesh().vertexCount(),
            "source vertex " + std::to_string(seeds_[i].vertex) + " does not exist");
    require(seeds_[i].label >= 0.0 && seeds_[i].label < NOT_REACHED,
            "the distance of source " + std::to_string(i) + " has to be finite and 0 or more");
  }
  std::sort(seeds_.begin(), seeds_.end(), [](const WaveFrontSeed& a, const WaveFrontSeed& b) {
    return std::tie(a.vertex, a.label) < std::tie(b.vertex, b.label);
  });
}

void WaveFrontField::start(ArrayView<float> slowness)
{
  buffers_->queue.reset(WIDTH * pool_->mesh().meanEdge() * middleSlowness(slowness));
  WaveFrontSpread<false> spread(pool_->mesh(), *buffers_, slowness);
  for (const WaveFrontSeed& seed : seeds_) {
    if (slowness.empty() || slowness[seed.vertex] < NOT_REACHED) {
      spread.offer(seed.vertex, seed.label);
    }
  }
  limit_ = -1.0;
}

bool WaveFrontField::extend(ArrayView<float> slowness, const WaveFrontStop& stop)
{
  require(stop.offset >= 0.0 && stop.offset < NOT_REACHED,
          "the offset has to be finite and 0 or more");
  require(stop.max_distance >= 0.0, "the maximum distance has to be 0 or more");
  for (const std::uint32_t v : stop.targets) {
    require(v < pool_->mesh().vertexCount(),
            "target vertex " + std::to_string(v) + " does not exist");
  }
  Update done;
  return (is_mended_ || mend(slowness, stop.cancel, done)) && run(slowness, stop);
}

bool WaveFrontField::run(ArrayView<float> slowness, const WaveFrontStop& stop)
{
  const FrontMesh& mesh = pool_->mesh();
  return slowness.empty() ? march<false>(mesh, *buffers_, slowness, stop, limit_)
                          : march<true>(mesh, *buffers_, slowness, stop, limit_);
}

ArrayView<double> WaveFrontField::labels() const
{
  return {buffers_->labels.data(), buffers_->labels.size()};
}

void WaveFrontField::writePotential(float* potential, unsigned threads) const
{
  const double* const labels = buffers_->labels.data();
  const double final = limit();
  parallelFor(buffers_->labels.size(), 1 << 16, threads, [&]() -> RangeBody {
    return [=](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        potential[v] = labels[v] <= final ? static_cast<float>(labels[v])
                                          : std::numeric_limits<float>::infinity();
      }
    };
  });
}

}  // namespace mesh_map
