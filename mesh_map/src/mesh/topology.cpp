#include <mesh_map/mesh/topology.h>

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/require.h"
#include "base/rows.h"
#include "base/vector3.h"

namespace mesh_map {

namespace {

/// One side of a face: the upper vertex of its edge, and where the side is in the list of faces (3
/// * face + corner).
struct Side
{
  std::uint32_t upper;
  std::uint32_t slot;

  bool operator<(const Side& other) const
  {
    return upper != other.upper ? upper < other.upper : slot < other.slot;
  }
};

/// Sides in rows by the lower vertex of their edge.
struct SideRows
{
  std::vector<std::uint32_t> offsets;
  std::vector<Side> sides;
};

std::uint32_t nextSlot(std::uint32_t slot)
{
  return slot % 3 == 2 ? slot - 2 : slot + 1;
}

SideRows gatherSides(ArrayView<std::uint32_t> faces, std::size_t vertex_count)
{
  SideRows rows;
  rows.offsets = fillRows(vertex_count, rows.sides, [faces](const auto& put) {
    const auto putSide = [&put](std::uint32_t a, std::uint32_t b, std::size_t slot) {
      if (a != b) {
        put(std::min(a, b), Side{std::max(a, b), static_cast<std::uint32_t>(slot)});
      }
    };
    for (std::size_t i = 0; i < faces.size(); i += 3) {
      putSide(faces[i], faces[i + 1], i);
      putSide(faces[i + 1], faces[i + 2], i + 1);
      putSide(faces[i + 2], faces[i], i + 2);
    }
  });
  return rows;
}

class EdgeWriter
{
 public:
  EdgeWriter(ArrayView<std::uint32_t> faces, Topology& topology)
      : faces_(faces), topology_(topology)
  {
  }

  /// The sides [begin, end) lie on the edge (lower, begin->upper), which gets the index `edge`.
  void write(std::uint32_t lower, std::uint32_t edge, const Side* begin, const Side* end)
  {
    const std::uint32_t upper = begin->upper;
    topology_.edges[2 * std::size_t{edge}] = lower;
    topology_.edges[2 * std::size_t{edge} + 1] = upper;
    thirds_.clear();
    std::uint32_t count = 0, forward = 0;
    for (const Side* side = begin; side != end; ++side) {
      topology_.face_edges[side->slot] = edge;
      const std::uint32_t third = faces_[nextSlot(nextSlot(side->slot))];
      if (third == lower || third == upper) {
        continue;  // a degenerate face
      }
      ++count;
      forward += faces_[side->slot] == lower;
      if (third > upper) {
        thirds_.emplace_back(third, side->slot / 3);
      }
    }
    topology_.edge_face_counts[edge] = count;
    topology_.edge_flags[edge] = count == 1                                     ? EDGE_BORDER
                                 : count > 2                                    ? EDGE_NON_MANIFOLD
                                 : count == 2 && (forward == 0 || forward == 2) ? EDGE_INCONSISTENT
                                                                                : 0;
    markDuplicates();
  }

 private:
  /// Faces with the same vertices meet on the edge of their two lowest ones, with the same third.
  void markDuplicates()
  {
    std::sort(thirds_.begin(), thirds_.end());
    for (std::size_t i = 1; i < thirds_.size(); ++i) {
      if (thirds_[i].first == thirds_[i - 1].first) {
        topology_.face_flags[thirds_[i].second] |= FACE_DUPLICATE;
      }
    }
  }

  ArrayView<std::uint32_t> faces_;
  Topology& topology_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> thirds_;  // (third vertex, face)
};

constexpr std::size_t VERTICES_PER_CHUNK = 16384;

void buildEdges(ArrayView<std::uint32_t> faces, unsigned threads, Topology& topology)
{
  const std::size_t vertex_count = topology.vertex_count;
  topology.face_flags.assign(topology.face_count, 0);
  for (std::size_t f = 0; f < topology.face_count; ++f) {
    const std::uint32_t* face = faces.data() + 3 * f;
    const bool degenerate = face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
    topology.face_flags[f] = degenerate ? FACE_DEGENERATE : 0;
  }

  SideRows rows = gatherSides(faces, vertex_count);

  // Sort each row and count its edges; then give every row its first edge index, and write.
  const std::size_t chunks = (vertex_count + VERTICES_PER_CHUNK - 1) / VERTICES_PER_CHUNK;
  std::vector<std::uint32_t> first_edges(chunks + 1, 0);
  parallelFor(vertex_count, VERTICES_PER_CHUNK, threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      std::uint32_t edges = 0;
      for (std::size_t v = begin; v < end; ++v) {
        Side* const first = rows.sides.data() + rows.offsets[v];
        Side* const last = rows.sides.data() + rows.offsets[v + 1];
        std::sort(first, last);
        for (const Side* side = first; side != last; ++side) {
          edges += side == first || side->upper != (side - 1)->upper;
        }
      }
      first_edges[begin / VERTICES_PER_CHUNK + 1] = edges;
    };
  });
  for (std::size_t i = 0; i < chunks; ++i) {
    first_edges[i + 1] += first_edges[i];
  }

  const std::size_t edge_count = first_edges[chunks];
  topology.edges.resize(2 * edge_count);
  topology.edge_face_counts.resize(edge_count);
  topology.edge_flags.resize(edge_count);
  topology.face_edges.assign(faces.size(), NO_INDEX);
  parallelFor(vertex_count, VERTICES_PER_CHUNK, threads, [&]() -> RangeBody {
    EdgeWriter writer(faces, topology);
    return [&rows, &first_edges, writer](std::size_t begin, std::size_t end) mutable {
      std::uint32_t edge = first_edges[begin / VERTICES_PER_CHUNK];
      for (std::size_t v = begin; v < end; ++v) {
        const Side* side = rows.sides.data() + rows.offsets[v];
        const Side* const last = rows.sides.data() + rows.offsets[v + 1];
        while (side != last) {
          const Side* next = side + 1;
          while (next != last && next->upper == side->upper) {
            ++next;
          }
          writer.write(static_cast<std::uint32_t>(v), edge++, side, next);
          side = next;
        }
      }
    };
  });
}

/// Disjoint sets of indices; a set is known by its lowest member.
class DisjointSets
{
 public:
  explicit DisjointSets(std::size_t size) : parents_(size)
  {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }

  std::uint32_t find(std::uint32_t i)
  {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }

  void unite(std::uint32_t i, std::uint32_t j)
  {
    i = find(i);
    j = find(j);
    parents_[std::max(i, j)] = std::min(i, j);
  }

  bool isRoot(std::uint32_t i) const { return parents_[i] == i; }

 private:
  std::vector<std::uint32_t> parents_;
};

void checkFaces(ArrayView<std::uint32_t> faces, std::size_t vertex_count)
{
  require(vertex_count <= std::size_t{std::numeric_limits<std::int32_t>::max()} &&
              faces.size() <= std::numeric_limits<std::uint32_t>::max() / 2,
          "the mesh is too large: at most 2^31 - 1 vertices and 7e8 faces");
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i] >= vertex_count) {
      throw std::invalid_argument("face " + std::to_string(i / 3) + " refers to vertex " +
                                  std::to_string(faces[i]) + ", but there are only " +
                                  std::to_string(vertex_count) + " vertices");
    }
  }
}

/// Fills the rows that connect vertices with their neighbors. Edges are sorted, and so are the
/// rows.
void buildNeighbors(Topology& topology)
{
  const auto visit = [&edges = topology.edges](const auto& put) {
    for (std::uint32_t end = 0; end < edges.size(); ++end) {
      put(edges[end], end);
    }
  };
  std::vector<std::uint32_t>& ends = topology.neighbor_edges;  // at first
  topology.neighbor_offsets = fillRows(topology.vertex_count, ends, visit);
  topology.neighbors.resize(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    topology.neighbors[i] = topology.edges[ends[i] ^ 1];  // the other end of the edge
    ends[i] /= 2;
  }
}

void buildVertexFaces(ArrayView<std::uint32_t> faces, Topology& topology)
{
  const auto visit = [faces](const auto& put) {
    for (std::size_t i = 0; i < faces.size(); i += 3) {
      const std::uint32_t a = faces[i], b = faces[i + 1], c = faces[i + 2];
      const auto face = static_cast<std::uint32_t>(i / 3);
      put(a, face);
      if (b != a) {
        put(b, face);
      }
      if (c != a && c != b) {
        put(c, face);
      }
    }
  };
  topology.vertex_face_offsets = fillRows(topology.vertex_count, topology.vertex_faces, visit);
}

void buildComponents(Topology& topology)
{
  const std::size_t vertex_count = topology.vertex_count;
  DisjointSets sets(vertex_count);
  for (std::size_t e = 0; e < topology.edgeCount(); ++e) {
    sets.unite(topology.edges[2 * e], topology.edges[2 * e + 1]);
  }
  topology.components.resize(vertex_count);
  std::int32_t count = 0;
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    topology.components[v] = sets.isRoot(v) ? count++ : topology.components[sets.find(v)];
  }
  topology.component_count = static_cast<std::size_t>(count);
}

/// Each edge has two ends. At a vertex, the edge ends that its faces connect form one set for each
/// fan of faces.
void markVertices(ArrayView<std::uint32_t> faces, Topology& topology)
{
  const std::vector<std::uint32_t>& edges = topology.edges;
  std::vector<std::uint8_t>& flags = topology.vertex_flags;
  DisjointSets edge_ends(edges.size());
  const auto endAt = [&edges](std::uint32_t edge, std::uint32_t vertex) {
    return 2 * edge + (edges[2 * std::size_t{edge}] != vertex);
  };
  for (std::size_t f = 0; f < topology.face_count; ++f) {
    if (topology.face_flags[f] & FACE_DEGENERATE) {
      continue;
    }
    const std::uint32_t* const face = faces.data() + 3 * f;
    const std::uint32_t* const sides = topology.face_edges.data() + 3 * f;
    edge_ends.unite(endAt(sides[0], face[0]), endAt(sides[2], face[0]));
    edge_ends.unite(endAt(sides[1], face[1]), endAt(sides[0], face[1]));
    edge_ends.unite(endAt(sides[2], face[2]), endAt(sides[1], face[2]));
  }

  flags.assign(topology.vertex_count, VERTEX_ISOLATED);
  constexpr std::uint8_t SEEN_FAN = 128;
  for (std::uint32_t i = 0; i < edges.size(); ++i) {
    std::uint8_t& flag = flags[edges[i]];
    flag &= static_cast<std::uint8_t>(~VERTEX_ISOLATED);
    if (topology.edge_flags[i / 2] & EDGE_NON_MANIFOLD) {
      flag |= VERTEX_NON_MANIFOLD;
    }
    if (topology.edge_face_counts[i / 2] > 0 && edge_ends.isRoot(i)) {
      flag |= (flag & SEEN_FAN) != 0 ? std::uint8_t{VERTEX_NON_MANIFOLD} : SEEN_FAN;
    }
  }
  for (std::uint8_t& flag : flags) {
    flag &= static_cast<std::uint8_t>(~SEEN_FAN);
  }
}

}  // namespace

Topology buildTopology(ArrayView<std::uint32_t> faces, std::size_t vertex_count, unsigned threads)
{
  require(faces.size() % 3 == 0, "the list of faces is no multiple of three vertex indices");
  checkFaces(faces, vertex_count);
  Topology topology;
  topology.vertex_count = vertex_count;
  topology.face_count = faces.size() / 3;
  buildEdges(faces, threads, topology);
  parallelJobs({[&]() { markVertices(faces, topology); }, [&]() { buildNeighbors(topology); },
                [&]() { buildVertexFaces(faces, topology); }, [&]() { buildComponents(topology); }},
               threads);
  return topology;
}

std::vector<float> edgeLengths(ArrayView<float> positions, ArrayView<std::uint32_t> edges)
{
  constexpr std::size_t edges_per_chunk = 65536;
  std::vector<float> lengths(edges.size() / 2);
  parallelEach(lengths.size(), edges_per_chunk, 0,
               [positions, edges, out = lengths.data()](std::size_t e) {
                 const float* const a = positions.data() + 3 * std::size_t{edges[2 * e]};
                 const float* const b = positions.data() + 3 * std::size_t{edges[2 * e + 1]};
                 out[e] = static_cast<float>(norm(difference(a, b)));
               });
  return lengths;
}

EdgeFaces edgeFaces(ArrayView<std::uint32_t> face_edges, std::size_t edge_count)
{
  EdgeFaces rows;
  rows.offsets = fillRows(edge_count, rows.faces, [&](const auto& put) {
    for (std::size_t face = 0; face < face_edges.size() / 3; ++face) {
      // A face that names a vertex twice has a side that is no edge.
      const std::uint32_t* const sides = face_edges.data() + 3 * face;
      const bool degenerate = std::count(sides, sides + 3, NO_INDEX) > 0;
      for (std::size_t k = 0; k < 3 && !degenerate; ++k) {
        require(sides[k] < edge_count, "a face has an edge that does not exist");
        put(sides[k], static_cast<std::uint32_t>(face));
      }
    }
  });
  return rows;
}

}  // namespace mesh_map
