#include "bvh/selection/bvh_selection_sort.h"

#include <algorithm>
#include <array>

namespace mesh_map {

namespace {

/// From this share of all faces on, a bit for each is less work than sorting.
constexpr std::size_t BITS_FROM = 512;

constexpr unsigned DIGIT = 11;  // bits
constexpr std::size_t DIGITS = std::size_t{1} << DIGIT;

/// Sorts by one digit of each number, keeping the order of those that have the same.
void sortByDigit(const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to,
                 unsigned shift, unsigned bits)
{
  std::array<std::uint32_t, DIGITS> places;
  const std::uint32_t digits = 1u << bits;
  std::fill(places.begin(), places.begin() + digits, 0);
  for (const std::uint32_t number : from) {
    ++places[number >> shift & (digits - 1)];
  }
  std::uint32_t place = 0;
  for (std::uint32_t digit = 0; digit < digits; ++digit) {
    const std::uint32_t count = places[digit];
    places[digit] = place;
    place += count;
  }
  for (const std::uint32_t number : from) {
    to[places[number >> shift & (digits - 1)]++] = number;
  }
}

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

void sortFaces(std::vector<std::uint32_t>& faces, std::size_t limit)
{
  if (faces.size() < 64) {
    std::sort(faces.begin(), faces.end());
    return;
  }
  unsigned bits = 1;
  while (bits < 32 && ((limit - 1) >> bits) != 0) {
    ++bits;
  }
  // Few numbers are sorted by small digits: a pass costs as much as there are values of a digit.
  const unsigned largest = faces.size() < 4096 ? 8 : DIGIT;
  const unsigned passes = (bits + largest - 1) / largest;
  const unsigned digit = (bits + passes - 1) / passes;
  std::vector<std::uint32_t> other(faces.size());
  for (unsigned pass = 0; pass < passes; ++pass) {
    sortByDigit(faces, other, pass * digit, std::min(digit, bits - pass * digit));
    faces.swap(other);
  }
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
  sortFaces(result, faces.size());
  return result;
}

}  // namespace mesh_map
