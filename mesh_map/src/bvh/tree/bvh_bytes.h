#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

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

/// Tells damaged bytes from whole ones.
std::uint64_t checksum(const std::uint8_t* bytes, std::size_t size);

/// Tells meshes apart: from the number of a face and the bits of its 9 coordinates. Those of all
/// faces are added, in any order.
std::uint64_t faceHash(std::uint32_t face, const float* a, const float* b, const float* c);

}  // namespace mesh_map
