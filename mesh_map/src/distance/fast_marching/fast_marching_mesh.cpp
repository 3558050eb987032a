#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <mesh_map/base/parallel.h>

#include <cmath>
#include <utility>

#include "base/require.h"
#include "base/rows.h"
#include "mesh/packed_position.h"

namespace mesh_map {
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
  parallelEach(vertexCount(), 4096, threads, [this](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    if (isClosed(v) && exceedsFullTurn(v)) {
      kinds_[v] |= SADDLE;
    }
  });
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

std::uint32_t FastMarchingMesh::acrossAnywhere(std::uint32_t a, std::uint32_t b,
                                               std::uint32_t from) const
{
  if (corners(b).size() < corners(a).size()) {
    std::swap(a, b);
  }
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

/// Turns one side after the other, without a trigonometric function.
bool FastMarchingMesh::exceedsFullTurn(std::uint32_t v) const
{
  double x = 1.0, y = 0.0;
  bool is_past_half = false;
  for (const FastMarchingCorner& corner : corners(v)) {
    if (is_past_half && y > BEND * std::abs(x)) {
      return true;
    }
    const Vector3 a = between(positions_[v], positions_[corner.a]),
                  b = between(positions_[v], positions_[corner.b]);
    const double cosine = dot(a, b), sine = norm(cross(a, b));
    const double next_x = x * cosine - y * sine, next_y = y * cosine + x * sine;
    const double size = std::abs(next_x) + std::abs(next_y);
    if (!(size > 0.0)) {
      continue;
    }
    is_past_half = is_past_half || (y >= 0.0 && next_y < 0.0);
    x = next_x / size;
    y = next_y / size;
  }
  return is_past_half && (y > BEND * std::abs(x));
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
