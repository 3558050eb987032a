#pragma once

#include <mesh_map/base/array_view.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/float_bits.h"

namespace mesh_map {

/// A vertex with the distance it had when it was queued. Stale when the vertex has become nearer
/// since.
struct DistanceEntry
{
  float distance;
  std::uint32_t vertex;
};

/// Gives entries in exact order of (distance, vertex), as long as nothing is queued below what was
/// popped last. A bucket is sorted when its turn comes; what joins it then goes to a small heap.
/// The last bucket takes everything beyond the others.
class DistanceQueue
{
 public:
  /// `width` of a bucket, above 0.
  explicit DistanceQueue(double width) : buckets_per_unit_(1.0 / width), buckets_(COUNT) {}

  /// As new, with the memory that it has.
  void clear()
  {
    for (std::size_t i = 0; size_ > 0 && i < COUNT; ++i) {
      buckets_[i].clear();
    }
    sorted_.clear();
    late_.clear();
    current_ = next_ = size_ = 0;
    is_open_ = false;
  }

  /// `distance` is 0 or more.
  void push(float distance, std::uint32_t vertex)
  {
    const double place = distance * buckets_per_unit_;
    const std::size_t bucket = place < COUNT - 1 ? static_cast<std::size_t>(place) : COUNT - 1;
    ++size_;
    if (bucket > current_ || !is_open_) {
      buckets_[std::max(bucket, current_)].push_back(key(distance, vertex));
    } else {
      late_.push_back(key(distance, vertex));
      std::push_heap(late_.begin(), late_.end(), std::greater<Key>());
    }
  }

  /// False where nothing is left.
  bool pop(DistanceEntry& entry)
  {
    if (size_ == 0) {
      return false;
    }
    while (next_ == sorted_.size() && late_.empty()) {
      openNext();
    }
    Key first;
    if (late_.empty() || (next_ < sorted_.size() && sorted_[next_] < late_.front())) {
      first = sorted_[next_++];
    } else {
      first = late_.front();
      std::pop_heap(late_.begin(), late_.end(), std::greater<Key>());
      late_.pop_back();
    }
    --size_;
    entry = fromKey(first);
    return true;
  }

  /// The vertex that comes `count` entries later, if it is already known; else NO_INDEX.
  std::uint32_t peek(std::size_t count) const
  {
    return next_ + count < sorted_.size() ? fromKey(sorted_[next_ + count]).vertex : NO_INDEX;
  }

 private:
  /// Numbers in the order of the entries: floats that are not negative are ordered as their bits.
  using Key = std::uint64_t;

  static constexpr std::size_t COUNT = 4096;

  static Key key(float distance, std::uint32_t vertex)
  {
    return Key{bitsOf(distance)} << 32 | vertex;
  }

  static DistanceEntry fromKey(Key key)
  {
    return {floatOf(static_cast<std::uint32_t>(key >> 32)), static_cast<std::uint32_t>(key)};
  }

  void openNext()
  {
    if (is_open_) {
      ++current_;
    }
    while (buckets_[current_].empty()) {
      ++current_;
    }
    is_open_ = true;
    sorted_.clear();
    sorted_.swap(buckets_[current_]);
    next_ = 0;
    std::sort(sorted_.begin(), sorted_.end());
  }

  double buckets_per_unit_;
  std::vector<std::vector<Key>> buckets_;
  std::size_t current_ = 0;
  bool is_open_ = false;  // is the current bucket in sorted_ and late_?
  std::vector<Key> sorted_;
  std::size_t next_ = 0;  // in sorted_
  std::vector<Key> late_;
  std::size_t size_ = 0;
};

}  // namespace mesh_map
