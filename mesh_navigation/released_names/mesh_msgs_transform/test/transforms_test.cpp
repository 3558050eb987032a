#include <gtest/gtest.h>
#include <mesh_msgs_transform/transforms.h>
#include <tf/transform_listener.h>

#include <cmath>
#include <type_traits>

namespace {
using mesh_msgs_transform::transformGeometryMeshNoTime;
using mesh_msgs_transform::transformTriangleMesh;
using mesh_msgs_transform::transformTriangleMeshNoTime;

static_assert(std::is_base_of<tf::Transformer, tf::TransformListener>::value,
              "programs pass a TransformListener");

geometry_msgs::Point point(double x, double y, double z)
{
  geometry_msgs::Point point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

void expectPoint(const geometry_msgs::Point& found, double x, double y, double z)
{
  EXPECT_NEAR(found.x, x, 1e-12);
  EXPECT_NEAR(found.y, y, 1e-12);
  EXPECT_NEAR(found.z, z, 1e-12);
}

/// robot in map: 10 m ahead, turned by 90 degrees; at 20 s another 1 m up.
class TransformsTest : public ::testing::Test
{
 protected:
  TransformsTest()
  {
    set(10, tf::Vector3(10, 0, 0));
    set(20, tf::Vector3(10, 0, 1));
    mesh.header.frame_id = "robot";
    mesh.header.stamp = ros::Time(12);
    mesh.uuid = "garden";
    mesh.mesh_geometry.vertices = {point(1, 2, 3), point(0, 0, 0), point(1, 0, 0)};
    mesh.mesh_geometry.vertex_normals = {point(0, 0, 1), point(1, 0, 0), point(0, 2, 0)};
    mesh.mesh_geometry.faces.resize(1);
    mesh.mesh_geometry.faces[0].vertex_indices = {{2, 0, 1}};
    old.header = mesh.header;
    old.mesh.vertices = mesh.mesh_geometry.vertices;
    old.mesh.vertex_normals = mesh.mesh_geometry.vertex_normals;
    old.mesh.vertex_colors.resize(3);
  }

  void set(double seconds, const tf::Vector3& place)
  {
    const tf::Transform pose(tf::createQuaternionFromYaw(M_PI / 2), place);
    tf.setTransform(tf::StampedTransform(pose, ros::Time(seconds), "map", "robot"));
  }

  tf::Transformer tf;
  mesh_msgs::MeshGeometryStamped mesh;
  mesh_msgs::TriangleMeshStamped old;
};

TEST_F(TransformsTest, vertices_are_moved_and_normals_rotated)
{
  mesh_msgs::MeshGeometryStamped found;
  ASSERT_TRUE(transformGeometryMeshNoTime("map", mesh, "map", found, tf));
  expectPoint(found.mesh_geometry.vertices[0], 8, 1, 4);
  expectPoint(found.mesh_geometry.vertices[1], 10, 0, 1);
  expectPoint(found.mesh_geometry.vertex_normals[0], 0, 0, 1);
  expectPoint(found.mesh_geometry.vertex_normals[1], 0, 1, 0);
  expectPoint(found.mesh_geometry.vertex_normals[2], -2, 0, 0);  // its length stays
  EXPECT_EQ(found.mesh_geometry.faces[0].vertex_indices,
            mesh.mesh_geometry.faces[0].vertex_indices);
  EXPECT_EQ(found.header.frame_id, "map");
  EXPECT_EQ(found.header.stamp, ros::Time(12));
  EXPECT_EQ(found.uuid, "garden");
}

TEST_F(TransformsTest, a_mesh_may_be_its_own_result)
{
  mesh_msgs::MeshGeometryStamped expected;
  ASSERT_TRUE(transformGeometryMeshNoTime("map", mesh, "map", expected, tf));
  ASSERT_TRUE(transformGeometryMeshNoTime("map", mesh, "map", mesh, tf));
  EXPECT_EQ(mesh.mesh_geometry.vertices, expected.mesh_geometry.vertices);
  EXPECT_EQ(mesh.header.frame_id, "map");
}

TEST_F(TransformsTest, what_tf_does_not_know_leaves_the_mesh_as_it_was)
{
  const mesh_msgs::MeshGeometryStamped before = mesh;
  tf.setTransform(tf::StampedTransform(tf::Transform::getIdentity(), ros::Time(10), "a", "b"));
  for (const char* target : {"nowhere", "b", ""}) {  // unknown, not connected, empty
    EXPECT_FALSE(transformGeometryMeshNoTime(target, mesh, "map", mesh, tf)) << target;
    EXPECT_FALSE(transformTriangleMeshNoTime(target, old, "map", old, tf)) << target;
  }
  EXPECT_EQ(mesh, before);
}

TEST_F(TransformsTest, meshes_of_release_1_0)
{
  mesh_msgs::TriangleMeshStamped found;
  ASSERT_TRUE(transformTriangleMeshNoTime("map", old, "map", found, tf));
  expectPoint(found.mesh.vertices[0], 8, 1, 4);
  EXPECT_EQ(found.mesh.vertex_colors, old.mesh.vertex_colors);
  // it was seen at 12 s, when the robot was 0.2 m up; the target is map at another time
  ASSERT_TRUE(transformTriangleMesh("map", ros::Time(20), old, "map", found, tf));
  expectPoint(found.mesh.vertices[0], 8, 1, 3.2);
  EXPECT_EQ(found.header.stamp, ros::Time(20));
  EXPECT_FALSE(transformTriangleMesh("robot", ros::Time(30), old, "map", found, tf));  // too late
}
}  // namespace
