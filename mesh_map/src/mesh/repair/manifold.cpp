#include "mesh/repair/manifold.h"

#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/vector3.h"

namespace mesh_map {
namespace {

using Corners = std::array<std::uint32_t, 3>;
using Sides = std::vector<std::uint32_t>;  // 3 * face + k

class CornerSets
{
 public:
  explicit CornerSets(std::size_t count) : parents_(count)
  {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }

  std::uint32_t find(std::uint32_t corner)
  {
    while (parents_[corner] != corner) {
      parents_[corner] = parents_[parents_[corner]];
      corner = parents_[corner];
    }
    return corner;
  }

  void unite(std::uint32_t one, std::uint32_t other)
  {
    one = find(one);
    other = find(other);
    parents_[std::max(one, other)] = std::min(one, other);
  }

 private:
  std::vector<std::uint32_t> parents_;
};

std::uint32_t nextCorner(std::uint32_t corner)
{
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

class ManifoldMaker
{
 public:
  explicit ManifoldMaker(const MeshView& mesh) : mesh_(mesh) {}

  ManifoldMesh make()
  {
    keepFaces();
    const Topology topology = buildTopology(kept_, mesh_.vertexCount());
    const EdgeFaces edge_faces = edgeFaces(topology.face_edges, topology.edgeCount());
    CornerSets corners(kept_.size());
    std::vector<std::vector<Sides>> groups;  // of each edge with more than two faces
    for (std::size_t edge = 0; edge < topology.edgeCount(); ++edge) {
      const Sides sides = sidesOf(edge, topology, edge_faces);
      if (sides.size() == 2) {
        uniteAt(sides[0], sides[1], corners);
      } else if (sides.size() > 2) {
        groups.push_back(paired(sides));
        for (const Sides& group : groups.back()) {
          if (group.size() == 2) {
            uniteAt(group[0], group[1], corners);
          }
        }
      }
    }
    copyVertices(corners);
    for (const std::vector<Sides>& of_edge : groups) {
      splitEdges(of_edge);
    }
    writeFaces();
    return std::move(result_);
  }

 private:
  void keepFaces()
  {
    const Topology all = buildTopology(mesh_.faces, mesh_.vertexCount());
    for (std::uint32_t face = 0; face < mesh_.faceCount(); ++face) {
      const std::uint8_t flags = all.face_flags[face];
      if ((flags & FACE_DEGENERATE) != 0) {
        ++result_.degenerate_faces;
      } else if ((flags & FACE_DUPLICATE) != 0) {
        ++result_.duplicate_faces;
      } else {
        kept_.insert(kept_.end(), mesh_.faces.data() + 3 * std::size_t{face},
                     mesh_.faces.data() + 3 * std::size_t{face} + 3);
        parents_.push_back(face);
      }
    }
  }

  Sides sidesOf(std::size_t edge, const Topology& topology, const EdgeFaces& edge_faces) const
  {
    Sides sides;
    for (std::uint32_t i = edge_faces.offsets[edge]; i < edge_faces.offsets[edge + 1]; ++i) {
      const std::uint32_t face = edge_faces.faces[i];
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (topology.face_edges[3 * std::size_t{face} + k] == edge) {
          sides.push_back(3 * face + k);
        }
      }
    }
    return sides;
  }

  bool runsUp(std::uint32_t side) const { return kept_[side] < kept_[nextCorner(side)]; }

  void uniteAt(std::uint32_t one, std::uint32_t other, CornerSets& corners) const
  {
    const bool same = kept_[one] == kept_[other];
    corners.unite(one, same ? other : nextCorner(other));
    corners.unite(nextCorner(one), same ? nextCorner(other) : other);
  }

  /// Pairs of sides that go on in each other, the straightest first, and those that are left.
  std::vector<Sides> paired(const Sides& sides) const
  {
    std::vector<Vector3> away;  // in the plane of each face, at right angles to the edge
    for (const std::uint32_t side : sides) {
      const std::uint32_t a = std::min(kept_[side], kept_[nextCorner(side)]);
      const std::uint32_t b = std::max(kept_[side], kept_[nextCorner(side)]);
      const Vector3 along = difference(mesh_.vertex(b), mesh_.vertex(a));
      const Vector3 to =
          difference(mesh_.vertex(kept_[nextCorner(nextCorner(side))]), mesh_.vertex(a));
      const double length = dot(along, along);
      away.push_back(length > 0.0 ? to - dot(to, along) / length * along : to);
    }
    std::vector<std::tuple<bool, double, std::size_t, std::size_t>> choices;
    for (std::size_t i = 0; i < sides.size(); ++i) {
      for (std::size_t j = i + 1; j < sides.size(); ++j) {
        const bool turned_otherwise = runsUp(sides[i]) == runsUp(sides[j]);
        choices.emplace_back(turned_otherwise, PI - angleBetween(away[i], away[j]), i, j);
      }
    }
    std::sort(choices.begin(), choices.end());
    std::vector<Sides> groups;
    std::vector<bool> taken(sides.size(), false);
    for (const auto& [turned_otherwise, bend, i, j] : choices) {
      // Faces that are turned otherwise do not belong to one surface: they would have to be turned.
      if (!taken[i] && !taken[j] && !turned_otherwise) {
        taken[i] = taken[j] = true;
        groups.push_back({sides[i], sides[j]});
      }
    }
    for (std::size_t i = 0; i < sides.size(); ++i) {
      if (!taken[i]) {
        groups.push_back({sides[i]});
      }
    }
    return groups;
  }

  /// Gives each fan its vertex: the one with the lowest corner keeps the number.
  void copyVertices(CornerSets& corners)
  {
    std::vector<std::uint32_t>& parents = result_.vertex_parents;
    for (std::uint32_t v = 0; v < mesh_.vertexCount(); ++v) {
      parents.insert(parents.end(), 2, v);
    }
    std::vector<std::uint8_t> used(mesh_.vertexCount(), 0);
    corners_.resize(kept_.size());
    for (std::uint32_t corner = 0; corner < kept_.size(); ++corner) {
      const std::uint32_t root = corners.find(corner), vertex = kept_[corner];
      if (root != corner) {
        corners_[corner] = corners_[root];
      } else if (used[vertex] == 0) {
        used[vertex] = 1;
        corners_[corner] = vertex;
      } else {
        corners_[corner] = newVertex(vertex, vertex);
        ++result_.split_vertices;
      }
    }
  }

  std::uint32_t newVertex(std::uint32_t one, std::uint32_t other)
  {
    result_.vertex_parents.push_back(one);
    result_.vertex_parents.push_back(other);
    return static_cast<std::uint32_t>(result_.vertex_parents.size() / 2 - 1);
  }

  /// Puts a vertex on the edge of each group but the first of those that have the same copies.
  void splitEdges(const std::vector<Sides>& groups)
  {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> seen;
    for (const Sides& group : groups) {
      const std::uint32_t a = corners_[group[0]], b = corners_[nextCorner(group[0])];
      const auto ends = std::minmax(a, b);
      const std::pair<std::uint32_t, std::uint32_t> key(ends.first, ends.second);
      if (std::find(seen.begin(), seen.end(), key) == seen.end()) {
        seen.push_back(key);
        continue;
      }
      const std::uint32_t middle = newVertex(kept_[group[0]], kept_[nextCorner(group[0])]);
      ++result_.split_edges;
      for (const std::uint32_t side : group) {
        middles_[side] = middle;
      }
    }
  }

  void writeFaces()
  {
    for (std::uint32_t face = 0; face < parents_.size(); ++face) {
      const std::uint32_t* const c = corners_.data() + 3 * std::size_t{face};
      std::array<std::uint32_t, 3> m = {NO_INDEX, NO_INDEX, NO_INDEX};
      for (std::uint32_t k = 0; k < 3 && !middles_.empty(); ++k) {
        const auto found = middles_.find(3 * face + k);
        m[k] = found == middles_.end() ? NO_INDEX : found->second;
      }
      // Cut from a split side to the corner that is opposite, and again what is left.
      write(face, {c[0], c[1], c[2]}, m);
    }
  }

  void write(std::uint32_t face, const Corners& c, const std::array<std::uint32_t, 3>& m)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      if (m[k] == NO_INDEX) {
        continue;
      }
      const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
      write(face, {c[k], m[k], c[n]}, {NO_INDEX, NO_INDEX, m[n]});
      write(face, {m[k], c[l], c[n]}, {NO_INDEX, m[l], NO_INDEX});
      return;
    }
    result_.faces.insert(result_.faces.end(), c.begin(), c.end());
    result_.face_parents.push_back(parents_[face]);
  }

  MeshView mesh_;
  ManifoldMesh result_;
  std::vector<std::uint32_t> kept_, parents_;  // faces, and their numbers in the mesh
  std::vector<std::uint32_t> corners_;         // their vertices in the result
  std::unordered_map<std::uint32_t, std::uint32_t> middles_;  // side -> vertex
};

}  // namespace

ManifoldMesh makeManifold(const MeshView& mesh)
{
  return ManifoldMaker(mesh).make();
}

}  // namespace mesh_map
