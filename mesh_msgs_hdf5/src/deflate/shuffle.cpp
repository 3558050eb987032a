#include "deflate/shuffle.h"

#include <algorithm>
#include <cstring>

namespace mesh_msgs_hdf5 {
namespace {

// Items at a time, so that they and their planes stay in the first cache.
constexpr std::size_t BLOCK = 1024;

// The size known to the compiler lets it use vector instructions.
template <std::size_t SIZE>
void shuffleItems(const std::uint8_t* items, std::size_t count, std::uint8_t* planes,
                  std::size_t plane_size)
{
  for (std::size_t begin = 0; begin < count; begin += BLOCK) {
    const std::size_t end = std::min(count, begin + BLOCK);
    for (std::size_t byte = 0; byte < SIZE; ++byte) {
      const std::uint8_t* const from = items + byte;
      std::uint8_t* const to = planes + byte * plane_size;
      for (std::size_t i = begin; i < end; ++i) {
        to[i] = from[i * SIZE];
      }
    }
  }
}

template <std::size_t SIZE>
void unshuffleItems(const std::uint8_t* planes, std::size_t plane_size, std::size_t count,
                    std::uint8_t* items)
{
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t byte = 0; byte < SIZE; ++byte) {
      items[i * SIZE + byte] = planes[byte * plane_size + i];
    }
  }
}

}  // namespace

void shuffle(const std::uint8_t* items, std::size_t count, std::size_t item_size,
             std::uint8_t* planes, std::size_t plane_size)
{
  switch (item_size) {
    case 1:
      std::memcpy(planes, items, count);
      break;
    case 2:
      shuffleItems<2>(items, count, planes, plane_size);
      break;
    case 4:
      shuffleItems<4>(items, count, planes, plane_size);
      break;
    case 8:
      shuffleItems<8>(items, count, planes, plane_size);
      break;
    default:
      for (std::size_t byte = 0; byte < item_size; ++byte) {
        for (std::size_t i = 0; i < count; ++i) {
          planes[byte * plane_size + i] = items[i * item_size + byte];
        }
      }
  }
}

void unshuffle(const std::uint8_t* planes, std::size_t plane_size, std::size_t count,
               std::size_t item_size, std::uint8_t* items)
{
  switch (item_size) {
    case 1:
      std::memcpy(items, planes, count);
      break;
    case 2:
      unshuffleItems<2>(planes, plane_size, count, items);
      break;
    case 4:
      unshuffleItems<4>(planes, plane_size, count, items);
      break;
    case 8:
      unshuffleItems<8>(planes, plane_size, count, items);
      break;
    default:
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t byte = 0; byte < item_size; ++byte) {
          items[i * item_size + byte] = planes[byte * plane_size + i];
        }
      }
  }
}

}  // namespace mesh_msgs_hdf5
