// Angles between directions, against the arc sine in long double.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

#include "mesh/normals.h"

namespace {

using Direction = std::array<float, 3>;

constexpr long double PI = 3.14159265358979323846264338327950288L;

Direction unit(double x, double y, double z)
{
  const double length = std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x / length), static_cast<float>(y / length),
          static_cast<float>(z / length)};
}

/// In all directions; and about as far from the z axis as 1, 1/2, 1/4, ... of a half turn.
std::vector<Direction> directions(std::size_t count)
{
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Direction> all = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
  while (all.size() < count) {
    const double x = normal(random), y = normal(random), z = normal(random);
    const double near = std::ldexp(1.0, -static_cast<int>(all.size() % 30));
    all.push_back(all.size() % 3 == 0 ? unit(x, y, z)
                                      : unit(near * x, near * y, all.size() % 3 == 1 ? 1.0 : -1.0));
  }
  return all;
}

long double angle(const Direction& a, const Direction& b)
{
  long double chord = 0.0L, opposite = 0.0L;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const long double p = a[axis], q = b[axis];
    chord += (p - q) * (p - q);
    opposite += (p + q) * (p + q);
  }
  const auto of = [](long double squared) {
    return 2.0L * std::asin(std::min(0.5L * std::sqrt(squared), 1.0L));
  };
  return chord <= 2.0L ? of(chord) : PI - of(opposite);
}

TEST(Normals, AnglesBetweenDirectionsAreThoseOfTheArcSine)
{
  const std::vector<Direction> all = directions(3000);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Direction& other : {Direction{0, 0, 1}, all[(7 * i + 1) % all.size()]}) {
      const long double expected = angle(all[i], other);
      const double error = std::numeric_limits<double>::epsilon() * 4.0;
      EXPECT_NEAR(mesh_map::angleBetween(all[i].data(), other.data()),
                  static_cast<double>(expected), error * static_cast<double>(expected))
          << i;
    }
  }
}

/// However many there are: several are computed at once, and what is left one by one.
TEST(Normals, AnglesToADirectionAreTheSameBitsAsThoseOfPairs)
{
  const std::vector<Direction> all = directions(70000);  // more than a thread takes at once
  std::vector<float> numbers;
  for (const Direction& one : all) {
    numbers.insert(numbers.end(), one.begin(), one.end());
  }
  for (const std::array<double, 3>& to :
       {std::array<double, 3>{0, 0, 1}, {0.6, 0, -0.8}, {-0.48, 0.64, 0.6}}) {
    const Direction rounded = {static_cast<float>(to[0]), static_cast<float>(to[1]),
                               static_cast<float>(to[2])};
    for (std::size_t count : {0, 1, 2, 3, 4, 5, 7, 8, 9, 31, 40, 70000}) {
      const std::size_t first = all.size() - count;
      const auto angles = mesh_map::anglesTo({numbers.data() + 3 * first, 3 * count}, to);
      ASSERT_EQ(angles.size(), count);
      for (std::size_t i = 0; i < count; ++i) {
        const double expected = mesh_map::angleBetween(all[first + i].data(), rounded.data());
        ASSERT_EQ(angles[i], static_cast<float>(expected)) << i << " of " << count;
      }
    }
  }
}

TEST(Normals, WhatIsNoDirectionHasNoAngle)
{
  const std::vector<float> normals(15, std::numeric_limits<float>::quiet_NaN());
  for (const float one : mesh_map::anglesTo(normals, {0, 0, 1})) {
    EXPECT_TRUE(std::isnan(one));
  }
}

}  // namespace
