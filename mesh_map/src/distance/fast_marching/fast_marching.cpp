#include <mesh_map/distance/fast_marching/fast_marching.h>

#include <mesh_map/base/run_options.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "base/require.h"
#include "base/unique.h"
#include "distance/fast_marching/fast_marching_repair.h"
#include "distance/fast_marching/fast_marching_triangle.h"
#include "distance/fast_marching/fast_marching_update.h"

namespace mesh_map {

namespace {

/// More than this are not kept for later.
constexpr std::size_t MAX_SPARE = 4;

}  // namespace

FastMarchingPool::FastMarchingPool(std::shared_ptr<const FastMarchingMesh> mesh)
    : mesh_(std::move(mesh))
{
}

FastMarchingPool::~FastMarchingPool() = default;

std::unique_ptr<FastMarchingBuffers> FastMarchingPool::take()
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!spare_.empty()) {
      std::unique_ptr<FastMarchingBuffers> buffers = std::move(spare_.back());
      spare_.pop_back();
      return buffers;
    }
  }
  auto buffers = std::make_unique<FastMarchingBuffers>();
  buffers->labels.assign(mesh_->vertexCount(), NOT_REACHED);
  return buffers;
}

void FastMarchingPool::giveBack(std::unique_ptr<FastMarchingBuffers> buffers)
{
  buffers->clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (spare_.size() < MAX_SPARE) {
    spare_.push_back(std::move(buffers));
  }
}

void FastMarchingBuffers::clear()
{
  if (touched.size() > labels.size() / 4) {
    std::fill(labels.begin(), labels.end(), NOT_REACHED);
  } else {
    for (const std::uint32_t v : touched) {
      labels[v] = NOT_REACHED;
    }
  }
  touched.clear();
  tasks.clear();
  ranks.clear();
  is_in_repair = false;
  queue.reset(queue.width());
}

namespace {

constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 4096;

/// Width of a bucket in mean edges: in wider ones, more labels are lowered again.
constexpr double WIDTH = 0.25;

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
  Run(const FastMarchingMesh& mesh, FastMarchingBuffers& buffers, ArrayView<float> slowness,
      const FastMarchingStop& stop)
      : mesh_(mesh),
        buffers_(buffers),
        slowness_(slowness),
        update_(mesh, buffers, slowness),
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

  /// False if it was canceled. `limit` becomes what is final then.
  bool march(double& limit)
  {
    BucketQueue<double>& queue = buffers_.queue;
    double next_look = 0.0;
    for (std::uint32_t steps = 1; queue.open();) {
      if (queue.floor() >= next_look && isEnough(limit, next_look)) {
        return true;
      }
      for (QueueEntry<double> entry; queue.pop(entry); ++steps) {
        update_.prefetch();
        if (entry.label == buffers_.labels[entry.vertex]) {
          update_.push(entry.vertex);
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

  const FastMarchingMesh& mesh_;
  FastMarchingBuffers& buffers_;
  ArrayView<float> slowness_;
  FastMarchingUpdate<HAS_COSTS> update_;
  const FastMarchingStop& stop_;
  std::size_t first_open_ = 0;  // target that was not yet reached when it was looked at last
};

/// Calls body(true_type) where there are costs, body(false_type) where all is equally slow.
template <class Body>
auto withCosts(ArrayView<float> slowness, const Body& body)
{
  return slowness.empty() ? body(std::false_type()) : body(std::true_type());
}

}  // namespace

FastMarchingField::FastMarchingField(std::shared_ptr<FastMarchingPool> pool,
                                     std::vector<FastMarchingSeed> seeds, ArrayView<float> slowness)
    : pool_(std::move(pool)), seeds_(std::move(seeds))
{
  checkSlowness(slowness, {});
  prepareSeeds();
  buffers_ = pool_->take();
  start(slowness);
}

FastMarchingField::~FastMarchingField()
{
  pool_->giveBack(std::move(buffers_));
}

void FastMarchingField::checkSlowness(ArrayView<float> slowness,
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

void FastMarchingField::prepareSeeds()
{
  for (std::size_t i = 0; i < seeds_.size(); ++i) {
    require(seeds_[i].vertex < pool_->mesh().vertexCount(),
            "source vertex " + std::to_string(seeds_[i].vertex) + " does not exist");
    require(seeds_[i].label >= 0.0 && seeds_[i].label < NOT_REACHED,
            "the distance of source " + std::to_string(i) + " has to be finite and 0 or more");
  }
  std::sort(seeds_.begin(), seeds_.end(), [](const FastMarchingSeed& a, const FastMarchingSeed& b) {
    return std::tie(a.vertex, a.label) < std::tie(b.vertex, b.label);
  });
}

void FastMarchingField::start(ArrayView<float> slowness)
{
  buffers_->queue.reset(WIDTH * pool_->mesh().meanEdge() * middleSlowness(slowness));
  FastMarchingUpdate<false> update(pool_->mesh(), *buffers_, slowness);
  for (const FastMarchingSeed& seed : seeds_) {
    if (slowness.empty() || slowness[seed.vertex] < NOT_REACHED) {
      update.offer(seed.vertex, seed.label);
    }
  }
  limit_ = -1.0;
}

bool FastMarchingField::extend(ArrayView<float> slowness, const FastMarchingStop& stop)
{
  require(stop.offset >= 0.0 && stop.offset < NOT_REACHED,
          "the offset has to be finite and 0 or more");
  require(stop.max_distance >= 0.0, "the maximum distance has to be 0 or more");
  for (const std::uint32_t v : stop.targets) {
    require(v < pool_->mesh().vertexCount(),
            "target vertex " + std::to_string(v) + " does not exist");
  }
  Update done;
  return (is_mended_ || mend(slowness, {}, stop.cancel, done)) && run(slowness, stop);
}

bool FastMarchingField::run(ArrayView<float> slowness, const FastMarchingStop& stop)
{
  return withCosts(slowness, [&](auto has_costs) {
    Run<has_costs> run(pool_->mesh(), *buffers_, slowness, stop);
    return run.wanted() <= limit_ || (!isSet(stop.cancel) && run.march(limit_));
  });
}

ArrayView<double> FastMarchingField::labels() const
{
  return {buffers_->labels.data(), buffers_->labels.size()};
}

std::vector<float> FastMarchingField::potential() const
{
  const auto finalLabel = [final = limit()](double label) {
    return label <= final ? static_cast<float>(label) : std::numeric_limits<float>::infinity();
  };
  std::vector<float> potential(buffers_->labels.size());
  std::transform(buffers_->labels.begin(), buffers_->labels.end(), potential.begin(), finalLabel);
  return potential;
}

namespace {

/// Of more changes than a part of the field, it is made anew.
constexpr std::size_t CHANGES_FOR_NEW_FIELD = 16;

/// How many different ones of this many vertices there are among some. Many are not sorted for
/// that.
std::size_t distinct(std::vector<std::uint32_t>& vertices, std::size_t count)
{
  if (vertices.size() < count / 1024) {
    makeUnique(vertices);
    return vertices.size();
  }
  std::vector<std::uint64_t> seen(count / 64 + 1);
  for (const std::uint32_t v : vertices) {
    seen[v / 64] |= std::uint64_t{1} << v % 64;
  }
  std::size_t found = 0;
  for (const std::uint64_t bits : seen) {
    found += static_cast<std::size_t>(__builtin_popcountll(bits));
  }
  return found;
}

/// Vertices whose seed is in one list and not in the other.
void addDifference(const std::vector<FastMarchingSeed>& one,
                   const std::vector<FastMarchingSeed>& other, std::vector<std::uint32_t>& vertices)
{
  for (const FastMarchingSeed& seed : one) {
    const bool is_in_both =
        std::any_of(other.begin(), other.end(), [&](const FastMarchingSeed& candidate) {
          return candidate.vertex == seed.vertex && candidate.label == seed.label;
        });
    if (!is_in_both) {
      vertices.push_back(seed.vertex);
    }
  }
}

}  // namespace

FastMarchingField::Update FastMarchingField::update(std::vector<FastMarchingSeed> seeds,
                                                    ArrayView<float> slowness,
                                                    ArrayView<std::uint32_t> changed,
                                                    const std::atomic<bool>* cancel)
{
  checkSlowness(slowness, changed);
  std::vector<FastMarchingSeed> before = std::move(seeds_);
  seeds_ = std::move(seeds);
  try {
    prepareSeeds();
  } catch (...) {
    seeds_ = std::move(before);
    throw;
  }
  std::vector<std::uint32_t> begins(changed.begin(), changed.end());
  addDifference(seeds_, before, begins);
  addDifference(before, seeds_, begins);
  makeUnique(begins);
  Update done;
  if (begins.empty() && is_mended_) {
    return done;
  }
  is_mended_ = false;
  if (begins.size() > buffers_->touched.size() / CHANGES_FOR_NEW_FIELD) {
    done.canceled = !startAgain(slowness, cancel, done);
    return done;
  }
  buffers_->is_in_repair = true;
  done.canceled = !mend(slowness, begins, cancel, done);
  return done;
}

bool FastMarchingField::mend(ArrayView<float> slowness, ArrayView<std::uint32_t> begins,
                             const std::atomic<bool>* cancel, Update& done)
{
  const FastMarchingMesh& mesh = pool_->mesh();
  const RepairEnd end = withCosts(slowness, [&](auto has_costs) {
    FastMarchingRepair<has_costs> repair(mesh, *buffers_, slowness, seeds_);
    repair.beginAround(begins);
    const RepairEnd reached = repair.run(cancel, changed_);
    done.looks = repair.looks();
    return reached;
  });
  if (end == RepairEnd::CANCELED) {
    return false;
  }
  if (end == RepairEnd::TOO_MUCH) {
    return startAgain(slowness, cancel, done);
  }
  done.count = distinct(changed_, mesh.vertexCount());
  buffers_->is_in_repair = false;
  buffers_->ranks.clear();
  is_mended_ = true;
  changed_.clear();
  if (buffers_->touched.size() > mesh.vertexCount()) {
    makeUnique(buffers_->touched);
  }
  if (buffers_->queue.open()) {
    limit_ = std::min(limit_, withCosts(slowness, [&](auto has_costs) {
                        return finalLimit<has_costs>(mesh, *buffers_, slowness);
                      }));
  }
  return true;
}

bool FastMarchingField::startAgain(ArrayView<float> slowness, const std::atomic<bool>* cancel,
                                   Update& done)
{
  FastMarchingStop stop;
  stop.max_distance = std::max(0.0, limit_);
  stop.cancel = cancel;
  buffers_->clear();
  changed_.clear();
  is_mended_ = true;
  start(slowness);
  const bool is_done = run(slowness, stop);
  done.count = buffers_->touched.size();
  return is_done;
}

}  // namespace mesh_map
