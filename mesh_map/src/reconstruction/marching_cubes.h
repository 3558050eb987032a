#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// The triangles of a cube, by which of its corners are inside (bit c for corner c, whose bits are
/// its x, y and z): marching cubes (W. Lorensen and H. Cline, 1987), with two properties.
///
/// On a side of a cube where two opposite corners are inside, these are parted, whatever the cube
/// is: neighbors fit. And no edge within a cube lies in one of its sides, where the neighbor could
/// have the same: so no edge of the mesh has more than two triangles.
///
/// Three edges of the cube for each triangle, counter-clockwise seen from outside. Edge
/// 4 a + b + 2 c goes along axis a; b and c are its places on the other two axes in their order.
const std::vector<std::uint8_t>& cubeTriangles(std::uint8_t inside);

/// The corner with less of its coordinate where an edge begins: bits x, y, z.
constexpr std::uint8_t edgeStart(std::uint8_t edge)
{
  const int axis = edge / 4, first = edge & 1, second = (edge >> 1) & 1;
  const int one = axis == 0 ? 1 : 0, other = axis == 2 ? 1 : 2;
  return static_cast<std::uint8_t>((first << one) | (second << other));
}

}  // namespace mesh_map
