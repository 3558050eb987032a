#pragma once

#include <mesh_map/base/large_array.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/run.h"

namespace mesh_map {

/// A number to sort by, and what it belongs to.
struct KeyedIndex
{
  std::uint32_t key, index;
};

/// Sorts items by keyOf(item), 32 bits, digit by digit from the lowest (D. Knuth: The Art of
/// Computer Programming 3, 5.2.5), on all threads; equal keys stay in their order.
template <class Items, class KeyOf>
void radixSort(Items& items, const KeyOf& keyOf, Run& run, double share)
{
  constexpr unsigned DIGIT_BITS = 8, PASSES = 32 / DIGIT_BITS;
  constexpr std::size_t DIGITS = std::size_t{1} << DIGIT_BITS;
  // Items that one thread counts and moves at a time. Blocks keep their order, so the result does
  // not depend on who does which.
  constexpr std::size_t BLOCK = 65536;
  using Counts = std::array<std::uint32_t, DIGITS>;

  const std::size_t count = items.size();
  Items other(count);
  std::vector<Counts> blocks((count + BLOCK - 1) / BLOCK);
  for (unsigned pass = 0; pass < PASSES; ++pass) {
    const auto digitOf = [keyOf, shift = pass * DIGIT_BITS](const auto& item) {
      return (keyOf(item) >> shift) % DIGITS;
    };
    run.loop(count, BLOCK, share / PASSES / 2, [&]() -> RangeBody {
      return [&items, &blocks, digitOf](std::size_t begin, std::size_t end) {
        Counts counts{};
        for (const auto* item = items.data() + begin; item < items.data() + end; ++item) {
          ++counts[digitOf(*item)];
        }
        blocks[begin / BLOCK] = counts;
      };
    });

    // From counts to places: digit by digit, within that block by block.
    std::uint32_t place = 0;
    bool same = false;  // all keys have the same digit here
    for (std::size_t digit = 0; digit < DIGITS; ++digit) {
      const std::uint32_t before = place;
      for (Counts& block : blocks) {
        place += block[digit];
        block[digit] = place - block[digit];
      }
      same = same || place - before == count;
    }
    if (same) {
      run.advance(share / PASSES / 2);
      continue;
    }

    run.loop(count, BLOCK, share / PASSES / 2, [&]() -> RangeBody {
      return [&items, &other, &blocks, digitOf](std::size_t begin, std::size_t end) {
        Counts places = blocks[begin / BLOCK];
        auto* const to = other.data();
        for (const auto* item = items.data() + begin; item < items.data() + end; ++item) {
          to[places[digitOf(*item)]++] = *item;
        }
      };
    });
    items.swap(other);
  }
}

inline void sortByKey(LargeArray<KeyedIndex>& items, Run& run, double share)
{
  radixSort(
      items, [](const KeyedIndex& item) { return item.key; }, run, share);
}

}  // namespace mesh_map
