#include "reconstruction/marching_cubes.h"

#include <cstddef>

namespace mesh_map {
namespace {

using Polygon = std::vector<std::uint8_t>;

constexpr std::uint8_t NO_EDGE = 255;

/// The edge between two corners that differ in one bit.
std::uint8_t edgeBetween(int a, int b)
{
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  const int one = axis == 0 ? 1 : 0, other = axis == 2 ? 1 : 2;
  const int start = a & b;
  return static_cast<std::uint8_t>(4 * axis + ((start >> one) & 1) + 2 * ((start >> other) & 1));
}

/// Whether two edges are of one side of the cube.
bool onOneSide(std::uint8_t a, std::uint8_t b)
{
  const auto sides = [](std::uint8_t edge) {
    const int start = edgeStart(edge), end = start | (1 << (edge / 4));
    // A side for each axis and place: those at which both ends are.
    return (start & end) | ((~start & ~end & 7) << 3);
  };
  return (sides(a) & sides(b)) != 0;
}

/// The corners of a side in order, counter-clockwise seen from outside.
std::array<int, 4> cornersOfSide(int axis, int place)
{
  const int u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3), base = place << axis;
  if (place == 1) {
    return {base, base | u, base | u | v, base | v};
  }
  return {base, base | v, base | u | v, base | u};
}

/// The polygons in which a surface cuts the cube.
std::vector<Polygon> polygonsOf(int inside)
{
  // On each side a surface runs from where its circumference comes in to where it goes out again.
  std::array<std::uint8_t, 12> next;
  next.fill(NO_EDGE);
  for (int side = 0; side < 6; ++side) {
    const std::array<int, 4> corners = cornersOfSide(side / 2, side % 2);
    for (std::size_t i = 0; i < 4; ++i) {
      const int before = corners[i], corner = corners[(i + 1) % 4];
      if (((inside >> before) & 1) != 0 || ((inside >> corner) & 1) == 0) {
        continue;
      }
      std::size_t j = i + 1;
      while (((inside >> corners[(j + 1) % 4]) & 1) != 0) {
        ++j;
      }
      next[edgeBetween(before, corner)] = edgeBetween(corners[j % 4], corners[(j + 1) % 4]);
    }
  }
  std::vector<Polygon> polygons;
  for (std::uint8_t edge = 0; edge < 12; ++edge) {
    Polygon polygon;
    for (std::uint8_t at = edge; next[at] != NO_EDGE;) {
      polygon.push_back(at);
      const std::uint8_t after = next[at];
      next[at] = NO_EDGE;
      at = after;
    }
    if (!polygon.empty()) {
      polygons.push_back(polygon);
    }
  }
  return polygons;
}

/// Cuts corners [first, last] of a polygon off along the edge between both; false where it cannot
/// be done without an edge in a side of the cube. Adds triangles.
bool triangulate(const Polygon& polygon, std::size_t first, std::size_t last, Polygon& triangles)
{
  if (last - first < 2) {
    return true;
  }
  const auto allowed = [&](std::size_t a, std::size_t b) {
    const bool is_side = b - a == 1 || b - a == polygon.size() - 1;
    return is_side || !onOneSide(polygon[a], polygon[b]);
  };
  for (std::size_t middle = first + 1; middle < last; ++middle) {
    const std::size_t before = triangles.size();
    if (allowed(first, middle) && allowed(middle, last) &&
        triangulate(polygon, first, middle, triangles) &&
        triangulate(polygon, middle, last, triangles)) {
      triangles.insert(triangles.end(), {polygon[first], polygon[middle], polygon[last]});
      return true;
    }
    triangles.resize(before);
  }
  return false;
}

std::array<Polygon, 256> allTriangles()
{
  std::array<Polygon, 256> table;
  for (int inside = 0; inside < 256; ++inside) {
    for (const Polygon& polygon : polygonsOf(inside)) {
      // There is a way for each of the 256.
      triangulate(polygon, 0, polygon.size() - 1, table[inside]);
    }
  }
  return table;
}

}  // namespace

const std::vector<std::uint8_t>& cubeTriangles(std::uint8_t inside)
{
  static const std::array<Polygon, 256> table = allTriangles();
  return table[inside];
}

}  // namespace mesh_map
