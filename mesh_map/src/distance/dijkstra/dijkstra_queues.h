#pragma once

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

/// Cyclic buckets of equal width (R. Dial: Algorithm 360, 1969; wider than edges may be). Entries
/// of one bucket come in any order and may join it while it is being emptied: the search corrects
/// labels until the bucket is empty, after which everything below its upper end is final.
class BucketQueue
{
 public:
  static constexpr double MAX_BUCKETS = 1 << 16;

  static bool fits(double width, double span) { return span / width + 3.0 <= MAX_BUCKETS; }

  /// Of an empty queue. `span` is the most by which an entry can lie beyond the bucket that is
  /// being emptied, `lowest` the least distance to come.
  void start(double width, double span, float lowest)
  {
    std::size_t count = 4;
    while (static_cast<double>(count) < span / width + 3.0) {
      count *= 2;
    }
    buckets_per_unit_ = 1.0 / width;
    buckets_.resize(count);
    mask_ = count - 1;
    current_ = index(lowest);
  }

  void push(float distance, std::uint32_t vertex)
  {
    const std::uint64_t bucket = index(distance);
    if (bucket - current_ > mask_) {
      outside_.push_back({distance, vertex});  // rounding of huge sums: see overflowed()
      return;
    }
    buckets_[bucket & mask_].push_back({distance, vertex});
    ++size_;
  }

  void pushAll(const std::vector<QueueEntry>& entries)
  {
    for (const QueueEntry& entry : entries) {
      push(entry.distance, entry.vertex);
    }
  }

  /// Replaces `entries` by all that are left; the queue is empty then.
  void takeAll(std::vector<QueueEntry>& entries)
  {
    entries.clear();
    entries.swap(outside_);
    if (size_ > 0) {
      std::vector<QueueEntry>& bucket = buckets_[current_ & mask_];
      bucket.erase(bucket.begin(), bucket.begin() + static_cast<std::ptrdiff_t>(next_));
      for (std::vector<QueueEntry>& left : buckets_) {
        entries.insert(entries.end(), left.begin(), left.end());
        left.clear();
      }
    }
    size_ = 0;
    next_ = 0;
    if (buckets_.size() > MOST_KEPT) {
      buckets_ = {};
    }
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

  /// Is there an entry that is outside of the span? Another queue has to go on with takeAll().
  bool overflowed() const { return !outside_.empty(); }

 private:
  static constexpr std::size_t MOST_KEPT = 1024;  // buckets, with the memory they have come to

  std::uint64_t index(float distance) const
  {
    const double bucket = distance * buckets_per_unit_;
    return bucket < 9e18 ? static_cast<std::uint64_t>(bucket) : ~std::uint64_t{0};
  }

  double buckets_per_unit_ = 1.0;
  std::vector<std::vector<QueueEntry>> buckets_;
  std::vector<QueueEntry> outside_;
  std::uint64_t mask_ = 0;
  std::uint64_t current_ = 0;
  std::size_t size_ = 0;
  std::size_t next_ = 0;  // within the bucket that is being emptied
};

/// Binary heap without decrease-key: a batch is one entry.
class HeapQueue
{
 public:
  void push(float distance, std::uint32_t vertex)
  {
    entries_.push_back({distance, vertex});
    std::push_heap(entries_.begin(), entries_.end(), later);
  }

  void pushAll(const std::vector<QueueEntry>& entries)
  {
    entries_.insert(entries_.end(), entries.begin(), entries.end());
    std::make_heap(entries_.begin(), entries_.end(), later);
  }

  void takeAll(std::vector<QueueEntry>& entries)
  {
    entries.clear();
    entries.swap(entries_);
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
