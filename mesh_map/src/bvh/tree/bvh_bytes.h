#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/float_bits.h"

namespace mesh_map {

/// Numbers as bytes, the lowest first, whatever the machine does.
class ByteWriter
{
 public:
  explicit ByteWriter(std::size_t size) { bytes_.reserve(size); }

  template <class T>
  void write(T value)
  {
    std::uint8_t bytes[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof(T));
  }

  std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

template <class T>
T readNumber(const std::uint8_t* bytes)
{
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= static_cast<T>(static_cast<T>(bytes[i]) << (8 * i));
  }
  return value;
}

/// Mixes a word into a hash: the product spreads it upwards, the shift downwards.
inline std::uint64_t mixed(std::uint64_t hash, std::uint64_t word)
{
  hash = (hash ^ word) * 0x9E3779B97F4A7C15u;  // 2^64 / golden ratio, odd
  return hash ^ (hash >> 32);
}

inline std::uint64_t pairOf(float low, float high)
{
  return bitsOf(low) | std::uint64_t{bitsOf(high)} << 32;
}

/// Tells damaged bytes from whole ones.
inline std::uint64_t checksum(const std::uint8_t* bytes, std::size_t size)
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

/// Tells meshes apart: from the number of a face and the bits of its 9 coordinates. Those of all
/// faces are added, in any order.
inline std::uint64_t faceHash(std::uint32_t face, const float* a, const float* b, const float* c)
{
  std::uint64_t hash = mixed(0, face);
  hash = mixed(hash, pairOf(a[0], a[1]));
  hash = mixed(hash, pairOf(a[2], b[0]));
  hash = mixed(hash, pairOf(b[1], b[2]));
  hash = mixed(hash, pairOf(c[0], c[1]));
  return mixed(hash, pairOf(c[2], 1.0f));
}

}  // namespace mesh_map
