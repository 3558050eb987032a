#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// A place in an unbounded grid: whole coordinates from -LIMIT to LIMIT - 1.
struct GridPlace
{
  static constexpr std::int32_t LIMIT = 1 << 20;

  std::int32_t x = 0, y = 0, z = 0;

  bool isInside() const
  {
    const auto fits = [](std::int32_t value) { return value >= -LIMIT && value < LIMIT; };
    return fits(x) && fits(y) && fits(z);
  }

  /// A number for each place; their order is that of z, y, x.
  std::uint64_t key() const
  {
    const auto bits = [](std::int32_t value) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value + LIMIT));
    };
    return (bits(z) << 42) | (bits(y) << 21) | bits(x);
  }

  static GridPlace of(std::uint64_t key)
  {
    const auto coordinate = [](std::uint64_t bits) {
      return static_cast<std::int32_t>(bits & 0x1FFFFF) - LIMIT;
    };
    return {coordinate(key), coordinate(key >> 21), coordinate(key >> 42)};
  }

  GridPlace operator+(const GridPlace& other) const
  {
    return {x + other.x, y + other.y, z + other.z};
  }
};

/// Numbers keys in the order in which they come: a table with open addressing (D. Knuth: The Art of
/// Computer Programming 3, 6.4).
class KeyIndex
{
 public:
  static constexpr std::uint32_t NONE = 0xFFFFFFFFu;

  /// Empty.
  KeyIndex() : slots_(std::size_t{1} << MIN_BITS, NONE) {}

  std::size_t size() const { return keys_.size(); }
  const std::vector<std::uint64_t>& keys() const { return keys_; }

  /// NONE of a key that has no number.
  std::uint32_t find(std::uint64_t key) const
  {
    std::size_t slot = hash(key);
    while (slots_[slot] != NONE && keys_[slots_[slot]] != key) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    return slots_[slot];
  }

  /// Its number; a new one has the next.
  std::uint32_t add(std::uint64_t key)
  {
    std::size_t slot = hash(key);
    while (slots_[slot] != NONE) {
      if (keys_[slots_[slot]] == key) {
        return slots_[slot];
      }
      slot = (slot + 1) & (slots_.size() - 1);
    }
    const auto number = static_cast<std::uint32_t>(keys_.size());
    keys_.push_back(key);
    slots_[slot] = number;
    if (2 * keys_.size() > slots_.size()) {
      grow();
    }
    return number;
  }

  std::size_t memory() const
  {
    return keys_.capacity() * sizeof(std::uint64_t) + slots_.capacity() * sizeof(std::uint32_t);
  }

 private:
  static constexpr unsigned MIN_BITS = 10;

  /// Multiplicative hashing with the golden ratio (Knuth, 6.4).
  std::size_t hash(std::uint64_t key) const
  {
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ull) >> shift_);
  }

  void grow()
  {
    std::vector<std::uint32_t> larger(2 * slots_.size(), NONE);
    --shift_;
    for (std::uint32_t number = 0; number < keys_.size(); ++number) {
      std::size_t slot = hash(keys_[number]);
      while (larger[slot] != NONE) {
        slot = (slot + 1) & (larger.size() - 1);
      }
      larger[slot] = number;
    }
    slots_.swap(larger);
  }

  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> slots_;  // 2^(64 - shift_) of them
  unsigned shift_ = 64 - MIN_BITS;
};

}  // namespace mesh_map
