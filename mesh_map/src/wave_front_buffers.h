#ifndef MESH_MAP_SRC_WAVE_FRONT_BUFFERS_H
#define MESH_MAP_SRC_WAVE_FRONT_BUFFERS_H

#include <mesh_map/large_array.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "wave_front_queue.h"

namespace mesh_map {

/// What a repair has to do at a vertex, once all that is nearer than `key` is as it should be.
struct WaveFrontTask
{
  enum Kind : std::uint32_t
  {
    SPREAD,  ///< it has the label `key` now: tell its neighbors
    CHECK,   ///< it has the label `key`: does that still follow from its neighbors?
    SETTLE   ///< it has none, and will have this one by its neighbors
  };

  double key;
  std::uint32_t vertex;
  Kind kind;

  bool operator>(const WaveFrontTask& other) const
  {
    return std::tie(key, vertex, kind) > std::tie(other.key, other.vertex, other.kind);
  }
};

/// What a front needs while it lives.
struct WaveFrontBuffers
{
  LargeArray<double> labels;           // infinite where not reached
  std::vector<std::uint32_t> touched;  // all vertices that had a label once
  WaveFrontQueue queue;
  bool is_in_repair = false;         // then labels that are lowered become tasks
  std::vector<WaveFrontTask> tasks;  // a heap, the nearest first

  /// Everything as in new ones. Takes as long as what was touched is large.
  void clear();

  /// A vertex has got a lower label.
  void queueLowered(double label, std::uint32_t vertex)
  {
    if (is_in_repair) {
      addTask({label, vertex, WaveFrontTask::SPREAD});
    } else {
      queue.push(label, vertex);
    }
  }

  void addTask(const WaveFrontTask& task)
  {
    tasks.push_back(task);
    std::push_heap(tasks.begin(), tasks.end(), std::greater<WaveFrontTask>());
  }

  WaveFrontTask takeTask()
  {
    std::pop_heap(tasks.begin(), tasks.end(), std::greater<WaveFrontTask>());
    const WaveFrontTask task = tasks.back();
    tasks.pop_back();
    return task;
  }
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WAVE_FRONT_BUFFERS_H
