#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "bvh/selection/bvh_selection_sort.h"

using namespace mesh_map;

namespace {

using Faces = std::vector<std::uint32_t>;

Faces permutation(std::size_t count)
{
  Faces faces(count);
  std::iota(faces.begin(), faces.end(), 0u);
  std::shuffle(faces.begin(), faces.end(), std::mt19937(1));
  return faces;
}

}  // namespace

TEST(SortFaces, sorts)
{
  for (const std::size_t limit : {1u, 2u, 64u, 65u, 255u, 257u, 5000u, 70000u, 300000u}) {
    for (const double share : {0.0, 0.01, 0.5, 1.0}) {
      Faces faces = permutation(limit);
      faces.resize(static_cast<std::size_t>(share * static_cast<double>(limit)));
      Faces expected = faces;
      std::sort(expected.begin(), expected.end());
      sortFaces(faces);
      ASSERT_EQ(faces, expected) << limit << ", " << share;
    }
  }
}

TEST(SortFaces, sortsLargeNumbers)
{
  std::mt19937 random(2);
  for (const std::size_t count : {10u, 1000u, 10000u}) {
    Faces faces(count);
    for (std::uint32_t& face : faces) {
      face = static_cast<std::uint32_t>(random());
    }
    Faces expected = faces;
    std::sort(expected.begin(), expected.end());
    sortFaces(faces);
    ASSERT_EQ(faces, expected) << count;
  }
}

TEST(FaceSet, givesEachOnceAscending)
{
  for (const std::size_t limit : {1u, 63u, 64u, 256u, 257u, 10000u}) {
    FaceSet set(limit);
    Faces expected;
    for (const std::uint32_t face : permutation(limit)) {
      if (face % 3 == 0 || (face >= 512 && face < 1100)) {
        set.add(face);
        set.add(face);
        expected.push_back(face);
      }
    }
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(set.sorted(expected.size()), expected) << limit;
    EXPECT_EQ(set.sorted(limit), expected) << limit;
  }
}

TEST(FacesOf, areThoseOfTheRangesThatTheMaskHas)
{
  std::mt19937 random(3);
  for (const std::size_t count : {10u, 3000u, 100000u}) {
    const Faces faces = permutation(count);
    for (const std::uint32_t step : {2u, 100u, 90000u}) {
      std::vector<TriangleRange> ranges;
      std::vector<std::uint8_t> mask(count);
      Faces all, masked;
      for (std::uint8_t& entry : mask) {
        entry = random() % 2 == 0 ? 255 : 0;
      }
      for (std::uint32_t begin = 0; begin < count; begin += step) {
        const auto end =
            static_cast<std::uint32_t>(std::min<std::size_t>(count, begin + random() % (step + 1)));
        ranges.push_back({begin, end});
        for (std::uint32_t i = begin; i < end; ++i) {
          all.push_back(faces[i]);
          if (mask[faces[i]] != 0) {
            masked.push_back(faces[i]);
          }
        }
      }
      std::sort(all.begin(), all.end());
      std::sort(masked.begin(), masked.end());
      ASSERT_EQ(facesOf(faces, ranges, {}), all) << count << ", " << step;
      ASSERT_EQ(facesOf(faces, ranges, mask), masked) << count << ", " << step;
    }
  }
}
