// A mesh that several displays show is converted once, and is in memory once.
#include <cstddef>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "conversion/mesh_conversion.h"
#include "support/label_display_fixture.h"

using rviz_mesh_plugin::conversions;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::MeshDataConstPtr;
using rviz_mesh_plugin::TexturedMeshDisplay;

class SharedMeshTest : public LabelDisplayFixture
{
 protected:
  static mesh_msgs::MeshGeometryStamped terrain(std::uint32_t cells, const char* uuid = "mesh")
  {
    auto message = test_meshes::terrain(cells, [](double x, double y) { return x * y; });
    message.uuid = uuid;
    return message;
  }

  /// The mesh of so many faces, once a display has it; null where it does not come.
  template <class Kind>
  static MeshDataConstPtr meshOf(const Kind* display, std::size_t faces)
  {
    const auto has = [&] { return display->mesh() && display->mesh()->faceCount() == faces; };
    return spinUntil(has, TIMEOUT) ? display->mesh() : nullptr;
  }
};

TEST_F(SharedMeshTest, displays_of_one_topic_convert_each_mesh_once)
{
  const std::size_t before = conversions;
  TexturedMeshDisplay* mesh = createMeshDisplay();
  Display* labels = createLabels();
  for (std::uint32_t cells = 10; cells < 20; ++cells) {
    geometry.publish(terrain(cells));
    const MeshDataConstPtr shown = meshOf(mesh, 2 * cells * cells);
    ASSERT_TRUE(shown);
    EXPECT_EQ(meshOf(labels, 2 * cells * cells), shown);
    EXPECT_EQ(conversions - before, cells - 9);
  }
  TexturedMeshDisplay* late = createMeshDisplay();
  EXPECT_EQ(meshOf(late, 722), mesh->mesh()) << "the latched message comes once more";
  EXPECT_EQ(conversions - before, 10u);
}

TEST_F(SharedMeshTest, displays_of_different_topics_have_meshes_of_their_own)
{
  auto elsewhere = node.advertise<mesh_msgs::MeshGeometryStamped>(name_space + "/other", 1, true);
  TexturedMeshDisplay* mesh = createMeshDisplay();
  Display* labels = createLabels();
  set(labels, {"Geometry Topic"}, (name_space + "/other").c_str());
  const std::size_t before = conversions;
  geometry.publish(terrain(10));
  elsewhere.publish(terrain(12));
  ASSERT_TRUE(meshOf(mesh, 200)) << "the same uuid, and another content";
  ASSERT_TRUE(meshOf(labels, 288));
  EXPECT_EQ(conversions - before, 2u);
  elsewhere.publish(terrain(10, "other"));
  ASSERT_TRUE(meshOf(labels, 200));
  EXPECT_EQ(labels->mesh()->uuid, "other");
  EXPECT_NE(labels->mesh(), mesh->mesh());
  EXPECT_EQ(conversions - before, 3u);
  elsewhere.publish(terrain(10));
  EXPECT_TRUE(spinUntil([&] { return labels->mesh() == mesh->mesh(); }, TIMEOUT));
  EXPECT_EQ(conversions - before, 3u) << "it is in memory already";
}

TEST_F(SharedMeshTest, each_display_is_left_with_it_when_the_other_goes)
{
  TexturedMeshDisplay* mesh = createMeshDisplay();
  Display* labels = createLabels();
  geometry.publish(terrain(10));
  const std::weak_ptr<const MeshData> shared = meshOf(mesh, 200);
  ASSERT_EQ(meshOf(labels, 200), shared.lock());
  const std::size_t before = conversions;
  for (rviz::Display* display :
       {static_cast<rviz::Display*>(mesh), static_cast<rviz::Display*>(labels)}) {
    display->setEnabled(false);
    spinFrames(2);
    display->setEnabled(true);
    display->reset();
    EXPECT_EQ(meshOf(labels, 200), shared.lock());
    EXPECT_EQ(meshOf(mesh, 200), shared.lock());
  }
  delete labels;
  spinFrames(2);
  EXPECT_EQ(mesh->mesh(), shared.lock());
  labels = createLabels();
  EXPECT_EQ(meshOf(labels, 200), shared.lock());
  delete mesh;
  spinFrames(2);
  EXPECT_EQ(labels->mesh(), shared.lock());
  mesh = createMeshDisplay();
  EXPECT_EQ(meshOf(mesh, 200), shared.lock());
  EXPECT_EQ(conversions, before);
  delete mesh;
  delete labels;
  EXPECT_TRUE(spinUntil([&] { return shared.expired(); }, TIMEOUT)) << "something keeps it alive";
}
