// What becomes of a front after changes of costs: labels that do not follow from others any more
// are taken back, in the order of labels, and found again. The order is that of LPA* (Koenig,
// Likhachev, Furcy, Artificial Intelligence 155, 2004): a label is only looked at when all that it
// may follow from is as it should be; so what gets the same label again takes nothing else with it.

#include <mesh_map/wave_front.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "wave_front_spread.h"

namespace mesh_map {
namespace {

/// Labels that differ by a smaller part than this are the same.
constexpr double SAME = 1e-9;

constexpr std::size_t TASKS_PER_CANCEL_CHECK = 256;

/// A label that is looked at in a repair takes about as long as two in a new field.
constexpr std::size_t LABELS_PER_CHECK = 2;

/// Of more changes than a part of the field, it is made anew.
constexpr std::size_t CHANGES_FOR_NEW_FIELD = 16;

enum class RepairEnd
{
  DONE,
  CANCELLED,
  TOO_MUCH  ///< a new field takes less time
};

template <bool HAS_COSTS>
class Repair
{
 public:
  Repair(const FrontMesh& mesh, WaveFrontBuffers& buffers, ArrayView<float> slowness,
         const std::vector<WaveFrontSeed>& seeds)
      : mesh_(mesh), buffers_(buffers), spread_(mesh, buffers, slowness), seeds_(seeds)
  {
  }

  /// What may have another label if the slowness at v, or a seed there, has changed.
  void beginAround(std::uint32_t v)
  {
    begin(v);
    for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
      begin(c->a);
      begin(c->b);
      if (c->a == c->b) {
        continue;
      }
      // The front comes across the edge (a, b) from this face, in a way that depends on v.
      for (const FrontCorner* d = mesh_.cornersBegin(c->a); d != mesh_.cornersEnd(c->a); ++d) {
        if (d->a == c->b) {
          begin(d->b);
        } else if (d->b == c->b) {
          begin(d->a);
        }
      }
    }
  }

  /// `changed`: vertices that got a label, some more than once.
  RepairEnd run(const std::atomic<bool>* cancel, std::vector<std::uint32_t>& changed)
  {
    const double front = buffers_.queue.open() ? buffers_.queue.floor() : NOT_REACHED;
    const std::size_t most = buffers_.touched.size() / LABELS_PER_CHECK;
    for (std::size_t tasks = 1; !buffers_.tasks.empty(); ++tasks) {
      if (tasks % TASKS_PER_CANCEL_CHECK == 0 && cancel != nullptr && cancel->load()) {
        return RepairEnd::CANCELLED;
      }
      if (checks_ > most || has_circle_) {
        return RepairEnd::TOO_MUCH;
      }
      const WaveFrontTask task = buffers_.takeTask();
      while (!buffers_.tasks.empty() && !(buffers_.tasks.front() > task)) {
        buffers_.takeTask();  // the same once more
      }
      if (task.kind == WaveFrontTask::CHECK) {
        check(task, changed);
      } else if (task.kind == WaveFrontTask::SETTLE) {
        settle(task);
      } else if (task.key == buffers_.labels[task.vertex]) {
        changed.push_back(task.vertex);
        if (task.key < front) {
          spread_.push(task.vertex);
        } else {
          buffers_.queue.push(task.key, task.vertex);
        }
      }
    }
    return RepairEnd::DONE;
  }

 private:
  double labelByOthers(std::uint32_t v)
  {
    ++checks_;
    double least_step = 0.0;
    double label = spread_.pull(v, least_step);
    // Two labels that are the same could follow from each other, and from nothing else.
    has_circle_ |= label < NOT_REACHED && least_step <= SAME * label;
    auto seed = std::lower_bound(
        seeds_.begin(), seeds_.end(), v,
        [](const WaveFrontSeed& one, std::uint32_t vertex) { return one.vertex < vertex; });
    if (seed != seeds_.end() && seed->vertex == v && spread_.isOpen(v)) {
      label = std::min(label, seed->label);
    }
    return label;
  }

  void begin(std::uint32_t v)
  {
    const double now = buffers_.labels[v], label = labelByOthers(v);
    if (now == NOT_REACHED) {
      settleAt(v, label);
    } else if (spread_.isAbove(now, label)) {
      spread_.offer(v, label);
    } else if (label > now * (1.0 + SAME)) {
      buffers_.addTask({now, v, WaveFrontTask::CHECK});
    }
  }

  void settleAt(std::uint32_t v, double label)
  {
    if (label < NOT_REACHED) {
      buffers_.addTask({label, v, WaveFrontTask::SETTLE});
    }
  }

  void check(const WaveFrontTask& task, std::vector<std::uint32_t>& changed)
  {
    const std::uint32_t v = task.vertex;
    if (buffers_.labels[v] != task.key) {
      return;
    }
    const double label = labelByOthers(v);
    if (label <= task.key * (1.0 + SAME)) {
      return;
    }
    buffers_.labels[v] = NOT_REACHED;
    changed.push_back(v);
    settleAt(v, label);
    for (const FrontCorner* c = mesh_.cornersBegin(v); c != mesh_.cornersEnd(v); ++c) {
      checkNext(v, c->a);
      checkNext(v, c->b);
    }
  }

  void checkNext(std::uint32_t v, std::uint32_t next)
  {
    if (next != v && buffers_.labels[next] < NOT_REACHED) {
      buffers_.addTask({buffers_.labels[next], next, WaveFrontTask::CHECK});
    }
  }

  void settle(const WaveFrontTask& task)
  {
    if (!spread_.isAbove(buffers_.labels[task.vertex], task.key)) {
      return;
    }
    const double label = labelByOthers(task.vertex);
    if (spread_.isAbove(label, task.key)) {
      settleAt(task.vertex, label);
    } else {
      spread_.offer(task.vertex, label);
    }
  }

  const FrontMesh& mesh_;
  WaveFrontBuffers& buffers_;
  WaveFrontSpread<HAS_COSTS> spread_;
  const std::vector<WaveFrontSeed>& seeds_;
  std::size_t checks_ = 0;
  bool has_circle_ = false;
};

template <bool HAS_COSTS>
void begin(const FrontMesh& mesh, WaveFrontBuffers& buffers, ArrayView<float> slowness,
           const std::vector<WaveFrontSeed>& seeds, const std::vector<std::uint32_t>& vertices)
{
  Repair<HAS_COSTS> repair(mesh, buffers, slowness, seeds);
  for (const std::uint32_t v : vertices) {
    repair.beginAround(v);
  }
}

/// Vertices whose seed is in one list and not in the other.
void addDifference(const std::vector<WaveFrontSeed>& one, const std::vector<WaveFrontSeed>& other,
                   std::vector<std::uint32_t>& vertices)
{
  for (const WaveFrontSeed& seed : one) {
    const bool is_in_both =
        std::any_of(other.begin(), other.end(), [&](const WaveFrontSeed& candidate) {
          return candidate.vertex == seed.vertex && candidate.label == seed.label;
        });
    if (!is_in_both) {
      vertices.push_back(seed.vertex);
    }
  }
}

void makeUnique(std::vector<std::uint32_t>& vertices)
{
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
}

}  // namespace

WaveFrontField::Update WaveFrontField::update(std::vector<WaveFrontSeed> seeds,
                                              ArrayView<float> slowness,
                                              ArrayView<std::uint32_t> changed,
                                              const std::atomic<bool>* cancel)
{
  const FrontMesh& mesh = pool_->mesh();
  checkSlowness(slowness, changed);
  std::vector<WaveFrontSeed> before = std::move(seeds_);
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
    done.cancelled = !startAgain(slowness, cancel, done);
    return done;
  }
  buffers_->is_in_repair = true;
  slowness.empty() ? begin<false>(mesh, *buffers_, slowness, seeds_, begins)
                   : begin<true>(mesh, *buffers_, slowness, seeds_, begins);
  done.cancelled = !mend(slowness, cancel, done);
  return done;
}

bool WaveFrontField::mend(ArrayView<float> slowness, const std::atomic<bool>* cancel, Update& done)
{
  const FrontMesh& mesh = pool_->mesh();
  const RepairEnd end = slowness.empty()
                            ? Repair<false>(mesh, *buffers_, slowness, seeds_).run(cancel, changed_)
                            : Repair<true>(mesh, *buffers_, slowness, seeds_).run(cancel, changed_);
  if (end == RepairEnd::CANCELLED) {
    return false;
  }
  if (end == RepairEnd::TOO_MUCH) {
    return startAgain(slowness, cancel, done);
  }
  buffers_->is_in_repair = false;
  is_mended_ = true;
  makeUnique(changed_);
  done.count = changed_.size();
  changed_.clear();
  if (buffers_->touched.size() > mesh.vertexCount()) {
    makeUnique(buffers_->touched);
  }
  if (buffers_->queue.open()) {
    limit_ = std::min(limit_, slowness.empty() ? finalLimit<false>(mesh, *buffers_, slowness)
                                               : finalLimit<true>(mesh, *buffers_, slowness));
  }
  return true;
}

bool WaveFrontField::startAgain(ArrayView<float> slowness, const std::atomic<bool>* cancel,
                                Update& done)
{
  WaveFrontStop stop;
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
