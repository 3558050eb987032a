#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/bucket_queue.h"

namespace mesh_map {

/// What a field knows of a vertex.
struct DijkstraLabel
{
  float distance = std::numeric_limits<float>::infinity();  ///< +inf: none
  std::uint32_t from = NO_INDEX;  ///< the vertex itself at a source; none: never had a distance
};

/// The labels of one field, and which of them were ever touched, so that the cost of forgetting
/// them is in proportion to these.
class DijkstraLabels
{
 public:
  explicit DijkstraLabels(std::size_t vertex_count) : labels_(vertex_count, DijkstraLabel()) {}

  DijkstraLabel& operator[](std::uint32_t vertex) { return labels_[vertex]; }
  const DijkstraLabel& operator[](std::uint32_t vertex) const { return labels_[vertex]; }

  /// The label gets its first distance.
  void touch(std::uint32_t vertex)
  {
    if (++touched_count_ <= labels_.size() / FEW) {
      touched_.push_back(vertex);
    }
  }

  std::size_t touchedCount() const { return touched_count_; }

  /// Were so many touched that these are not listed?
  bool areMany() const { return touched_count_ > labels_.size() / FEW; }

  /// Calls body(vertex) for all that were touched, and maybe for others.
  template <class Body>
  void forEachTouched(const Body& body) const
  {
    if (areMany()) {
      for (std::uint32_t v = 0; v < labels_.size(); ++v) {
        body(v);
      }
    } else {
      for (const std::uint32_t v : touched_) {
        body(v);
      }
    }
  }

  /// As new.
  void forget()
  {
    forEachTouched([this](std::uint32_t v) { labels_[v] = DijkstraLabel(); });
    touched_.clear();
    touched_count_ = 0;
  }

  BucketQueue<float> queue;  ///< its memory is kept, too

 private:
  static constexpr std::size_t FEW = 4;  // a list of more than this part of all is no gain

  LargeArray<DijkstraLabel> labels_;
  std::vector<std::uint32_t> touched_;
  std::size_t touched_count_ = 0;
};

/// Labels that wait for their next field.
class DijkstraPool
{
 public:
  explicit DijkstraPool(std::size_t vertex_count) : vertex_count_(vertex_count) {}

  std::unique_ptr<DijkstraLabels> take()
  {
    std::unique_ptr<DijkstraLabels> labels;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!kept_.empty()) {
        labels = std::move(kept_.back());
        kept_.pop_back();
      }
    }
    if (labels == nullptr) {
      return std::make_unique<DijkstraLabels>(vertex_count_);
    }
    labels->forget();
    return labels;
  }

  void give(std::unique_ptr<DijkstraLabels> labels)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (kept_.size() < MOST_KEPT) {
      kept_.push_back(std::move(labels));
    }
  }

  std::size_t vertexCount() const { return vertex_count_; }

 private:
  static constexpr std::size_t MOST_KEPT = 2;

  std::size_t vertex_count_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<DijkstraLabels>> kept_;
};

}  // namespace mesh_map
