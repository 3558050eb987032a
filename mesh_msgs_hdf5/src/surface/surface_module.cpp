// Edges, fans and parts of a surface, and the shape of its faces, for mesh_msgs_hdf5.validation,
// which see.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "surface/disjoint_sets.h"

namespace py = pybind11;

namespace mesh_msgs_hdf5 {
namespace {
using Faces = py::array_t<std::uint32_t, py::array::c_style>;
using Vertices = py::array_t<float, py::array::c_style>;

/// Refuses what the loops below would read or write behind an array for.
void check(const Faces& faces, std::size_t vertex_count)
{
  if (faces.ndim() != 2 || faces.shape(1) != 3) {
    throw std::invalid_argument("faces must be (F, 3)");
  }
  constexpr std::size_t MOST = std::numeric_limits<std::uint32_t>::max();
  if (static_cast<std::size_t>(faces.size()) >= MOST || vertex_count >= MOST) {
    throw std::length_error("a mesh of more than 2^32 corners or vertices");
  }
  const std::uint32_t* const corners = faces.data();
  for (py::ssize_t i = 0; i < faces.size(); ++i) {
    if (corners[i] >= vertex_count) {
      throw std::out_of_range("a face refers to no vertex");
    }
  }
}

/// Numbers put into bins by counting: those of bin b are items[starts[b]] to items[starts[b + 1]],
/// ascending.
struct Bins
{
  std::vector<std::uint32_t> starts;
  std::vector<std::uint32_t> items;

  /// bin(i) of each number i below count; NONE: of no bin.
  static constexpr std::uint32_t NONE = std::numeric_limits<std::uint32_t>::max();
  template <typename Bin>
  Bins(std::size_t bins, std::size_t count, const Bin& bin) : starts(bins + 2)
  {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t b = bin(i);
      if (b != NONE) {
        ++starts[b + 2];
      }
    }
    for (std::size_t b = 2; b < starts.size(); ++b) {
      starts[b] += starts[b - 1];
    }
    items.resize(starts.back());
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t b = bin(i);
      if (b != NONE) {
        items[starts[b + 1]++] = static_cast<std::uint32_t>(i);
      }
    }
  }
};

bool isPlain(const std::uint32_t* face)
{
  return face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
}

/// (how many faces have the three vertices of an earlier one, the first of them).
std::pair<std::size_t, std::size_t> repeatedFaces(const Faces& faces, std::size_t vertex_count)
{
  check(faces, vertex_count);
  const std::uint32_t* const corners = faces.data();
  const auto face_count = static_cast<std::size_t>(faces.shape(0));
  const py::gil_scoped_release release;
  const Bins at_lowest(vertex_count, face_count, [corners](std::size_t i) {
    return std::min({corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]});
  });
  std::size_t count = 0, first = face_count;
  std::vector<std::array<std::uint32_t, 3>> here;  // the other two vertices, and the face
  for (std::size_t v = 0; v < vertex_count; ++v) {
    here.clear();
    for (std::size_t i = at_lowest.starts[v]; i < at_lowest.starts[v + 1]; ++i) {
      const std::uint32_t face = at_lowest.items[i];
      std::array<std::uint32_t, 3> sorted{corners[3 * face], corners[3 * face + 1],
                                          corners[3 * face + 2]};
      std::sort(sorted.begin(), sorted.end());
      here.push_back({sorted[1], sorted[2], face});
    }
    std::sort(here.begin(), here.end());
    for (std::size_t i = 1; i < here.size(); ++i) {
      if (here[i][0] == here[i - 1][0] && here[i][1] == here[i - 1][1]) {
        ++count;
        first = std::min<std::size_t>(first, here[i][2]);
      }
    }
  }
  return {count, first};
}

/// How many edges are so, and of the one whose first side comes first in the mesh: that side (3 *
/// face + number), and its vertices, the lower one first.
struct EdgesFound
{
  std::size_t count = 0;
  std::uint32_t side = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t low = 0;
  std::uint32_t high = 0;

  void add(std::uint32_t side_, std::uint32_t low_, std::uint32_t high_)
  {
    ++count;
    if (side_ <= side) {
      side = side_, low = low_, high = high_;
    }
  }
  std::tuple<std::size_t, std::size_t, std::size_t, std::size_t> asTuple() const
  {
    return {count, side / 3, low, high};
  }
};

/// What is said of the faces that name three different vertices, the only ones that are looked at.
struct Surface
{
  EdgesFound many, border, against;  // of more than two faces; of one; of two that run the same way
  std::size_t split_count = 0, first_split = 0;  // vertices at which faces form more than one fan
  std::size_t parts = 0, largest = 0,
              used = 0;  // parts without a common vertex; vertices in the largest, in all
};

/// One side of a face at an edge.
struct Side
{
  std::uint32_t high;    // the edge's other vertex
  std::uint32_t number;  // 3 * face + number

  bool operator<(const Side& other) const
  {
    return high != other.high ? high < other.high : number < other.number;
  }
};

std::uint32_t following(std::uint32_t side)
{
  return side % 3 == 2 ? side - 2 : side + 1;
}

/// The edges at each vertex that is their lower one; joins corners across inner edges, and
/// vertices.
void lookAtEdges(const std::uint32_t* corners, std::size_t face_count, std::size_t vertex_count,
                 Surface& surface, DisjointSets& fans, DisjointSets& parts)
{
  const Bins at_low(vertex_count, 3 * face_count, [corners](std::size_t side) {
    const auto tail = static_cast<std::uint32_t>(side);
    return isPlain(corners + side / 3 * 3) ? std::min(corners[tail], corners[following(tail)])
                                           : Bins::NONE;
  });
  std::vector<Side> sides;
  for (std::uint32_t low = 0; low < vertex_count; ++low) {
    sides.clear();
    for (std::size_t i = at_low.starts[low]; i < at_low.starts[low + 1]; ++i) {
      const std::uint32_t side = at_low.items[i];
      sides.push_back({std::max(corners[side], corners[following(side)]), side});
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t start = 0, end = 0; start < sides.size(); start = end) {
      const std::uint32_t high = sides[start].high, first = sides[start].number;
      for (end = start + 1; end < sides.size() && sides[end].high == high; ++end) {
        // the corners of two faces at either end of the edge are in one fan
        const std::uint32_t one = sides[end - 1].number, other = sides[end].number;
        const bool one_forward = corners[one] == low, other_forward = corners[other] == low;
        fans.join(one_forward ? one : following(one), other_forward ? other : following(other));
        fans.join(one_forward ? following(one) : one, other_forward ? following(other) : other);
      }
      parts.join(low, high);
      if (end - start == 1) {
        surface.border.add(first, low, high);
      } else if (end - start > 2) {
        surface.many.add(first, low, high);
      } else if ((corners[first] == low) == (corners[sides[start + 1].number] == low)) {
        surface.against.add(first, low, high);
      }
    }
  }
}

Surface surfaceOf(const std::uint32_t* corners, std::size_t face_count, std::size_t vertex_count)
{
  Surface surface;
  DisjointSets parts(vertex_count);
  {
    DisjointSets fans(3 * face_count);
    lookAtEdges(corners, face_count, vertex_count, surface, fans, parts);
    std::vector<std::uint32_t> fans_at(vertex_count);
    for (std::uint32_t corner = 0; corner < 3 * face_count; ++corner) {
      if (fans.find(corner) == corner && isPlain(corners + corner / 3 * 3)) {
        ++fans_at[corners[corner]];
      }
    }
    surface.first_split = vertex_count;
    for (std::size_t v = vertex_count; v-- > 0;) {
      if (fans_at[v] > 1) {
        ++surface.split_count;
        surface.first_split = v;
      }
    }
  }
  std::vector<bool> used(vertex_count);
  for (std::size_t i = 0; i < 3 * face_count; ++i) {
    used[corners[i]] = true;
  }
  std::vector<std::uint32_t> sizes(vertex_count);
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (used[v]) {
      ++surface.used;
      const std::uint32_t size = ++sizes[parts.find(v)];
      surface.parts += size == 1;
      surface.largest = std::max<std::size_t>(surface.largest, size);
    }
  }
  return surface;
}

py::tuple surface(const Faces& faces, std::size_t vertex_count)
{
  check(faces, vertex_count);
  const std::uint32_t* const corners = faces.data();
  const auto face_count = static_cast<std::size_t>(faces.shape(0));
  Surface found;
  {
    const py::gil_scoped_release release;
    found = surfaceOf(corners, face_count, vertex_count);
  }
  return py::make_tuple(found.many.asTuple(), found.border.asTuple(), found.against.asTuple(),
                        std::make_tuple(found.split_count, found.first_split),
                        std::make_tuple(found.parts, found.largest, found.used));
}

using Vector = std::array<double, 3>;

Vector minus(const float* p, const float* q)
{
  return {double(p[0]) - double(q[0]), double(p[1]) - double(q[1]), double(p[2]) - double(q[2])};
}

double square(const Vector& d)
{
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

/// (twice the area of each face, the square of its longest edge, z of its normal: (F,) float64 and
/// int8 of -1, 0, 1; the sum of the normals of the faces at each vertex, as long as twice the
/// areas: (V, 3)), each as NumPy computes it.
py::tuple shapes(const Vertices& vertices, const Faces& faces)
{
  if (vertices.ndim() != 2 || vertices.shape(1) != 3) {
    throw std::invalid_argument("vertices must be (V, 3)");
  }
  check(faces, static_cast<std::size_t>(vertices.shape(0)));
  const auto face_count = faces.shape(0);
  py::array_t<double> areas(face_count), longest(face_count),
      around({vertices.shape(0), py::ssize_t{3}});
  py::array_t<std::int8_t> up(face_count);
  const float* const points = vertices.data();
  const std::uint32_t* corners = faces.data();
  double* const area = areas.mutable_data();
  double* const longest_edge = longest.mutable_data();
  double* const normals = around.mutable_data();
  std::int8_t* const upward = up.mutable_data();
  const auto vertex_numbers = around.size();
  {
    const py::gil_scoped_release release;
    std::fill(normals, normals + vertex_numbers, 0.0);
    for (py::ssize_t i = 0; i < face_count; ++i, corners += 3) {
      const float* const a = points + 3 * std::size_t{corners[0]};
      const float* const b = points + 3 * std::size_t{corners[1]};
      const float* const c = points + 3 * std::size_t{corners[2]};
      const Vector u = minus(b, a), v = minus(c, a);
      const Vector normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]};
      area[i] = std::sqrt(square(normal));
      longest_edge[i] = std::max({square(minus(a, b)), square(minus(b, c)), square(minus(c, a))});
      upward[i] = static_cast<std::int8_t>((normal[2] > 0) - (normal[2] < 0));
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          normals[3 * std::size_t{corners[k]} + axis] += normal[axis];
        }
      }
    }
  }
  return py::make_tuple(areas, longest, up, around);
}

}  // namespace

PYBIND11_MODULE(_surface, module)
{
  module.def("_repeated_faces", &repeatedFaces, py::arg("faces"), py::arg("vertex_count"));
  module.def("_surface", &surface, py::arg("faces"), py::arg("vertex_count"));
  module.def("_shapes", &shapes, py::arg("vertices"), py::arg("faces"));
}

}  // namespace mesh_msgs_hdf5
