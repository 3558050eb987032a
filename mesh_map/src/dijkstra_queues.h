#ifndef MESH_MAP_SRC_DIJKSTRA_QUEUES_H
#define MESH_MAP_SRC_DIJKSTRA_QUEUES_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// A vertex with the distance it had when it was queued. Stale when the vertex has become nearer
/// since.
struct QueueEntry
{
  float distance;
  std::uint32_t vertex;
};

/// Cyclic buckets of equal width. Entries of one bucket come in any order and may join it while it
/// is being emptied: the search corrects labels until the bucket is empty, after which everything
/// below its upper end is final.
class BucketQueue
{
 public:
  /// `span` is the most by which an entry can lie beyond the bucket that is being emptied.
  BucketQueue(double width, double span)
      : buckets_per_unit_(1.0 / width),
        buckets_(bucketCount(width, span)),
        mask_(buckets_.size() - 1)
  {
  }

  static constexpr double MAX_BUCKETS = 1 << 16;

  static bool fits(double width, double span) { return span / width + 3.0 <= MAX_BUCKETS; }

  /// All entries queued before the first nextBatch() have to lie within `span` of the lowest of
  /// them.
  void start(float lowest) { current_ = index(lowest); }

  void push(float distance, std::uint32_t vertex)
  {
    const std::uint64_t bucket = index(distance);
    if (bucket - current_ > mask_) {
      overflow_ = true;  // rounding of huge sums: the caller starts again with a heap
      return;
    }
    buckets_[bucket & mask_].push_back({distance, vertex});
    ++size_;
  }

  /// Goes to the next bucket with entries; false where there is none.
  bool nextBatch()
  {
    if (size_ == 0) {
      return false;
    }
    while (buckets_[current_ & mask_].empty()) {
      ++current_;
    }
    return true;
  }

  bool popFromBatch(QueueEntry& entry)
  {
    std::vector<QueueEntry>& bucket = buckets_[current_ & mask_];
    if (next_ == bucket.size()) {
      size_ -= next_;
      next_ = 0;
      bucket.clear();
      return false;
    }
    entry = bucket[next_++];
    return true;
  }

  /// The entry that is popped after `count` others, where this batch has so many.
  const QueueEntry* peek(std::size_t count) const
  {
    const std::vector<QueueEntry>& bucket = buckets_[current_ & mask_];
    return next_ + count < bucket.size() ? &bucket[next_ + count] : nullptr;
  }

  /// Before a batch is taken: is this label final?
  bool isFinal(float distance) const { return index(distance) < current_; }

  /// Before a batch is taken: do all entries lie beyond?
  bool isPast(float distance) const { return index(distance) < current_; }

  bool overflowed() const { return overflow_; }

 private:
  static std::size_t bucketCount(double width, double span)
  {
    std::size_t count = 4;
    while (static_cast<double>(count) < span / width + 3.0) {
      count *= 2;
    }
    return count;
  }

  std::uint64_t index(float distance) const
  {
    const double bucket = distance * buckets_per_unit_;
    return bucket < 9e18 ? static_cast<std::uint64_t>(bucket) : ~std::uint64_t{0};
  }

  double buckets_per_unit_;
  std::vector<std::vector<QueueEntry>> buckets_;
  std::uint64_t mask_;
  std::uint64_t current_ = 0;
  std::size_t size_ = 0;
  std::size_t next_ = 0;  // within the bucket that is being emptied
  bool overflow_ = false;
};

/// Binary heap without decrease-key: a batch is one entry.
class HeapQueue
{
 public:
  void start(float) {}

  void push(float distance, std::uint32_t vertex)
  {
    entries_.push_back({distance, vertex});
    std::push_heap(entries_.begin(), entries_.end(), later);
  }

  bool nextBatch()
  {
    taken_ = false;
    return !entries_.empty();
  }

  bool popFromBatch(QueueEntry& entry)
  {
    if (taken_) {
      return false;
    }
    taken_ = true;
    entry = entries_.front();
    std::pop_heap(entries_.begin(), entries_.end(), later);
    entries_.pop_back();
    return true;
  }

  const QueueEntry* peek(std::size_t) const { return nullptr; }

  bool isFinal(float distance) const { return distance <= entries_.front().distance; }

  bool isPast(float distance) const { return distance < entries_.front().distance; }

  bool overflowed() const { return false; }

 private:
  static bool later(const QueueEntry& a, const QueueEntry& b)
  {
    return a.distance != b.distance ? a.distance > b.distance : a.vertex > b.vertex;
  }

  std::vector<QueueEntry> entries_;
  bool taken_ = false;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_DIJKSTRA_QUEUES_H
