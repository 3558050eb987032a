#include "base/radix_sort.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "base/run.h"

namespace mesh_map {

namespace {

constexpr unsigned DIGIT_BITS = 8;
constexpr std::size_t DIGITS = std::size_t{1} << DIGIT_BITS;
constexpr unsigned PASSES = 32 / DIGIT_BITS;

/// Items that one thread counts and moves at a time. Blocks keep their order, so the result does
/// not depend on who does which.
constexpr std::size_t BLOCK = 65536;

using Counts = std::array<std::uint32_t, DIGITS>;

}  // namespace

void sortByKey(LargeArray<KeyedIndex>& items, Run& run, double share)
{
  const std::size_t count = items.size();
  LargeArray<KeyedIndex> other(count);
  std::vector<Counts> blocks((count + BLOCK - 1) / BLOCK);
  for (unsigned pass = 0; pass < PASSES; ++pass) {
    const unsigned shift = pass * DIGIT_BITS;
    run.loop(count, BLOCK, share / PASSES / 2, [&]() -> RangeBody {
      return [&items, &blocks, shift](std::size_t begin, std::size_t end) {
        Counts counts{};
        for (const KeyedIndex* item = items.data() + begin; item < items.data() + end; ++item) {
          ++counts[(item->key >> shift) % DIGITS];
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
      return [&items, &other, &blocks, shift](std::size_t begin, std::size_t end) {
        Counts places = blocks[begin / BLOCK];
        KeyedIndex* const to = other.data();
        for (const KeyedIndex* item = items.data() + begin; item < items.data() + end; ++item) {
          to[places[(item->key >> shift) % DIGITS]++] = *item;
        }
      };
    });
    items.swap(other);
  }
}

}  // namespace mesh_map
