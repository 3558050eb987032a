#include "distance/dijkstra/dijkstra_labels.h"

#include <algorithm>
#include <utility>

namespace mesh_map {

void DijkstraLabels::forget()
{
  if (areMany()) {
    std::fill(labels_.begin(), labels_.end(), DijkstraLabel());
  } else {
    for (const std::uint32_t v : touched_) {
      labels_[v] = DijkstraLabel();
    }
  }
  touched_.clear();
  touched_count_ = 0;
}

std::unique_ptr<DijkstraLabels> DijkstraPool::take()
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

void DijkstraPool::give(std::unique_ptr<DijkstraLabels> labels)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (kept_.size() < MOST_KEPT) {
    kept_.push_back(std::move(labels));
  }
}

}  // namespace mesh_map
