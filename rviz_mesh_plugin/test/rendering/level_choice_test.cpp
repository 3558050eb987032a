#include "rendering/level_choice.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rendering/ogre/finite_bounds.h"

using namespace rviz_mesh_plugin;

TEST(LevelChoice, the_coarsest_level_whose_cells_are_small_enough)
{
  const std::vector<float> cells{0.0f, 0.5f, 1.0f, 2.0f};
  EXPECT_EQ(chooseLevel(cells, 0.0f), 0u);
  EXPECT_EQ(chooseLevel(cells, 0.49f), 0u);
  EXPECT_EQ(chooseLevel(cells, 0.5f), 1u);
  EXPECT_EQ(chooseLevel(cells, 1.99f), 2u);
  EXPECT_EQ(chooseLevel(cells, 1e30f), 3u);
  EXPECT_EQ(chooseLevel(cells, std::numeric_limits<float>::infinity()), 3u);
  EXPECT_EQ(chooseLevel(cells, std::numeric_limits<float>::quiet_NaN()), 0u);
  EXPECT_EQ(chooseLevel({0.0f}, 1.0f), 0u);
  EXPECT_EQ(chooseLevel({}, 1.0f), 0u);
}

TEST(LevelChoice, a_pixel_covers_more_with_the_distance_only_in_perspective)
{
  EXPECT_EQ((PixelSize{0.01f, true}.at(100.0f)), 1.0f);
  EXPECT_EQ((PixelSize{0.01f, true}.at(0.0f)), 0.0f);
  EXPECT_EQ((PixelSize{0.01f, false}.at(100.0f)), 0.01f);
}

TEST(FiniteBounds, what_ogre_gets_never_overflows)
{
  constexpr float LARGEST = std::numeric_limits<float>::max();
  const auto box = finiteBounds({{-LARGEST, -1, 0}, {LARGEST, 1, 0}}, LARGEST);
  EXPECT_TRUE(box.isFinite());
  for (const float value : {box.getSize().squaredLength(), radiusAboutOrigin(box)}) {
    EXPECT_TRUE(std::isfinite(value)) << value;
  }
  const auto small = finiteBounds({{-3, -2, 0}, {1, 1, 1}}, 0.5f);
  EXPECT_EQ(small.getMinimum(), Ogre::Vector3(-3.5f, -2.5f, -0.5f));
  EXPECT_EQ(small.getMaximum(), Ogre::Vector3(1.5f, 1.5f, 1.5f));
  EXPECT_FLOAT_EQ(radiusAboutOrigin(small), std::sqrt(3.5f * 3.5f + 2.5f * 2.5f + 1.5f * 1.5f));
}
