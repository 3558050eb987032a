#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/mesh_data.h"
#include "base/vectors.h"

namespace rviz_mesh_plugin {

/// Tells a geometry from all others: where it is the same, the same faces by number are in the same
/// places. It outlives the mesh, and is compared at once, however large that is.
struct GeometryIdentity
{
  std::string uuid;
  std::size_t vertex_count = 0;
  std::size_t face_count = 0;
  std::uint64_t hash = 0;
};

inline bool operator==(const GeometryIdentity& a, const GeometryIdentity& b)
{
  return a.uuid == b.uuid && a.vertex_count == b.vertex_count && a.face_count == b.face_count &&
         a.hash == b.hash;
}

inline GeometryIdentity identityOf(const MeshData& mesh)
{
  return {mesh.uuid, mesh.vertexCount(), mesh.faceCount(), mesh.geometry_hash};
}

/// Each bit of the result depends on all (Steele, Lea and Flood, 2014: the finalizer of SplitMix).
inline std::uint64_t mixed(std::uint64_t bits)
{
  bits = (bits ^ bits >> 30) * 0xBF58476D1CE4E5B9u;
  bits = (bits ^ bits >> 27) * 0x94D049BB133111EBu;
  return bits ^ bits >> 31;
}

/// MeshData::geometry_hash is the sum of these of all vertices and faces, by their numbers: it can
/// be added up in any order.
inline std::uint64_t vertexHash(std::size_t vertex, const std::array<float, 3>& position)
{
  return mixed(hashOf(position) + mixed(vertex));
}
inline std::uint64_t faceHash(std::size_t face, const std::uint32_t* corners)
{
  return mixed((std::uint64_t{corners[0]} << 32 | corners[1]) +
               mixed(std::uint64_t{corners[2]} << 32 ^ ~std::uint64_t{face}));
}

}  // namespace rviz_mesh_plugin
