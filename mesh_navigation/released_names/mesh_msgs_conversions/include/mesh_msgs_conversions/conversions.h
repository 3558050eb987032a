#ifndef MESH_MSGS_CONVERSIONS_CONVERSIONS_H
#define MESH_MSGS_CONVERSIONS_CONVERSIONS_H

#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/time.h>
#include <boost/shared_array.hpp>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

/// Messages of LVR2's meshes and attribute maps, and the way back, by the released names.
///
/// Everything is a template over what LVR2's classes can do, so that this header needs no LVR2:
/// include its headers yourself. The README says which functions of the release are not here.
namespace mesh_msgs_conversions {
namespace detail {
inline geometry_msgs::Point point(double x, double y, double z)
{
  geometry_msgs::Point point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

inline std::vector<geometry_msgs::Point> points(const boost::shared_array<float>& values,
                                                std::size_t count)
{
  std::vector<geometry_msgs::Point> found;
  found.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    found.push_back(point(values[3 * i], values[3 * i + 1], values[3 * i + 2]));
  }
  return found;
}

inline boost::shared_array<float> floats(const std::vector<geometry_msgs::Point>& points)
{
  boost::shared_array<float> values(new float[3 * points.size()]);
  for (std::size_t i = 0; i < points.size(); ++i) {
    values[3 * i] = static_cast<float>(points[i].x);
    values[3 * i + 1] = static_cast<float>(points[i].y);
    values[3 * i + 2] = static_cast<float>(points[i].z);
  }
  return values;
}

template <typename Stamped>
void setHeader(Stamped& message, const std::string& frame_id, const std::string& uuid,
               const ros::Time& stamp)
{
  message.header.frame_id = frame_id;
  message.header.stamp = stamp;
  message.uuid = uuid;
}

/// The normals of a mesh without any.
struct NoNormals
{
};

template <typename Mesh>
void addNormals(const Mesh&, const NoNormals&, std::vector<geometry_msgs::Point>&)
{
}

/// None at all unless every vertex has one: a message has one for each vertex, or none.
template <typename Mesh, typename Normals>
void addNormals(const Mesh& mesh, const Normals& normals, std::vector<geometry_msgs::Point>& found)
{
  if (normals.numValues() < mesh.numVertices()) {
    return;
  }
  for (const auto vertex : mesh.vertices()) {
    const auto& normal = normals[vertex];
    found.push_back(point(normal.x, normal.y, normal.z));
  }
}
}  // namespace detail

/// A half-edge mesh (lvr2::HalfEdgeMesh) as a message. Vertices are numbered in the mesh's order.
///
/// @param normals an lvr2::VertexMap of normals; without one for every vertex there are none
template <typename CoordT, typename Mesh, typename Normals = detail::NoNormals>
mesh_msgs::MeshGeometry toMeshGeometry(const Mesh& mesh, const Normals& normals = Normals())
{
  mesh_msgs::MeshGeometry message;
  std::map<std::size_t, std::uint32_t> numbers;  // of what a handle calls a vertex
  for (const auto vertex : mesh.vertices()) {
    const auto& place = mesh.getVertexPosition(vertex);
    numbers.emplace(vertex.idx(), message.vertices.size());
    message.vertices.push_back(detail::point(place.x, place.y, place.z));
  }
  for (const auto face : mesh.faces()) {
    mesh_msgs::MeshTriangleIndices triangle;
    const auto corners = mesh.getVerticesOfFace(face);
    for (std::size_t i = 0; i < 3; ++i) {
      triangle.vertex_indices[i] = numbers.at(corners[i].idx());
    }
    message.faces.push_back(triangle);
  }
  detail::addNormals(mesh, normals, message.vertex_normals);
  return message;
}

template <typename CoordT, typename Mesh, typename Normals = detail::NoNormals>
mesh_msgs::MeshGeometryStamped toMeshGeometryStamped(const Mesh& mesh, const std::string& frame_id,
                                                     const std::string& uuid,
                                                     const Normals& normals = Normals(),
                                                     const ros::Time& stamp = ros::Time::now())
{
  mesh_msgs::MeshGeometryStamped message;
  message.mesh_geometry = toMeshGeometry<CoordT>(mesh, normals);
  detail::setHeader(message, frame_id, uuid, stamp);
  return message;
}

/// Costs of an lvr2::VertexMap by the index of their vertex; default_value where there is none.
/// Vertices from num_values on are left out.
template <typename Costs>
mesh_msgs::MeshVertexCosts toVertexCosts(const Costs& costs, std::size_t num_values,
                                         float default_value)
{
  mesh_msgs::MeshVertexCosts message;
  message.costs.assign(num_values, default_value);
  for (const auto vertex : costs) {
    if (vertex.idx() < num_values) {
      message.costs[vertex.idx()] = costs[vertex];
    }
  }
  return message;
}

/// Costs of an lvr2::DenseVertexMap, one after the other.
template <typename Costs>
mesh_msgs::MeshVertexCosts toVertexCosts(const Costs& costs)
{
  mesh_msgs::MeshVertexCosts message;
  for (const auto vertex : costs) {
    message.costs.push_back(costs[vertex]);
  }
  return message;
}

template <typename Costs>
mesh_msgs::MeshVertexCostsStamped toVertexCostsStamped(const Costs& costs, std::size_t num_values,
                                                       float default_value, const std::string& name,
                                                       const std::string& frame_id,
                                                       const std::string& uuid,
                                                       const ros::Time& stamp = ros::Time::now())
{
  mesh_msgs::MeshVertexCostsStamped message;
  message.mesh_vertex_costs = toVertexCosts(costs, num_values, default_value);
  message.type = name;
  detail::setHeader(message, frame_id, uuid, stamp);
  return message;
}

template <typename Costs>
mesh_msgs::MeshVertexCostsStamped toVertexCostsStamped(const Costs& costs, const std::string& name,
                                                       const std::string& frame_id,
                                                       const std::string& uuid,
                                                       const ros::Time& stamp = ros::Time::now())
{
  mesh_msgs::MeshVertexCostsStamped message;
  message.mesh_vertex_costs = toVertexCosts(costs);
  message.type = name;
  detail::setHeader(message, frame_id, uuid, stamp);
  return message;
}

/// Vertices, faces and, if there are any, normals of an lvr2::MeshBufferPtr.
template <typename BufferPtr>
bool fromMeshBufferToMeshGeometryMessage(const BufferPtr& buffer, mesh_msgs::MeshGeometry& message)
{
  message = mesh_msgs::MeshGeometry();
  const std::size_t vertex_count = buffer->numVertices();
  message.vertices = detail::points(buffer->getVertices(), vertex_count);
  if (buffer->hasVertexNormals()) {
    message.vertex_normals = detail::points(buffer->getVertexNormals(), vertex_count);
  }
  const auto faces = buffer->getFaceIndices();
  message.faces.resize(buffer->numFaces());
  for (std::size_t i = 0; i < message.faces.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      message.faces[i].vertex_indices[corner] = faces[3 * i + corner];
    }
  }
  return true;
}

/// Vertices, faces and, if there is one for each vertex, normals into an lvr2::MeshBuffer.
template <typename Buffer>
bool fromMeshGeometryToMeshBuffer(const mesh_msgs::MeshGeometry& message, Buffer& buffer)
{
  buffer.setVertices(detail::floats(message.vertices), message.vertices.size());
  boost::shared_array<unsigned int> faces(new unsigned int[3 * message.faces.size()]);
  for (std::size_t i = 0; i < message.faces.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      faces[3 * i + corner] = message.faces[i].vertex_indices[corner];
    }
  }
  buffer.setFaceIndices(faces, message.faces.size());
  if (!message.vertices.empty() && message.vertex_normals.size() == message.vertices.size()) {
    buffer.setVertexNormals(detail::floats(message.vertex_normals));
  }
  return true;
}

template <typename Buffer>
bool fromMeshGeometryToMeshBuffer(const mesh_msgs::MeshGeometry& message,
                                  std::shared_ptr<Buffer>& buffer)
{
  return fromMeshGeometryToMeshBuffer(message, *buffer);
}

template <typename Buffer>
bool fromMeshGeometryToMeshBuffer(const mesh_msgs::MeshGeometryConstPtr& message, Buffer& buffer)
{
  return fromMeshGeometryToMeshBuffer(*message, buffer);
}

template <typename BufferPtr>
bool fromMeshGeometryMessageToMeshBuffer(const mesh_msgs::MeshGeometry& message,
                                         const BufferPtr& buffer)
{
  return fromMeshGeometryToMeshBuffer(message, *buffer);
}

}  // namespace mesh_msgs_conversions

#endif
