#include <gtest/gtest.h>
#include <mesh_msgs_conversions/conversions.h>
#include <boost/make_shared.hpp>

#include <array>
#include <memory>

namespace {
using namespace mesh_msgs_conversions;

/// Stand-ins for LVR2's classes, with the members that programs call.
struct Handle
{
  std::size_t index;
  std::size_t idx() const { return index; }
};

struct Vector
{
  float x, y, z;
};

template <typename Value>
struct VertexMap
{
  std::map<std::size_t, Value> values;
  const Value& operator[](Handle handle) const { return values.at(handle.index); }
  std::size_t numValues() const { return values.size(); }

  struct Iterator
  {
    typename std::map<std::size_t, Value>::const_iterator at;
    Handle operator*() const { return Handle{at->first}; }
    Iterator& operator++()
    {
      ++at;
      return *this;
    }
    bool operator!=(const Iterator& other) const { return at != other.at; }
  };
  Iterator begin() const { return {values.begin()}; }
  Iterator end() const { return {values.end()}; }
};

/// A square of two faces; vertex 1 was deleted.
struct HalfEdgeMesh
{
  VertexMap<Vector> places{{{0, {0, 0, 0}}, {2, {1, 0, 0}}, {3, {1, 1, 0}}, {4, {0, 1, 5}}}};
  std::vector<std::array<Handle, 3>> triangles{
      std::array<Handle, 3>{{Handle{0}, Handle{2}, Handle{3}}},
      std::array<Handle, 3>{{Handle{0}, Handle{3}, Handle{4}}}};

  const VertexMap<Vector>& vertices() const { return places; }
  std::vector<Handle> faces() const { return {{0}, {1}}; }
  std::size_t numVertices() const { return places.numValues(); }
  const Vector& getVertexPosition(Handle handle) const { return places[handle]; }
  std::array<Handle, 3> getVerticesOfFace(Handle face) const { return triangles[face.index]; }
};

struct MeshBuffer
{
  boost::shared_array<float> vertices, normals;
  boost::shared_array<unsigned int> faces;
  std::size_t vertex_count = 0, face_count = 0;

  std::size_t numVertices() const { return vertex_count; }
  std::size_t numFaces() const { return face_count; }
  bool hasVertexNormals() const { return static_cast<bool>(normals); }
  boost::shared_array<float> getVertices() const { return vertices; }
  boost::shared_array<float> getVertexNormals() const { return normals; }
  boost::shared_array<unsigned int> getFaceIndices() const { return faces; }
  void setVertices(boost::shared_array<float> values, std::size_t count)
  {
    vertices = values;
    vertex_count = count;
  }
  void setFaceIndices(boost::shared_array<unsigned int> values, std::size_t count)
  {
    faces = values;
    face_count = count;
  }
  void setVertexNormals(boost::shared_array<float> values) { normals = values; }
};

std::vector<std::array<unsigned int, 3>> corners(const mesh_msgs::MeshGeometry& mesh)
{
  std::vector<std::array<unsigned int, 3>> found;
  for (const auto& face : mesh.faces) {
    found.push_back({{face.vertex_indices[0], face.vertex_indices[1], face.vertex_indices[2]}});
  }
  return found;
}

TEST(ConversionsTest, a_mesh_with_gaps_in_its_handles)
{
  const auto message = toMeshGeometryStamped<float>(HalfEdgeMesh(), "map", "garden",
                                                    detail::NoNormals(), ros::Time(7));
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.header.stamp, ros::Time(7));
  EXPECT_EQ(message.uuid, "garden");
  ASSERT_EQ(message.mesh_geometry.vertices.size(), 4u);
  EXPECT_EQ(message.mesh_geometry.vertices[3].z, 5);
  const std::vector<std::array<unsigned int, 3>> expected{{{0, 1, 2}}, {{0, 2, 3}}};
  EXPECT_EQ(corners(message.mesh_geometry), expected);
  EXPECT_TRUE(message.mesh_geometry.vertex_normals.empty());
}

TEST(ConversionsTest, normals_of_all_vertices_or_none)
{
  const HalfEdgeMesh mesh;
  VertexMap<Vector> normals{{{0, {0, 0, 1}}, {2, {0, 1, 0}}, {3, {1, 0, 0}}}};
  EXPECT_TRUE(toMeshGeometry<float>(mesh, normals).vertex_normals.empty());
  normals.values[4] = {0, 0, -1};
  const auto found = toMeshGeometry<float>(mesh, normals).vertex_normals;
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[1].y, 1);
  EXPECT_EQ(found[3].z, -1);
}

TEST(ConversionsTest, costs_by_index_and_one_after_the_other)
{
  const VertexMap<float> costs{{{0, 0.5f}, {3, 2.0f}, {9, 8.0f}}};
  const auto by_index = toVertexCostsStamped(costs, 5, -1, "slope", "map", "garden", ros::Time(7));
  EXPECT_EQ(by_index.mesh_vertex_costs.costs, (std::vector<float>{0.5f, -1, -1, 2, -1}));
  EXPECT_EQ(by_index.type, "slope");
  EXPECT_EQ(by_index.uuid, "garden");
  const auto dense = toVertexCostsStamped(costs, "slope", "map", "garden", ros::Time(7));
  EXPECT_EQ(dense.mesh_vertex_costs.costs, (std::vector<float>{0.5f, 2, 8}));
}

TEST(ConversionsTest, a_buffer_and_back)
{
  mesh_msgs::MeshGeometry message = toMeshGeometry<float>(HalfEdgeMesh());
  const auto buffer = std::make_shared<MeshBuffer>();
  ASSERT_TRUE(fromMeshGeometryMessageToMeshBuffer(message, buffer));
  EXPECT_EQ(buffer->numVertices(), 4u);
  EXPECT_EQ(buffer->numFaces(), 2u);
  EXPECT_FALSE(buffer->hasVertexNormals());
  message.vertex_normals.resize(3);  // not one for each vertex
  ASSERT_TRUE(fromMeshGeometryToMeshBuffer(message, *buffer));
  EXPECT_FALSE(buffer->hasVertexNormals());
  message.vertex_normals.resize(4);
  message.vertex_normals[2].x = 1;
  ASSERT_TRUE(fromMeshGeometryToMeshBuffer(message, *buffer));
  mesh_msgs::MeshGeometry found;
  found.faces.resize(9);
  ASSERT_TRUE(fromMeshBufferToMeshGeometryMessage(buffer, found));
  EXPECT_EQ(found, message);
}

TEST(ConversionsTest, pointers_to_messages_and_buffers)
{
  const auto message = boost::make_shared<mesh_msgs::MeshGeometry>();
  message->vertices.resize(3);
  auto buffer = std::make_shared<MeshBuffer>();
  EXPECT_TRUE(fromMeshGeometryToMeshBuffer(*message, buffer));
  EXPECT_EQ(buffer->numVertices(), 3u);
  message->vertices.resize(5);
  EXPECT_TRUE(fromMeshGeometryToMeshBuffer(message, buffer));
  EXPECT_EQ(buffer->numVertices(), 5u);
  message->vertices.resize(7);
  EXPECT_TRUE(fromMeshGeometryToMeshBuffer(mesh_msgs::MeshGeometryConstPtr(message), *buffer));
  EXPECT_EQ(buffer->numVertices(), 7u);
}
}  // namespace
