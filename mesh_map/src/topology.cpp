#include <mesh_map/parallel.h>
#include <mesh_map/topology.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "edges.h"

namespace mesh_map {
namespace {

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
  if (vertex_count > std::size_t{std::numeric_limits<std::int32_t>::max()} ||
      faces.size() > std::numeric_limits<std::uint32_t>::max() / 2) {
    throw std::invalid_argument("the mesh is too large: at most 2^31 - 1 vertices and 7e8 faces");
  }
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
  const std::size_t vertex_count = topology.vertex_count;
  std::vector<std::uint32_t>& offsets = topology.neighbor_offsets;
  offsets.assign(vertex_count + 2, 0);
  std::uint32_t* const ends = offsets.data() + 1;
  for (const std::uint32_t vertex : topology.edges) {
    ++ends[vertex + 1];
  }
  for (std::size_t v = 1; v <= vertex_count; ++v) {
    ends[v] += ends[v - 1];
  }
  topology.neighbors.resize(topology.edges.size());
  topology.neighbor_edges.resize(topology.edges.size());
  for (std::uint32_t e = 0; e < topology.edgeCount(); ++e) {
    const std::uint32_t a = topology.edges[2 * std::size_t{e}];
    const std::uint32_t b = topology.edges[2 * std::size_t{e} + 1];
    const std::uint32_t at_a = ends[a]++, at_b = ends[b]++;
    topology.neighbors[at_a] = b;
    topology.neighbor_edges[at_a] = e;
    topology.neighbors[at_b] = a;
    topology.neighbor_edges[at_b] = e;
  }
  offsets.pop_back();
}

void buildVertexFaces(ArrayView<std::uint32_t> faces, Topology& topology)
{
  const std::size_t vertex_count = topology.vertex_count;
  std::vector<std::uint32_t>& offsets = topology.vertex_face_offsets;
  offsets.assign(vertex_count + 2, 0);
  std::uint32_t* const ends = offsets.data() + 1;
  for (std::size_t i = 0; i < faces.size(); i += 3) {
    const std::uint32_t a = faces[i], b = faces[i + 1], c = faces[i + 2];
    ++ends[a + 1];
    ends[b + 1] += b != a;
    ends[c + 1] += c != a && c != b;
  }
  for (std::size_t v = 1; v <= vertex_count; ++v) {
    ends[v] += ends[v - 1];
  }
  topology.vertex_faces.resize(ends[vertex_count]);
  for (std::size_t i = 0; i < faces.size(); i += 3) {
    const std::uint32_t a = faces[i], b = faces[i + 1], c = faces[i + 2];
    const std::uint32_t face = static_cast<std::uint32_t>(i / 3);
    topology.vertex_faces[ends[a]++] = face;
    if (b != a) {
      topology.vertex_faces[ends[b]++] = face;
    }
    if (c != a && c != b) {
      topology.vertex_faces[ends[c]++] = face;
    }
  }
  offsets.pop_back();
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
  if (faces.size() % 3 != 0) {
    throw std::invalid_argument("the list of faces is no multiple of three vertex indices");
  }
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

}  // namespace mesh_map
