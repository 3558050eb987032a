#include "bvh/selection/bvh_selection_sort.h"

#include <algorithm>

#include "base/radix_sort.h"

namespace mesh_map {

namespace {

/// From this share of all faces on, a bit for each is less work than sorting.
constexpr std::size_t BITS_FROM = 512;

}  // namespace

std::vector<std::uint32_t> FaceSet::sorted(std::size_t most) const
{
  std::vector<std::uint32_t> faces(most);
  std::uint32_t* next = faces.data();
  for (std::size_t block = 0; block < words_.size(); block += WORDS) {
    const std::uint64_t* const words = words_.data() + block;
    if ((words[0] | words[1] | words[2] | words[3]) == 0) {
      continue;
    }
    for (std::size_t i = 0; i < WORDS; ++i) {
      const auto first = static_cast<std::uint32_t>(64 * (block + i));
      if (words[i] == ~std::uint64_t{0}) {
        for (std::uint32_t bit = 0; bit < 64; ++bit) {
          *next++ = first + bit;
        }
        continue;
      }
      for (std::uint64_t word = words[i]; word != 0; word &= word - 1) {
        *next++ = first + static_cast<std::uint32_t>(__builtin_ctzll(word));
      }
    }
  }
  faces.resize(static_cast<std::size_t>(next - faces.data()));
  return faces;
}

void sortFaces(std::vector<std::uint32_t>& faces)
{
  if (faces.size() < 64) {
    std::sort(faces.begin(), faces.end());
    return;
  }
  Run run({1, nullptr, {}});
  radixSort(
      faces, [](std::uint32_t face) { return face; }, run, 0.0);
}

std::vector<std::uint32_t> facesOf(ArrayView<std::uint32_t> faces,
                                   const std::vector<TriangleRange>& ranges,
                                   ArrayView<std::uint8_t> mask)
{
  std::size_t count = 0;
  for (const TriangleRange& range : ranges) {
    count += range.end - range.begin;
  }
  const auto visit = [&](const auto& take) {
    for (const TriangleRange& range : ranges) {
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        if (mask.empty() || mask[faces[i]] != 0) {
          take(faces[i]);
        }
      }
    }
  };
  if (count >= faces.size() / BITS_FROM) {
    FaceSet set(faces.size());
    visit([&set](std::uint32_t face) { set.add(face); });
    return set.sorted(count);
  }
  std::vector<std::uint32_t> result;
  result.reserve(count);
  visit([&result](std::uint32_t face) { result.push_back(face); });
  sortFaces(result);
  return result;
}

}  // namespace mesh_map
