#include "bvh/tree/bvh_bytes.h"

#include "base/float_bits.h"

namespace mesh_map {

namespace {

/// Mixes a word into a hash: the product spreads it upwards, the shift downwards.
std::uint64_t mixed(std::uint64_t hash, std::uint64_t word)
{
  hash = (hash ^ word) * 0x9E3779B97F4A7C15u;  // 2^64 / golden ratio, odd
  return hash ^ (hash >> 32);
}

std::uint64_t pairOf(float low, float high)
{
  return bitsOf(low) | std::uint64_t{bitsOf(high)} << 32;
}

}  // namespace

std::uint64_t checksum(const std::uint8_t* bytes, std::size_t size)
{
  std::uint64_t hash = size;
  std::size_t i = 0;
  for (; i + 8 <= size; i += 8) {
    hash = mixed(hash, readNumber<std::uint64_t>(bytes + i));
  }
  for (; i < size; ++i) {
    hash = mixed(hash, bytes[i]);
  }
  return hash;
}

std::uint64_t faceHash(std::uint32_t face, const float* a, const float* b, const float* c)
{
  std::uint64_t hash = mixed(0, face);
  hash = mixed(hash, pairOf(a[0], a[1]));
  hash = mixed(hash, pairOf(a[2], b[0]));
  hash = mixed(hash, pairOf(b[1], b[2]));
  hash = mixed(hash, pairOf(c[0], c[1]));
  return mixed(hash, pairOf(c[2], 1.0f));
}

}  // namespace mesh_map
