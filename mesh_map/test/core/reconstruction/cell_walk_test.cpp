// The cells that a line passes, beside those of points on it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "reconstruction/cell_walk.h"

namespace {

using namespace mesh_map;

std::vector<GridPlace> cellsOf(const Vector3f& a, const Vector3f& b)
{
  const CellWalk walk(a, b);
  std::vector<GridPlace> cells;
  walk.each([&cells](std::uint64_t key) { cells.push_back(GridPlace::of(key)); });
  EXPECT_EQ(walk.count(), cells.size());
  return cells;
}

bool isAt(const GridPlace& cell, const std::array<double, 3>& point, double tolerance)
{
  const auto is_within = [tolerance](std::int32_t low, double at) {
    return at > low - tolerance && at < low + 1 + tolerance;
  };
  return is_within(cell.x, point[0]) && is_within(cell.y, point[1]) && is_within(cell.z, point[2]);
}

TEST(CellWalk, PassesAllCellsOfALineOneBesideTheOther)
{
  std::mt19937 random(0);
  for (const float size : {0.4f, 3.0f, 50.0f}) {
    std::uniform_real_distribution<float> place(-size, size);
    for (int i = 0; i < 300; ++i) {
      const Vector3f a = {place(random), place(random), place(random)};
      Vector3f b = {place(random), place(random), place(random)};
      for (int k = 0; k < i % 4; ++k) {  // along axes, and nowhere
        b[(i + k) % 3] = a[(i + k) % 3];
      }
      const std::vector<GridPlace> cells = cellsOf(a, b);
      for (std::size_t k = 1; k < cells.size(); ++k) {
        EXPECT_EQ(std::abs(cells[k].x - cells[k - 1].x) + std::abs(cells[k].y - cells[k - 1].y) +
                      std::abs(cells[k].z - cells[k - 1].z),
                  1);
      }
      for (int k = 0; k <= 1000; ++k) {
        std::array<double, 3> point;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          point[axis] = a[axis] + 0.001 * k * (double{b[axis]} - a[axis]);
        }
        EXPECT_TRUE(std::any_of(cells.begin(), cells.end(), [&point](const GridPlace& cell) {
          return isAt(cell, point, 1e-4);
        }));
      }
    }
  }
}

TEST(CellWalk, EndsWhereTheLineEnds)
{
  EXPECT_EQ(cellsOf({0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}).size(), 1u);
  const std::vector<GridPlace> down = cellsOf({-0.5f, 2.5f, -3.5f}, {-0.5f, -1.5f, -3.5f});
  ASSERT_EQ(down.size(), 5u);
  EXPECT_EQ(down.front().y, 2);
  EXPECT_EQ(down.back().y, -2);
  EXPECT_EQ(down.back().x, -1);
  EXPECT_EQ(down.back().z, -4);
  const float most = GridPlace::LIMIT - 2;
  const std::vector<GridPlace> all = cellsOf({-most, 0, 0}, {most, 0, 0});
  EXPECT_EQ(all.size(), 2 * static_cast<std::size_t>(most) + 1);
  EXPECT_EQ(all.back().x, GridPlace::LIMIT - 2);
  // A step of the least float over the border of a cell.
  EXPECT_EQ(cellsOf({std::nextafter(1.0f, 0.0f), 0, 0}, {1, 0, 0}).size(), 2u);
}

}  // namespace
