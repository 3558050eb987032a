#include "geodesic_hills.h"

#include <cmath>
#include <utility>

namespace mesh_map {
namespace {

constexpr double ALL_ROUND = 2.0 * 3.14159265358979323846 - 1e-9;

/// The angle of a face at a vertex.
double cornerAngle(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex)
{
  const std::size_t k = slotOf(mesh, face, vertex);
  const Vector3 center = pointOf(mesh, vertex);
  const Vector3 a = pointOf(mesh, cornerOf(mesh, face, (k + 1) % 3)) - center;
  const Vector3 b = pointOf(mesh, cornerOf(mesh, face, (k + 2) % 3)) - center;
  const Vector3 normal = cross(a, b);
  return std::atan2(std::sqrt(dot(normal, normal)), dot(a, b));
}

/// The other edge of a face at a vertex.
std::uint32_t nextEdge(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex,
                       std::uint32_t edge)
{
  const std::size_t k = slotOf(mesh, face, vertex);
  const std::uint32_t* const edges = mesh.face_edges.data() + 3 * std::size_t{face};
  return edges[k] == edge ? edges[(k + 2) % 3] : edges[k];
}

/// The one other face at an edge; NO_INDEX: none, or several, or it must not be entered.
std::uint32_t faceBeyond(const FaceChoice& choice, std::uint32_t face, std::uint32_t edge)
{
  const RowsView& rows = choice.mesh.edge_faces;
  const std::uint32_t begin = rows.offsets[edge];
  if (rows.offsets[edge + 1] - begin != 2 || !canCross(choice.mesh, face, edge)) {
    return NO_INDEX;
  }
  const std::uint32_t other = rows.values[rows.values[begin] == face ? begin + 1 : begin];
  return choice.allows(other) ? other : NO_INDEX;
}

}  // namespace

bool HillSides::hasEnd(std::size_t edge, std::uint32_t vertex) const
{
  const auto ends = endsOf(choice_.mesh, strip_.faces[edge], strip_.edges[edge]);
  return ends[0] == vertex || ends[1] == vertex;
}

std::optional<Strip> HillSides::next()
{
  while (edge_ < strip_.edges.size()) {
    const std::size_t first = edge_;
    const std::uint32_t vertex =
        endsOf(choice_.mesh, strip_.faces[first], strip_.edges[first])[end_];
    edge_ += end_;
    end_ = 1 - end_;
    if (first > 0 && hasEnd(first - 1, vertex)) {
      continue;  // it has been passed
    }
    std::size_t last = first;
    while (last + 1 < strip_.edges.size() && hasEnd(last + 1, vertex)) {
      ++last;
    }
    std::optional<Strip> strip = around(vertex, first, last);
    if (strip) {
      return strip;
    }
  }
  return std::nullopt;
}

std::optional<Strip> HillSides::around(std::uint32_t vertex, std::size_t first,
                                       std::size_t last) const
{
  const WalkMesh& mesh = choice_.mesh;
  double angle = 0.0;
  for (std::size_t i = first; i <= last + 1; ++i) {
    angle += cornerAngle(mesh, strip_.faces[i], vertex);
  }
  const auto at = [](const std::vector<std::uint32_t>& values, std::size_t i) {
    return values.begin() + static_cast<std::ptrdiff_t>(i);
  };
  Strip strip{{strip_.faces.begin(), at(strip_.faces, first + 1)},
              {strip_.edges.begin(), at(strip_.edges, first)}};
  std::uint32_t face = strip_.faces[first];
  std::uint32_t edge = nextEdge(mesh, face, vertex, strip_.edges[first]);
  while (true) {
    face = faceBeyond(choice_, face, edge);
    if (face == NO_INDEX) {
      return std::nullopt;
    }
    strip.cross(edge, face);
    if (face == strip_.faces[last + 1]) {
      break;
    }
    angle += cornerAngle(mesh, face, vertex);
    if (angle >= ALL_ROUND) {
      return std::nullopt;
    }
    edge = nextEdge(mesh, face, vertex, edge);
  }
  if (angle >= ALL_ROUND) {
    return std::nullopt;
  }
  for (std::size_t i = last + 1; i < strip_.edges.size(); ++i) {
    strip.cross(strip_.edges[i], strip_.faces[i + 1]);
  }
  return strip;
}

}  // namespace mesh_map
