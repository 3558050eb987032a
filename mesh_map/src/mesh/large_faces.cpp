#include "mesh/large_faces.h"

#include <mesh_map/base/parallel.h>

#include <array>
#include <cmath>

namespace mesh_map {

namespace {

constexpr std::size_t FACES_PER_CHUNK = 32768;

/// A triangle as seen from a center, and the heights of its corners.
struct Triangle
{
  std::array<Vector3, 3> corners;
  std::array<float, 3> heights;
};

void addBetween(float low, float high, double part, HeightRange& range)
{
  range.add(static_cast<float>(low + part * (double{high} - low)));
}

/// Where a side meets the sphere around the center.
void addCrossings(const Triangle& triangle, std::size_t from, std::size_t to, double radius,
                  HeightRange& range)
{
  const Vector3 start = triangle.corners[from], way = triangle.corners[to] - start;
  const double a = dot(way, way), b = dot(start, way), c = dot(start, start) - radius * radius;
  const double discriminant = b * b - a * c;
  if (!(a > 0.0 && discriminant > 0.0)) {
    return;
  }
  const double root = std::sqrt(discriminant);
  for (const double part : {(-b - root) / a, (-b + root) / a}) {
    if (part > 0.0 && part < 1.0) {
      addBetween(triangle.heights[from], triangle.heights[to], part, range);
    }
  }
}

/// The highest and the lowest point of the disk that the sphere cuts out of the triangle's plane,
/// if they are in the triangle.
void addSummits(const Triangle& triangle, double radius, const Vector3& up, HeightRange& range)
{
  const std::array<Vector3, 3>& p = triangle.corners;
  const Vector3 normal = cross(p[1] - p[0], p[2] - p[0]);
  const double squared = dot(normal, normal), gap = dot(p[0], normal);
  const double left = radius * radius - gap * gap / squared;
  const Vector3 ascent = up - (dot(up, normal) / squared) * normal;
  const double slope = norm(ascent);
  if (!(squared > 0.0 && left > 0.0 && slope > 0.0)) {
    return;
  }
  const std::array<float, 3>& h = triangle.heights;
  const auto [lowest, highest] = std::minmax({h[0], h[1], h[2]});
  const Vector3 foot = (gap / squared) * normal;
  for (const double reach : {-std::sqrt(left), std::sqrt(left)}) {
    const Vector3 point = foot + (reach / slope) * ascent;
    std::array<double, 3> weights;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 &next = p[(k + 1) % 3], &last = p[(k + 2) % 3];
      weights[k] = dot(cross(next - point, last - point), normal) / squared;
    }
    if (weights[0] >= 0.0 && weights[1] >= 0.0 && weights[2] >= 0.0) {
      const double height = weights[0] * h[0] + weights[1] * h[1] + weights[2] * h[2];
      range.add(std::min(std::max(static_cast<float>(height), lowest), highest));
    }
  }
}

}  // namespace

LargeFaces::LargeFaces(const MeshView& mesh, const RowsView& vertex_faces, double radius,
                       const Vector3& up, unsigned threads)
    : mesh_(mesh), vertex_faces_(vertex_faces), radius_(radius), up_(up), large_(mesh.faceCount())
{
  parallelEach(mesh.faceCount(), FACES_PER_CHUNK, threads, [this](std::size_t face) {
    const Vector3 a = pointOf(mesh_.corner(face, 0)), b = pointOf(mesh_.corner(face, 1)),
                  c = pointOf(mesh_.corner(face, 2));
    const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
    large_[face] = longest > radius_ * radius_;
  });
  if (std::find(large_.begin(), large_.end(), 1) == large_.end()) {
    return;
  }
  touched_.resize(mesh.vertexCount());
  for (std::size_t face = 0; face < large_.size(); ++face) {
    for (std::size_t k = 0; large_[face] != 0 && k < 3; ++k) {
      touched_[mesh.faces[3 * face + k]] = 1;
    }
  }
}

void LargeFaces::addHeights(std::size_t center, std::size_t at, HeightRange& range) const
{
  const Vector3 position = pointOf(mesh_.vertex(center));
  range.add(static_cast<float>(dot(pointOf(mesh_.vertex(at)), up_)));
  for (std::uint32_t k = vertex_faces_.offsets[at]; k < vertex_faces_.offsets[at + 1]; ++k) {
    if (large_[vertex_faces_.values[k]] != 0) {
      addHeightsOf(vertex_faces_.values[k], position, range);
    }
  }
}

void LargeFaces::addHeightsOf(std::size_t face, const Vector3& center, HeightRange& range) const
{
  Triangle triangle;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 corner = pointOf(mesh_.corner(face, k));
    triangle.corners[k] = corner - center;
    triangle.heights[k] = static_cast<float>(dot(corner, up_));
  }
  const auto [lowest, highest] =
      std::minmax_element(triangle.heights.begin(), triangle.heights.end());
  if (range.holds(*lowest, *highest)) {
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    addCrossings(triangle, k, (k + 1) % 3, radius_, range);
  }
  addSummits(triangle, radius_, up_, range);
}

}  // namespace mesh_map
