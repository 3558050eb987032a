#include "mesh/repair/simplification.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>

#include "base/require.h"

#ifdef HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace mesh_map {

#ifdef HAVE_MESHOPTIMIZER
namespace {

using Position = std::array<float, 3>;

struct PositionHash
{
  std::size_t operator()(const Position& position) const
  {
    std::array<std::uint32_t, 3> bits;
    std::memcpy(bits.data(), position.data(), sizeof(bits));
    std::uint64_t hash = 0;
    for (const std::uint32_t part : bits) {
      hash = (hash ^ part) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// The faces that are not frozen, on vertices that belong to one region each.
///
/// meshoptimizer takes vertices at the same place for one. No two may be: a further one is moved by
/// the smallest step that float32 knows, so that edges between regions are borders, which it locks.
class RegionVertices
{
 public:
  RegionVertices(const MeshView& mesh, ArrayView<std::uint32_t> regions,
                 ArrayView<std::uint8_t> frozen)
      : mesh_(mesh)
  {
    constexpr std::uint32_t several = NO_INDEX - 1;
    std::vector<std::uint32_t> region_of(mesh.vertexCount(), NO_INDEX);
    for (std::size_t corner = 0; corner < mesh.faces.size(); ++corner) {
      if (frozen[corner / 3] == 0) {
        std::uint32_t& region = region_of[mesh.faces[corner]];
        region =
            region == NO_INDEX || region == regions[corner / 3] ? regions[corner / 3] : several;
      }
    }
    std::vector<std::uint32_t> numbers(mesh.vertexCount(), NO_INDEX);
    std::unordered_map<std::uint64_t, std::uint32_t> copies;
    places_.reserve(mesh.vertexCount());
    for (std::size_t corner = 0; corner < mesh.faces.size(); ++corner) {
      if (frozen[corner / 3] != 0) {
        continue;
      }
      const std::uint32_t vertex = mesh.faces[corner], region = regions[corner / 3];
      std::uint32_t* number = &numbers[vertex];
      if (region_of[vertex] == several) {
        const std::uint64_t key = (std::uint64_t{vertex} << 32) | region;
        number = &copies.emplace(key, NO_INDEX).first->second;
      }
      if (*number == NO_INDEX) {
        *number = add(vertex, region);
      }
      indices.push_back(*number);
    }
  }

  std::vector<unsigned> indices;                 // 3 per face
  std::vector<float> positions;                  // 3 per vertex
  std::vector<std::uint32_t> vertices, regions;  // of each: that of the mesh, and its region

 private:
  std::uint32_t add(std::uint32_t vertex, std::uint32_t region)
  {
    const float* const at = mesh_.vertex(vertex);
    Position position = {at[0] + 0.0f, at[1] + 0.0f, at[2] + 0.0f};  // no -0
    for (std::size_t axis = 0; !places_.insert(position).second; axis = (axis + 1) % 3) {
      position[axis] = std::nextafter(position[axis], std::numeric_limits<float>::infinity());
    }
    positions.insert(positions.end(), position.begin(), position.end());
    vertices.push_back(vertex);
    regions.push_back(region);
    return static_cast<std::uint32_t>(vertices.size() - 1);
  }

  MeshView mesh_;
  std::unordered_set<Position, PositionHash> places_;
};

}  // namespace
#endif

bool canSimplify()
{
#ifdef HAVE_MESHOPTIMIZER
  return true;
#else
  return false;
#endif
}

SimplifiedFaces simplifyFaces(const MeshView& mesh, ArrayView<std::uint32_t> regions,
                              ArrayView<std::uint8_t> frozen, std::size_t target, double max_error)
{
  require(regions.size() == mesh.faceCount() && frozen.size() == mesh.faceCount(),
          "regions and frozen need one value per face");
#ifdef HAVE_MESHOPTIMIZER
  SimplifiedFaces result;
  for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
    if (frozen[face] != 0) {
      const std::uint32_t* const corners = mesh.faces.data() + 3 * face;
      result.faces.insert(result.faces.end(), corners, corners + 3);
      result.regions.push_back(regions[face]);
    }
  }
  const RegionVertices parts(mesh, regions, frozen);
  const std::size_t kept = result.regions.size();
  if (parts.indices.empty()) {
    return result;
  }
  const std::size_t stride = 3 * sizeof(float), count = parts.vertices.size();
  const float scale = meshopt_simplifyScale(parts.positions.data(), count, stride);
  // The error may be more than the size of the mesh: then only the target counts.
  const double relative = scale > 0.0f ? std::min(max_error / double{scale}, 1e3) : 1e3;
  std::vector<unsigned> found(parts.indices.size());
  float error = 0.0f;
  found.resize(meshopt_simplify(found.data(), parts.indices.data(), parts.indices.size(),
                                parts.positions.data(), count, stride,
                                3 * (target > kept ? target - kept : 0),
                                static_cast<float>(relative), meshopt_SimplifyLockBorder, &error));
  result.error = double{error} * double{scale};
  for (std::size_t corner = 0; corner < found.size(); ++corner) {
    result.faces.push_back(parts.vertices[found[corner]]);
    if (corner % 3 == 0) {
      result.regions.push_back(parts.regions[found[corner]]);
    }
  }
  return result;
#else
  (void)target;
  (void)max_error;
  throw std::logic_error("mesh_map was built without meshoptimizer");
#endif
}

}  // namespace mesh_map
