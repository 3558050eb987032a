#include "bvh/tree/bvh_check.h"

#include <mesh_map/bvh/tree/bvh_node.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "base/require.h"
#include "base/run.h"
#include "base/vector3.h"
#include "bvh/tree/float_box.h"

namespace mesh_map {

namespace {

constexpr std::size_t FACES_PER_CHUNK = 32768;

/// Faces with a vertex that is bad: how many, the first of them, and its first such vertex.
struct BadFaces
{
  std::size_t count = 0, first = 0;
  std::uint32_t vertex = 0;

  std::string name() const
  {
    const std::string others = " (and " + std::to_string(count - 1) + " face";
    return "face " + std::to_string(first) +
           (count < 2 ? "" : others + (count == 2 ? " more)" : "s more)"));
  }
};

template <class IsBad>
BadFaces findBad(const MeshView& mesh, const IsBad& isBad)
{
  BadFaces bad;
  for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
    const std::uint32_t* const corners = mesh.faces.data() + 3 * face;
    const std::uint32_t* const found = std::find_if(corners, corners + 3, isBad);
    if (found != corners + 3 && bad.count++ == 0) {
      bad.first = face;
      bad.vertex = *found;
    }
  }
  return bad;
}

}  // namespace

void checkFaceCount(const MeshView& mesh)
{
  require(mesh.faceCount() > 0,
          "a mesh without faces has no spatial index: give it at least one face");
  require(mesh.faceCount() < BVH_LEAF, "the mesh has " + std::to_string(mesh.faceCount()) +
                                           " faces, but a spatial index holds " +
                                           std::to_string(BVH_LEAF - 1) +
                                           " at most: divide the mesh");
}

bool facesAreSound(const MeshView& mesh, std::size_t begin, std::size_t end)
{
  const std::uint32_t* const corners = mesh.faces.data();
  std::uint32_t highest = 0;
  for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
    highest = std::max(highest, corners[i]);
  }
  if (highest >= mesh.vertexCount()) {
    return false;
  }
  Floats4 zero = all4(0.0f);  // NaN from the first number on that is not finite
  for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
    zero += load3(mesh.positions.data() + 3 * std::size_t{corners[i]}) * all4(0.0f);
  }
  return zero[0] == 0.0f && zero[1] == 0.0f && zero[2] == 0.0f;
}

void refuseFaces(const MeshView& mesh)
{
  const BadFaces lost = findBad(mesh, [&](std::uint32_t v) { return v >= mesh.vertexCount(); });
  require(lost.count == 0, lost.name() + " refers to vertex " + std::to_string(lost.vertex) +
                               ", but the mesh has " + std::to_string(mesh.vertexCount()) +
                               " vertices: remove such faces, or give all vertices");
  const BadFaces infinite =
      findBad(mesh, [&](std::uint32_t v) { return !isFinite(mesh.vertex(v)); });
  const float* const position = mesh.vertex(infinite.vertex);
  throw std::invalid_argument(
      infinite.name() + " has vertex " + std::to_string(infinite.vertex) + " at (" +
      std::to_string(position[0]) + ", " + std::to_string(position[1]) + ", " +
      std::to_string(position[2]) +
      "), which is not finite: remove such faces, or repair their vertices");
}

void checkMesh(const MeshView& mesh, Run& run, double share)
{
  checkFaceCount(mesh);
  std::atomic<bool> sound{true};
  run.loop(mesh.faceCount(), FACES_PER_CHUNK, share, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      if (!facesAreSound(mesh, begin, end)) {
        sound = false;
      }
    };
  });
  if (!sound) {
    refuseFaces(mesh);
  }
}

}  // namespace mesh_map
