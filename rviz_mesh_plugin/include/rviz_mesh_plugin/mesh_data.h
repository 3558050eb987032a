#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// Red, green, blue, alpha in 0..255, in the byte order that vertex buffers are filled with.
struct Rgba8
{
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  std::uint8_t alpha = 255;
};
static_assert(sizeof(Rgba8) == 4, "vertex color buffers hold 4 bytes per vertex");

inline bool operator==(const Rgba8& a, const Rgba8& b)
{
  return a.red == b.red && a.green == b.green && a.blue == b.blue && a.alpha == b.alpha;
}

/// One vertex as it lies in the vertex buffer, in meters; the normal has length 1, or 0 where none
/// can be told.
struct MeshVertex
{
  std::array<float, 3> position{};
  std::array<float, 3> normal{};
};
static_assert(sizeof(MeshVertex) == 24, "vertex buffers hold position and normal without padding");

/// A checked triangle mesh, ready for upload: all indices are below vertices.size(), all numbers
/// finite.
struct MeshData
{
  std::string uuid;
  std::string frame_id;
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< three per face
  std::array<float, 3> lower{};        ///< bounding box, in meters
  std::array<float, 3> upper{};
  bool normals_given = false;  ///< false: computed from the faces

  std::size_t vertexCount() const { return vertices.size(); }
  std::size_t faceCount() const { return indices.size() / 3; }
};

/// One cost per vertex: finite is a cost, +inf is lethal, NaN is unknown.
struct CostLayer
{
  std::string uuid;  ///< of the geometry that the costs belong to
  std::string type;  ///< name of the layer
  std::vector<float> costs;
};

/// One color per vertex.
struct ColorLayer
{
  std::string uuid;  ///< of the geometry that the colors belong to
  std::vector<Rgba8> colors;
};

using MeshDataConstPtr = std::shared_ptr<const MeshData>;
using CostLayerConstPtr = std::shared_ptr<const CostLayer>;
using ColorLayerConstPtr = std::shared_ptr<const ColorLayer>;

}  // namespace rviz_mesh_plugin
