#include "edges.h"

#include <mesh_map/parallel.h>

#include <algorithm>
#include <utility>

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
  // Filling moves each row's end; offset i + 2 is counted, so that offset i + 1 ends up as the end
  // of row i.
  rows.offsets.assign(vertex_count + 2, 0);
  std::uint32_t* const ends = rows.offsets.data() + 1;
  for (std::size_t i = 0; i < faces.size(); i += 3) {
    const std::uint32_t a = faces[i], b = faces[i + 1], c = faces[i + 2];
    ends[std::min(a, b) + 1] += a != b;
    ends[std::min(b, c) + 1] += b != c;
    ends[std::min(c, a) + 1] += c != a;
  }
  for (std::size_t v = 1; v <= vertex_count; ++v) {
    ends[v] += ends[v - 1];
  }
  rows.sides.resize(ends[vertex_count]);
  const auto put = [&](std::uint32_t a, std::uint32_t b, std::size_t slot) {
    if (a != b) {
      rows.sides[ends[std::min(a, b)]++] = {std::max(a, b), static_cast<std::uint32_t>(slot)};
    }
  };
  for (std::size_t i = 0; i < faces.size(); i += 3) {
    const std::uint32_t a = faces[i], b = faces[i + 1], c = faces[i + 2];
    put(a, b, i);
    put(b, c, i + 1);
    put(c, a, i + 2);
  }
  rows.offsets.pop_back();
  return rows;
}

void sortSides(Side* begin, Side* end)
{
  if (end - begin > 32) {
    std::sort(begin, end);
    return;
  }
  for (Side* i = begin; i != end; ++i) {
    const Side side = *i;
    Side* j = i;
    for (; j != begin && side < *(j - 1); --j) {
      *j = *(j - 1);
    }
    *j = side;
  }
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
    if (thirds_.size() < 2) {
      return;
    }
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

}  // namespace

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
        sortSides(first, last);
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

}  // namespace mesh_map
