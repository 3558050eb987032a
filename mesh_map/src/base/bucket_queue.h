#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace mesh_map {

/// A vertex with the label it had when it was queued; stale when it has another one since.
template <class Label>
struct QueueEntry
{
  Label label;
  std::uint32_t vertex;
};

/// Entries in buckets of equal width (R. Dial: Algorithm 360, 1969), first in, first out in each;
/// what is queued below the current bucket joins it, so whoever searches with it corrects labels
/// until a bucket is empty. A ring of buckets holds what comes next, one more list what is far
/// beyond, so that neither huge nor tiny labels cost memory or time.
template <class Label>
class BucketQueue
{
 public:
  using Entry = QueueEntry<Label>;

  BucketQueue() : buckets_(COUNT) {}

  /// Empties it. `width` of a bucket is above 0.
  void reset(double width)
  {
    for (std::size_t word = 0; word < filled_.size(); ++word) {
      for (; filled_[word] != 0; filled_[word] &= filled_[word] - 1) {
        buckets_[64 * word + lowestBit(filled_[word])].clear();
      }
    }
    far_.clear();
    width_ = width;
    current_ = 0;
    next_ = 0;
    size_ = 0;
    far_begin_ = NONE;
  }

  void push(Label label, std::uint32_t vertex)
  {
    const std::uint64_t bucket = std::max(placeOf(label), current_);
    ++size_;
    if (bucket - current_ < COUNT) {
      put(bucket, {label, vertex});
    } else {
      far_.push_back({label, vertex});
      far_begin_ = std::min(far_begin_, bucket);
    }
  }

  /// Makes the first bucket that has entries the current one. False where there is none.
  bool open()
  {
    std::vector<Entry>& last = buckets_[current_ % COUNT];
    if (next_ < last.size()) {
      return true;
    }
    last.clear();
    next_ = 0;
    filled_[current_ % COUNT / 64] &= ~(std::uint64_t{1} << current_ % 64);
    if (size_ == 0) {
      return false;
    }
    const std::uint64_t near = nextFilled();
    current_ = std::min(near, far_begin_);
    if (far_begin_ == current_) {
      fetchFar();
    }
    return true;
  }

  /// Takes the next entry of the current bucket. False at its end.
  bool pop(Entry& entry)
  {
    const std::vector<Entry>& bucket = buckets_[current_ % COUNT];
    if (next_ == bucket.size()) {
      return false;
    }
    entry = bucket[next_++];
    --size_;
    return true;
  }

  /// What comes `count` entries later, if that is in the current bucket; else null.
  const Entry* peek(std::size_t count) const
  {
    const std::vector<Entry>& bucket = buckets_[current_ % COUNT];
    return next_ + count < bucket.size() ? &bucket[next_ + count] : nullptr;
  }

  /// Does a label lie below the current bucket? Then nothing that is queued can lower it.
  bool isPassed(Label label) const { return placeOf(label) < current_; }

  /// What is queued below this is in the current bucket.
  double floor() const { return static_cast<double>(current_) * width_; }
  /// All that has a label above this one is still to come.
  double ceiling() const
  {
    return current_ < LAST ? static_cast<double>(current_ + 1) * width_ * (1.0 + 1e-12)
                           : std::numeric_limits<double>::infinity();
  }
  double width() const { return width_; }

  /// All entries, in no order.
  template <class Visit>
  void forEach(const Visit& visit) const
  {
    for (std::size_t word = 0; word < filled_.size(); ++word) {
      for (std::uint64_t bits = filled_[word]; bits != 0; bits &= bits - 1) {
        const std::size_t place = 64 * word + lowestBit(bits);
        const std::size_t begin = place == current_ % COUNT ? next_ : 0;
        for (std::size_t i = begin; i < buckets_[place].size(); ++i) {
          visit(buckets_[place][i]);
        }
      }
    }
    for (const Entry& entry : far_) {
      visit(entry);
    }
  }

 private:
  static constexpr std::size_t COUNT = 4096;
  static constexpr std::uint64_t NONE = std::numeric_limits<std::uint64_t>::max();
  static constexpr std::uint64_t LAST = std::uint64_t{1} << 62;  // takes all that is beyond, too

  static unsigned lowestBit(std::uint64_t bits)
  {
    return static_cast<unsigned>(__builtin_ctzll(bits));
  }

  std::uint64_t placeOf(Label label) const
  {
    const double place = label / width_;
    return place < static_cast<double>(LAST) ? static_cast<std::uint64_t>(place) : LAST;
  }

  void put(std::uint64_t bucket, const Entry& entry)
  {
    const std::size_t place = bucket % COUNT;
    buckets_[place].push_back(entry);
    filled_[place / 64] |= std::uint64_t{1} << place % 64;
  }

  /// The first bucket after the current one that has entries, NONE where only far ones are left.
  std::uint64_t nextFilled() const
  {
    const std::size_t start = (current_ + 1) % COUNT;
    for (std::size_t i = 0; i <= filled_.size(); ++i) {
      const std::size_t word = (start / 64 + i) % filled_.size();
      std::uint64_t bits = filled_[word];
      if (i == 0) {
        bits &= ~std::uint64_t{0} << start % 64;
      } else if (i == filled_.size()) {
        bits &= ~(~std::uint64_t{0} << start % 64);
      }
      if (bits != 0) {
        return current_ + 1 + (64 * word + lowestBit(bits) + COUNT - start) % COUNT;
      }
    }
    return NONE;
  }

  /// Moves to the ring what has its place there now.
  void fetchFar()
  {
    std::size_t kept = 0;
    far_begin_ = NONE;
    for (const Entry& entry : far_) {
      const std::uint64_t bucket = std::max(placeOf(entry.label), current_);
      if (bucket - current_ < COUNT) {
        put(bucket, entry);
      } else {
        far_[kept++] = entry;
        far_begin_ = std::min(far_begin_, bucket);
      }
    }
    far_.resize(kept);
  }

  double width_ = 1.0;
  std::vector<std::vector<Entry>> buckets_;
  std::array<std::uint64_t, COUNT / 64> filled_{};
  std::vector<Entry> far_;
  std::uint64_t current_ = 0, far_begin_ = NONE;
  std::size_t next_ = 0;  // in the current bucket
  std::size_t size_ = 0;
};

}  // namespace mesh_map
