#pragma once

#include <mesh_map/distance/fast_marching/fast_marching.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/unique.h"
#include "distance/fast_marching/fast_marching_update.h"

namespace mesh_map {

/// How far a repair has come on its way outwards, by a sample of the labels that there were.
class RepairProgress
{
 public:
  explicit RepairProgress(const FastMarchingBuffers& buffers)
  {
    const std::size_t count = buffers.touched.size();
    for (std::size_t i = 0; i < count; i += count / SAMPLES + 1) {
      const double label = buffers.labels[buffers.touched[i]];
      if (label < NOT_REACHED) {
        labels_.push_back(label);
      }
    }
    std::sort(labels_.begin(), labels_.end());
  }

  /// Of all that is farther than `start`: the part that is not farther than `key`. Above 0.
  double share(double start, double key) const
  {
    const double total = 1.0 + farther(start);
    return std::max(1.0, total - farther(key)) / total;
  }

 private:
  static constexpr std::size_t SAMPLES = 1024;

  double farther(double key) const
  {
    return static_cast<double>(labels_.end() -
                               std::upper_bound(labels_.begin(), labels_.end(), key));
  }

  std::vector<double> labels_;
};

/// How a repair ended.
enum class RepairEnd
{
  DONE,
  CANCELED,
  TOO_MUCH  ///< a new field takes less time
};

/// What becomes of a front after changes of costs: labels that do not follow from others any more
/// are taken back, in the order of labels, and found again. The order is that of LPA* (Koenig,
/// Likhachev, Furcy, Artificial Intelligence 155, 2004): a label is only looked at when all that it
/// may follow from is as it should be; so what gets the same label again takes nothing else with
/// it. Across obtuse corners a label may follow from others that are not below it; it is only found
/// again when those have been found without it.
template <bool HAS_COSTS>
class FastMarchingRepair
{
 public:
  FastMarchingRepair(const FastMarchingMesh& mesh, FastMarchingBuffers& buffers,
                     ArrayView<float> slowness, const std::vector<FastMarchingSeed>& seeds)
      : mesh_(mesh), buffers_(buffers), update_(mesh, buffers, slowness), seeds_(seeds)
  {
  }

  /// What may have another label if the slowness of these, or a seed there, has changed; each once.
  void beginAround(ArrayView<std::uint32_t> vertices)
  {
    std::vector<std::uint32_t> begins(vertices.begin(), vertices.end());
    for (const std::uint32_t v : vertices) {
      for (const FastMarchingCorner& c : mesh_.corners(v)) {
        begins.push_back(c.a);
        begins.push_back(c.b);
        if (c.a == c.b) {
          continue;
        }
        // The front comes across the edge (a, b) from this face, in a way that depends on v.
        for (const FastMarchingCorner& d : mesh_.corners(c.a)) {
          if (d.a == c.b) {
            begins.push_back(d.b);
          } else if (d.b == c.b) {
            begins.push_back(d.a);
          }
        }
      }
    }
    makeUnique(begins);
    local_ = LOCAL_LOOKS * vertices.size();
    const auto rim = static_cast<double>(begins.size() - std::min(begins.size(), vertices.size()));
    will_be_too_much_ = rim > LONGEST_RIM * std::sqrt(static_cast<double>(buffers_.touched.size()));
    for (std::size_t i = 0; i < begins.size() && !isTooMuch(); ++i) {
      begin(begins[i]);
    }
  }

  /// `changed`: vertices that got a label, some more than once.
  RepairEnd run(const std::atomic<bool>* cancel, std::vector<std::uint32_t>& changed)
  {
    const double front = buffers_.queue.open() ? buffers_.queue.floor() : NOT_REACHED;
    const double start = buffers_.tasks.empty() ? 0.0 : buffers_.tasks.front().key;
    const RepairProgress progress(buffers_);
    for (std::size_t tasks = 1; !isTooMuch() && !buffers_.tasks.empty(); ++tasks) {
      if (tasks % TASKS_PER_CANCEL_CHECK == 0) {
        if (isSet(cancel)) {
          return RepairEnd::CANCELED;
        }
        will_be_too_much_ =
            isBeyondLocal() && willBeTooMuch(progress.share(start, buffers_.tasks.front().key));
      }
      const FastMarchingTask task = buffers_.takeTask();
      while (!buffers_.tasks.empty() && !(buffers_.tasks.front() > task)) {
        buffers_.takeTask();  // the same once more
      }
      if (task.kind == FastMarchingTask::CHECK) {
        check(task, changed);
      } else if (task.kind != FastMarchingTask::PROPAGATE) {
        settle(task);
      } else if (task.key == buffers_.labels[task.vertex]) {
        changed.push_back(task.vertex);
        if (task.key < front) {
          update_.push(task.vertex, [this](std::uint32_t v, double before, double highest) {
            rankLowered(v, before, highest);
          });
        } else {
          buffers_.queue.push(task.key, task.vertex);
        }
      }
    }
    return isTooMuch() ? RepairEnd::TOO_MUCH : RepairEnd::DONE;
  }

  /// How often a label was looked at.
  std::size_t looks() const { return looks_; }

 private:
  /// What is looked at for a change, besides what follows from it farther on.
  static constexpr std::size_t LOCAL_LOOKS = 16;
  /// Behind a rim of changes, which is two vertices wide, all may be other: one longer than the
  /// outermost front (the square root of 4 pi of all vertices) shades everything.
  static constexpr double LONGEST_RIM = 6.0;

  std::size_t most() const { return buffers_.touched.size() / LABELS_PER_LOOK; }
  bool isTooMuch() const { return looks_ > most() || has_circle_ || will_be_too_much_; }
  bool isBeyondLocal() const { return looks_ > local_ + most() / 32; }

  /// What follows from changes does not become less farther on.
  bool willBeTooMuch(double share) const
  {
    return static_cast<double>(looks_ - local_) > share * static_cast<double>(most());
  }

  FastMarchingPull labelByOthers(std::uint32_t v, double below = NOT_REACHED)
  {
    ++looks_;
    FastMarchingPull found = update_.pull(v, below);
    // Two labels that are the same could follow from each other, and from nothing else.
    has_circle_ |= found.label < NOT_REACHED && found.least_step <= SAME * found.label;
    auto seed = std::lower_bound(
        seeds_.begin(), seeds_.end(), v,
        [](const FastMarchingSeed& one, std::uint32_t vertex) { return one.vertex < vertex; });
    if (seed != seeds_.end() && seed->vertex == v && update_.isOpen(v)) {
      if (seed->label < found.label) {
        found.label = seed->label;
        found.highest = -1.0;
      }
    }
    return found;
  }

  void begin(std::uint32_t v)
  {
    const double now = buffers_.labels[v];
    const FastMarchingPull found = labelByOthers(v);
    if (update_.isAbove(now, found.label)) {
      settleAt(v, found);
    } else if (found.label > now * (1.0 + SAME)) {
      buffers_.addTask({now, v, FastMarchingTask::CHECK});
    }
  }

  static bool isSame(double label, double other) { return label <= other * (1.0 + SAME); }

  /// Does what was found for v follow from ranks below `below` alone? Then `found` becomes that,
  /// for which there may be a little more than `label`.
  bool followsFrom(std::uint32_t v, FastMarchingPull& found, double label, double below)
  {
    if (found.highest < below) {
      return true;
    }
    const FastMarchingPull lower = labelByOthers(v, below);
    if (!isSame(lower.label, label)) {
      return false;
    }
    found = lower;
    return true;
  }

  /// What v follows from has ranks up to `highest`; it had the label `before`. What is lowered
  /// keeps its rank at most: others may rely on that.
  void rankAs(std::uint32_t v, double highest, double before)
  {
    const double label = buffers_.labels[v];
    if (!(highest < label)) {
      const double last = buffers_.ranks.of(v, before);
      buffers_.ranks.set(v, std::min(last, std::nextafter(highest, NOT_REACHED)));
    } else if (!buffers_.ranks.areLabelsFrom(label)) {
      buffers_.ranks.forget(v);
    }
  }

  /// The same, where `highest` is not below the label because it is not known better.
  void rankLowered(std::uint32_t v, double before, double highest)
  {
    rankAs(v, highest < buffers_.labels[v] ? highest : labelByOthers(v).highest, before);
  }

  /// v will have this label. Where that follows from ranks that are not below it (across obtuse
  /// corners), they may follow from it in turn, and from nothing else: it waits until all around it
  /// that depends on it has been taken back, too.
  void settleAt(std::uint32_t v, FastMarchingPull found)
  {
    if (!(found.label < NOT_REACHED)) {
      return;
    }
    if (followsFrom(v, found, found.label, found.label)) {
      buffers_.addTask({found.label, v, FastMarchingTask::SETTLE});
    } else {
      waitAt(v, found.label);
    }
  }

  void waitAt(std::uint32_t v, double label)
  {
    const double highest = std::max(label, update_.highestAround(v));
    buffers_.addTask({std::nextafter(highest, NOT_REACHED), v, FastMarchingTask::WAIT});
  }

  void check(const FastMarchingTask& task, std::vector<std::uint32_t>& changed)
  {
    const std::uint32_t v = task.vertex;
    if (buffers_.labels[v] != task.key) {
      return;
    }
    FastMarchingPull found = labelByOthers(v);
    const bool is_same = isSame(found.label, task.key);
    if (is_same && followsFrom(v, found, task.key, update_.rank(v))) {
      return;
    }
    checkAround(v);
    buffers_.labels[v] = NOT_REACHED;
    buffers_.ranks.forget(v);
    changed.push_back(v);
    if (is_same) {
      waitAt(v, found.label);
    } else {
      settleAt(v, found);
    }
  }

  /// All that may follow from the label of v.
  void checkAround(std::uint32_t v)
  {
    update_.forEachFollowing(v, [&](std::uint32_t next) { checkNext(v, next); });
  }

  void checkNext(std::uint32_t v, std::uint32_t next)
  {
    if (next != v && buffers_.labels[next] < NOT_REACHED) {
      buffers_.addTask({buffers_.labels[next], next, FastMarchingTask::CHECK});
    }
  }

  void settle(const FastMarchingTask& task)
  {
    const std::uint32_t v = task.vertex;
    const double now = buffers_.labels[v];
    if (task.kind == FastMarchingTask::SETTLE && !update_.isAbove(now, task.key)) {
      return;
    }
    FastMarchingPull found = labelByOthers(v);
    if (!update_.isAbove(now, found.label)) {
      return;
    }
    if (followsFrom(v, found, found.label, std::nextafter(task.key, NOT_REACHED))) {
      update_.offer(v, found.label);
      if (buffers_.labels[v] < now) {
        rankAs(v, found.highest, now);
      }
    } else {
      settleAt(v, found);
    }
  }

  /// Labels that differ by a smaller part than this are the same.
  static constexpr double SAME = 1e-9;

  static constexpr std::size_t TASKS_PER_CANCEL_CHECK = 256;

  /// A label that is looked at in a repair takes about as long as three in a new field.
  static constexpr std::size_t LABELS_PER_LOOK = 3;

  const FastMarchingMesh& mesh_;
  FastMarchingBuffers& buffers_;
  FastMarchingUpdate<HAS_COSTS> update_;
  const std::vector<FastMarchingSeed>& seeds_;
  std::size_t looks_ = 0, local_ = 0;
  bool has_circle_ = false, will_be_too_much_ = false;
};

}  // namespace mesh_map
