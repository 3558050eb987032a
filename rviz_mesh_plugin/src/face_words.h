#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace rviz_mesh_plugin {

/// Sets of faces as bits, the lowest face in the lowest bit of the first word.
using FaceWord = std::uint64_t;
using FaceWords = std::vector<FaceWord>;
constexpr std::uint32_t FACE_BITS = 64;

/// Calls back for each bit that is set, from the lowest.
template <class Visit>
void visitBits(FaceWord word, std::uint32_t first, const Visit& visit)
{
  if (word == ~FaceWord{0}) {
    for (std::uint32_t bit = first; bit != first + FACE_BITS; ++bit) {
      visit(bit);
    }
    return;
  }
  for (; word != 0; word &= word - 1) {
    visit(first + static_cast<std::uint32_t>(__builtin_ctzll(word)));
  }
}

/// The faces that are in the one and not in the other, ascending.
inline void subtract(const FaceWords& from, const FaceWords& other,
                     std::vector<std::uint32_t>& faces)
{
  std::size_t count = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    count += static_cast<std::size_t>(__builtin_popcountll(from[i] & ~other[i]));
  }
  faces.resize(count);
  std::uint32_t* next = faces.data();
  for (std::size_t i = 0; i < from.size(); ++i) {
    visitBits(from[i] & ~other[i], static_cast<std::uint32_t>(FACE_BITS * i),
              [&](std::uint32_t face) { *next++ = face; });
  }
}

/// Turns the bits of [begin, end) round.
inline void toggle(FaceWords& words, std::uint32_t begin, std::uint32_t end)
{
  while (begin < end) {
    const std::uint32_t bit = begin % FACE_BITS;
    const std::uint32_t count = std::min(end - begin, FACE_BITS - bit);
    const FaceWord ones = count == FACE_BITS ? ~FaceWord{0} : (FaceWord{1} << count) - 1;
    words[begin / FACE_BITS] ^= ones << bit;
    begin += count;
  }
}

}  // namespace rviz_mesh_plugin
