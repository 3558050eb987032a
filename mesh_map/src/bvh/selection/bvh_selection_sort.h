#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Some of the numbers from 0 to a count, a bit for each, which come out ascending.
class FaceSet
{
 public:
  explicit FaceSet(std::size_t count) : words_((count + 255) / 256 * WORDS, 0) {}

  void add(std::uint32_t face) { words_[face / 64] |= std::uint64_t{1} << face % 64; }

  /// What was added: not more numbers than `most`.
  std::vector<std::uint32_t> sorted(std::size_t most) const;

 private:
  static constexpr std::size_t WORDS = 4;  // looked at together

  std::vector<std::uint64_t> words_;
};

void sortFaces(std::vector<std::uint32_t>& faces);

/// Triangles [begin, end) in the order of the leaves.
struct TriangleRange
{
  std::uint32_t begin, end;
};

/// Ranges that do not overlap, as faces, ascending, as far as the mask has them (empty: all).
std::vector<std::uint32_t> facesOf(ArrayView<std::uint32_t> faces,
                                   const std::vector<TriangleRange>& ranges,
                                   ArrayView<std::uint8_t> mask);

}  // namespace mesh_map
