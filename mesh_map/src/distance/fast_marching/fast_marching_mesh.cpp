#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <mesh_map/base/parallel.h>

#include <cmath>
#include <utility>

#include "base/require.h"
#include "base/rows.h"
#include "mesh/packed_position.h"

namespace mesh_map {
namespace {

/// Corners with a larger cosine do not count as obtuse. What their vertex can be nearer to anything
/// than the two others of its face, by this part of an edge, is not worth the effort: half of all
/// corners on a regular grid are about right.
constexpr double OBTUSE = -0.05;

}  // namespace

FastMarchingMesh::FastMarchingMesh(const MeshView& mesh, const RowsView& vertex_faces,
                                   unsigned threads)
    : positions_(mesh.positions.size() / 3),
      offsets_(vertex_faces.offsets.begin(), vertex_faces.offsets.end()),
      corners_(vertex_faces.values.size()),
      kinds_(positions_.size())
{
  require(vertex_faces.rowCount() == vertexCount(), "vertex_faces need one row per vertex");
  parallelEach(vertexCount(), 4096, threads, [&](std::size_t v) {
    const float* const p = mesh.positions.data() + 3 * v;
    positions_[v] = {p[0], p[1], p[2], 0.0f};
    fillCorners(mesh, vertex_faces, static_cast<std::uint32_t>(v));
  });
  findAcross(threads);
  // A sample will do: the mean only says how wide the buckets of a queue should be.
  const std::size_t step = mesh.faces.size() / 3 / 4096 + 1;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < mesh.faceCount(); f += step, ++count) {
    sum += norm(between(positions_[mesh.faces[3 * f]], positions_[mesh.faces[3 * f + 1]]));
  }
  if (sum > 0.0 && std::isfinite(sum)) {
    mean_edge_ = sum / static_cast<double>(count);
  }
}

void FastMarchingMesh::fillCorners(const MeshView& mesh, const RowsView& vertex_faces,
                                   std::uint32_t v)
{
  FastMarchingCorner* const begin = corners_.data() + offsets_[v];
  const std::size_t count = offsets_[v + 1] - offsets_[v];
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t* const face =
        mesh.faces.data() + 3 * std::size_t{vertex_faces.values[offsets_[v] + i]};
    const unsigned k = face[0] == v ? 0 : face[1] == v ? 1 : 2;
    require(face[k] == v, "vertex_faces names a face without the vertex");
    std::uint32_t a = face[(k + 1) % 3], b = face[(k + 2) % 3];
    if (a == v) {
      a = b;
    } else if (b == v) {
      b = a;
    }
    begin[i] = {a, b};
  }
  kinds_[v] = orderFan(begin, count, v);
}

std::uint32_t FastMarchingMesh::across(std::uint32_t a, std::uint32_t b, std::uint32_t from) const
{
  std::uint32_t found = NO_INDEX;
  unsigned count = 0;
  for (const FastMarchingCorner& corner : corners(a)) {
    if (corner.a != corner.b && (corner.a == b || corner.b == b)) {
      const std::uint32_t third = corner.a == b ? corner.b : corner.a;
      ++count;
      found = third != from ? third : found;
    }
  }
  return count == 2 ? found : NO_INDEX;
}

// What obtuse triangles need: the next face is unfolded beside them (Kimmel and Sethian, 1998).
void FastMarchingMesh::findAcross(unsigned threads)
{
  using Found = std::vector<std::pair<std::uint32_t, FastMarchingAcross>>;
  constexpr std::size_t CHUNK = 16384;
  const auto isObtuse = [this](std::uint32_t v, const FastMarchingCorner& corner) {
    const Vector3 p = between(positions_[v], positions_[corner.a]),
                  q = between(positions_[v], positions_[corner.b]);
    const double product = dot(p, q);
    return product < 0.0 && product * product > OBTUSE * OBTUSE * dot(p, p) * dot(q, q);
  };
  std::vector<Found> chunks((vertexCount() + CHUNK - 1) / CHUNK);
  parallelFor(vertexCount(), CHUNK, threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto v = static_cast<std::uint32_t>(i);
        for (const FastMarchingCorner& corner : corners(v)) {
          if (corner.a != corner.b && isObtuse(v, corner)) {
            const std::uint32_t from = across(corner.a, corner.b, v);
            if (from != NO_INDEX && isFan(from)) {
              chunks[begin / CHUNK].push_back({from, {v, corner.a, corner.b}});
            }
          }
        }
      }
    };
  });
  // Chunks in order, so that the rows are the same with any number of threads.
  across_offsets_ = fillRows(vertexCount(), across_, [&chunks](const auto& put) {
    for (const Found& chunk : chunks) {
      for (const auto& [vertex, across] : chunk) {
        put(vertex, across);
      }
    }
  });
}

std::uint8_t FastMarchingMesh::orderFan(FastMarchingCorner* begin, std::size_t count,
                                        std::uint32_t v)
{
  if (count == 0 || count > MAX_FAN) {
    return 0;
  }
  std::size_t start = 0;
  bool start_flipped = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (begin[i].a == begin[i].b || begin[i].a == v) {
      return 0;
    }
    std::size_t with_a = 0, with_b = 0;
    for (std::size_t j = 0; j < count; ++j) {
      with_a += begin[j].a == begin[i].a || begin[j].b == begin[i].a;
      with_b += begin[j].a == begin[i].b || begin[j].b == begin[i].b;
    }
    if (with_a > 2 || with_b > 2) {
      return 0;
    }
    if (with_a == 1 || with_b == 1) {  // the end of an open fan
      start = i;
      start_flipped = with_a != 1;
    }
  }
  std::swap(begin[0], begin[start]);
  if (start_flipped) {
    std::swap(begin[0].a, begin[0].b);
  }
  for (std::size_t i = 1; i < count; ++i) {
    const std::uint32_t end = begin[i - 1].b;
    std::size_t j = i;
    while (j < count && begin[j].a != end && begin[j].b != end) {
      ++j;
    }
    if (j == count) {
      return 0;  // another fan follows
    }
    std::swap(begin[i], begin[j]);
    if (begin[i].a != end) {
      std::swap(begin[i].a, begin[i].b);
    }
  }
  return begin[count - 1].b == begin[0].a ? FAN | CLOSED : FAN;
}

}  // namespace mesh_map
