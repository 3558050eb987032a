#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "base/cost_summary.h"

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
inline bool operator!=(const Rgba8& a, const Rgba8& b)
{
  return !(a == b);
}

/// One vertex as it lies in the vertex buffer, in meters; the normal has length 1, or 0 where none
/// can be told.
struct MeshVertex
{
  std::array<float, 3> position{};
  std::array<float, 3> normal{};
};
static_assert(sizeof(MeshVertex) == 24, "vertex buffers hold position and normal without padding");

/// A checked triangle mesh with its bounds, ready for upload: all indices are below
/// vertices.size(), all numbers finite.
struct MeshData : Bounds
{
  std::string uuid;
  std::string frame_id;
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< three per face
  std::uint64_t geometry_hash = 0;     ///< of vertices and faces, see GeometryIdentity
  bool normals_given = false;          ///< false: computed from the faces
  std::string remark;  ///< why it is not seen as it is, see findRemark(); else empty

  std::size_t vertexCount() const { return vertices.size(); }
  std::size_t faceCount() const { return indices.size() / 3; }
};

/// So many bytes of layers, and of textures, of a mesh are kept.
constexpr std::size_t MAX_ATTRIBUTE_BYTES = std::size_t{2} << 30;

/// What each of them costs beside its values, at most: names, choices, objects of OGRE.
constexpr std::size_t ATTRIBUTE_BYTES = std::size_t{1} << 18;

/// One cost per vertex, or per face: finite is a cost, +inf is lethal, NaN is unknown.
struct CostLayer
{
  std::string uuid;  ///< of the geometry that the costs belong to
  std::string type;  ///< name of the layer
  bool on_faces = false;
  std::vector<float> costs;
  CostSummary summary;      ///< of the costs
  std::uint64_t stamp = 0;  ///< of the message, in nanoseconds; 0: it has none

  /// What it counts for where there is a limit.
  std::size_t bytes() const { return sizeof(float) * costs.size() + ATTRIBUTE_BYTES; }
};

/// New costs of some vertices of a layer: costs[i] is that of vertices[i], the last one counts.
struct CostUpdate
{
  std::string uuid;  ///< of the geometry
  std::string type;  ///< name of the layer
  std::vector<std::uint32_t> vertices;
  std::vector<float> costs;  ///< as many
  std::uint64_t stamp = 0;   ///< of the message, in nanoseconds; 0: it has none
};

/// One color per vertex.
struct ColorLayer
{
  std::string uuid;  ///< of the geometry that the colors belong to
  std::vector<Rgba8> colors;
};

/// Stands for "no material" and "no texture".
constexpr std::uint32_t NONE = 0xFFFFFFFF;

struct Material
{
  Rgba8 color;
  std::uint32_t texture_index = NONE;
};

/// The materials of a mesh, all indices checked but those of textures, which arrive on their own.
struct Materials
{
  std::string uuid;  ///< of the geometry
  std::vector<Material> materials;
  /// The faces that have a material, and which: face_materials[i] is that of faces[i]. Both empty,
  /// and else faces ascending without repetition.
  std::vector<std::uint32_t> faces;
  std::vector<std::uint32_t> face_materials;
  /// One pair per vertex, or none at all; v runs from the top of the image, as OGRE wants it.
  std::vector<std::array<float, 2>> texture_coordinates;
};

/// Once the GUI thread has begun to upload it, it has no pixels any more, but what has been made of
/// them.
struct TextureImage
{
  std::string uuid;  ///< of the geometry
  std::uint32_t index = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  mutable std::vector<Rgba8> pixels;       ///< row by row from the top
  bool translucent = false;                ///< a pixel has an alpha below 255
  mutable std::shared_ptr<void> uploaded;  ///< the GUI thread's: see MeshTexture

  /// Of the pixels and their mipmaps, wherever they are.
  std::size_t bytes() const { return sizeof(Rgba8) * width * height / 3 * 4 + ATTRIBUTE_BYTES; }
};

/// A labelled set of faces, "class_instance".
struct LabelCluster
{
  std::string label;
  std::vector<std::uint32_t> faces;  ///< ascending, each once
};

/// Labels as they are now.
struct LabelSet
{
  std::string uuid;                    ///< of the geometry; empty: the only one
  bool all = false;                    ///< labels that are not among these are gone; else they stay
  std::vector<LabelCluster> clusters;  ///< each label once; one without faces is gone
};

using MeshDataConstPtr = std::shared_ptr<const MeshData>;
using CostLayerConstPtr = std::shared_ptr<const CostLayer>;
using CostUpdateConstPtr = std::shared_ptr<const CostUpdate>;
using ColorLayerConstPtr = std::shared_ptr<const ColorLayer>;
using MaterialsConstPtr = std::shared_ptr<const Materials>;
using TextureImageConstPtr = std::shared_ptr<const TextureImage>;
using LabelClusterConstPtr = std::shared_ptr<const LabelCluster>;
using LabelSetConstPtr = std::shared_ptr<const LabelSet>;
/// By label.
using LabelClusters = std::map<std::string, LabelClusterConstPtr>;

}  // namespace rviz_mesh_plugin
