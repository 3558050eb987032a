#include "selection/face_neighbors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <mesh_map/mesh/topology.h>

#include "base/vectors.h"
#include "mesh_view/selectable_faces.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t SHARED = 0x80000000;

/// So many faces are looked at between two looks at the cancel flag.
constexpr std::size_t STRETCH = 1 << 16;

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

std::vector<std::uint32_t> joinedCorners(const MeshData& mesh)
{
  std::size_t places = 16;
  while (places < 2 * mesh.vertexCount()) {
    places *= 2;
  }
  std::vector<std::uint32_t> table(places, NONE);
  std::vector<std::uint32_t> first(mesh.vertexCount());  ///< in this place
  for (std::uint32_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
    const auto& position = mesh.vertices[vertex].position;
    std::size_t place = hashOf(position) & (places - 1);
    while (table[place] != NONE && mesh.vertices[table[place]].position != position) {
      place = (place + 1) & (places - 1);
    }
    if (table[place] == NONE) {
      table[place] = vertex;
    }
    first[vertex] = table[place];
  }
  std::vector<std::uint32_t> corners(mesh.indices.size());
  std::transform(mesh.indices.begin(), mesh.indices.end(), corners.begin(),
                 [&](std::uint32_t vertex) { return first[vertex]; });
  return corners;
}

FaceNeighbors::FaceNeighbors(const std::vector<std::uint32_t>& corners,
                             const std::atomic<bool>* cancel)
{
  const auto last = std::max_element(corners.begin(), corners.end());
  const std::size_t vertex_count = last == corners.end() ? 0 : std::size_t{*last} + 1;
  const mesh_map::Topology topology = mesh_map::buildTopology(corners, vertex_count);
  throwIfCanceled(cancel);
  const mesh_map::EdgeFaces rows = mesh_map::edgeFaces(topology.face_edges, topology.edgeCount());
  throwIfCanceled(cancel);
  shared_offsets_.push_back(0);
  std::vector<std::uint32_t> row_of_edge;  // that has more than two faces; empty where none has
  for (std::size_t edge = 0; edge < topology.edgeCount(); ++edge) {
    if (rows.offsets[edge + 1] - rows.offsets[edge] > 2) {
      row_of_edge.resize(topology.edgeCount());
      row_of_edge[edge] = static_cast<std::uint32_t>(shared_offsets_.size() - 1);
      shared_.insert(shared_.end(), rows.faces.begin() + rows.offsets[edge],
                     rows.faces.begin() + rows.offsets[edge + 1]);
      shared_offsets_.push_back(static_cast<std::uint32_t>(shared_.size()));
    }
  }
  sides_.assign(corners.size(), NONE);
  for (std::size_t side = 0; side < sides_.size(); ++side) {
    const std::uint32_t edge = topology.face_edges[side];
    if (edge == mesh_map::NO_INDEX ||
        (topology.face_flags[side / 3] & mesh_map::FACE_DEGENERATE) != 0) {
      continue;
    }
    const std::uint32_t* const faces = &rows.faces[rows.offsets[edge]];
    const std::size_t count = rows.offsets[edge + 1] - rows.offsets[edge];
    if (count == 2) {
      sides_[side] = faces[0] == side / 3 ? faces[1] : faces[0];
    } else if (count > 2) {
      sides_[side] = SHARED | row_of_edge[edge];
    }
  }
}

/// Calls back with each neighbor, perhaps more than once.
template <class Visit>
void FaceNeighbors::visit(std::uint32_t face, const Visit& visit) const
{
  for (std::size_t side = 3 * std::size_t{face}; side < 3 * std::size_t{face} + 3; ++side) {
    const std::uint32_t neighbor = sides_[side];
    if (neighbor == NONE) {
      continue;
    }
    if ((neighbor & SHARED) == 0) {
      visit(neighbor);
      continue;
    }
    const std::size_t row = neighbor & ~SHARED;
    for (std::uint32_t i = shared_offsets_[row]; i < shared_offsets_[row + 1]; ++i) {
      if (shared_[i] != face) {
        visit(shared_[i]);
      }
    }
  }
}

/// Of the sides that lie between selected faces and others: the faces that are selected, or the
/// others; ascending.
FaceNeighbors::Faces FaceNeighbors::border(const FaceBits& selection, bool selected,
                                           const std::atomic<bool>* cancel) const
{
  Faces ring;
  std::vector<bool> found(faceCount(), false);
  const auto look = [&](const std::uint32_t* begin, const std::uint32_t* end) {
    const auto is_selected = [&](std::uint32_t face) { return selection.contains(face); };
    if (std::all_of(begin, end, is_selected)) {
      return;
    }
    for (const std::uint32_t* face = begin; face != end; ++face) {
      if (!found[*face] && is_selected(*face) == selected) {
        found[*face] = true;
        ring.push_back(*face);
      }
    }
  };
  std::vector<bool> seen(shared_offsets_.size(), false);  // rows
  selection.visit([&](std::uint32_t face) {
    if (face % STRETCH == 0) {
      throwIfCanceled(cancel);
    }
    for (unsigned corner = 0; corner < 3 && face < faceCount(); ++corner) {
      const std::uint32_t neighbor = sides_[3 * std::size_t{face} + corner];
      const std::size_t row = neighbor & ~SHARED;
      if (neighbor == NONE) {
        continue;
      }
      if ((neighbor & SHARED) == 0) {
        const std::uint32_t both[] = {face, neighbor};
        look(both, both + 2);
      } else if (!seen[row]) {
        seen[row] = true;
        look(&shared_[shared_offsets_[row]], &shared_[shared_offsets_[row + 1] - 1] + 1);
      }
    }
  });
  std::sort(ring.begin(), ring.end());
  return ring;
}

FaceNeighbors::Faces FaceNeighbors::grow(const FaceBits& selection,
                                         const std::atomic<bool>* cancel) const
{
  return border(selection, false, cancel);
}

FaceNeighbors::Faces FaceNeighbors::shrink(const FaceBits& selection,
                                           const std::atomic<bool>* cancel) const
{
  return border(selection, true, cancel);
}

FaceNeighbors::Faces FaceNeighbors::flood(const MeshData& mesh, std::uint32_t start,
                                          double max_angle, const SelectableFaces* selectable,
                                          const FaceBits* open,
                                          const std::atomic<bool>* cancel) const
{
  Faces region;
  if (start >= faceCount() || mesh.faceCount() != faceCount()) {
    return region;
  }
  std::vector<bool> found(faceCount(), false);
  found[start] = true;
  region.push_back(start);
  for (std::size_t next = 0; next < region.size(); ++next) {
    if (next % STRETCH == 0) {
      throwIfCanceled(cancel);
    }
    const std::uint32_t face = region[next];
    const Eigen::Vector3d normal = normalOf(mesh, face);
    if (normal.squaredNorm() <= 0.0) {
      continue;
    }
    visit(face, [&](std::uint32_t neighbor) {
      if (found[neighbor] || (selectable && !selectable->contains(neighbor)) ||
          (open && !open->contains(neighbor))) {
        return;
      }
      const Eigen::Vector3d other = normalOf(mesh, neighbor);
      // (It has no area, or the angle is small enough.)
      if (other.squaredNorm() <= 0.0 || angleBetween(normal, other) <= max_angle) {
        found[neighbor] = true;
        region.push_back(neighbor);
      }
    });
  }
  std::sort(region.begin(), region.end());
  return region;
}

}  // namespace rviz_mesh_plugin
