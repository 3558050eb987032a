#include "labels/face_parents.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

using rviz_mesh_plugin::FaceParents;
using rviz_mesh_plugin::wholeFaces;

using Faces = std::vector<std::uint32_t>;

TEST(FaceParents, bring_all_parts_of_their_faces)
{
  const FaceParents parents{2, 0, 2, 7, 0, 1};
  EXPECT_EQ(wholeFaces({}, parents), Faces());
  EXPECT_EQ(wholeFaces({0}, parents), (Faces{0, 2}));
  EXPECT_EQ(wholeFaces({2, 4}, parents), (Faces{0, 1, 2, 4}));
  EXPECT_EQ(wholeFaces({3}, parents), (Faces{3}));
  EXPECT_EQ(wholeFaces({0, 1, 2, 3, 4, 5}, parents), (Faces{0, 1, 2, 3, 4, 5}));
}

TEST(FaceParents, leave_faces_of_another_mesh_as_they_are)
{
  EXPECT_EQ(wholeFaces({1, 6}, {3, 3}), (Faces{0, 1, 6}));
  EXPECT_EQ(wholeFaces({1, 6}, {}), (Faces{1, 6}));
}
