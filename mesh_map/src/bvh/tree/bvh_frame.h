#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "bvh/tree/float_box.h"

namespace mesh_map {

/// Local coordinates of a hierarchy: those of the mesh minus a center.
class LocalFrame
{
 public:
  /// From larger ones on a difference might overflow.
  static constexpr float LARGEST_CENTER = 1e30f;

  explicit LocalFrame(const std::array<float, 3>& center) : center_(load3(center.data())) {}

  /// The box of a triangle (9 floats), rounded outwards: flat where the triangle is and the
  /// difference to the center is exact.
  FloatBox box(const float* corners) const { return box(corners, corners + 3, corners + 6); }

  FloatBox box(const float* a, const float* b, const float* c) const
  {
    FloatBox result;
    add(load3(a), result);
    add(load3(b), result);
    add(load3(c), result);
    return result;
  }

  FloatBox box(const MeshView& mesh, std::size_t face) const
  {
    return box(mesh.corner(face, 0), mesh.corner(face, 1), mesh.corner(face, 2));
  }

 private:
  void add(Floats4 point, FloatBox& box) const
  {
    // The difference and what it lacks, exactly (D. Knuth: The Art of Computer Programming 2,
    // 4.2.2, theorem B). No overflow: see LARGEST_CENTER.
    // Zero is made positive, so that boxes do not depend on the order of corners.
    const Floats4 local = (point - center_) + all4(0.0f);
    const Floats4 point_used = local + center_;
    const Floats4 center_used = point_used - local;
    const Floats4 error = (point - point_used) + (center_used - center_);
    // An inexact difference is no denormal number, so this is one unit in its last place or more.
    const Floats4 zero = all4(0.0f);
    const Floats4 unit = maximum(local, -local) * all4(std::numeric_limits<float>::epsilon());
    box.lower = minimum(local - (error < zero ? unit : zero), box.lower);
    box.upper = maximum(local + (error > zero ? unit : zero), box.upper);
  }

  Floats4 center_;
};

/// Reads the faces [0, count) of a list in its order, which may be any, with memory asked for
/// ahead: first the faces, then their vertices. `face(i)` is the i-th one, `use(i)` what to do with
/// it.
template <class Face, class Use>
void forEachFace(const MeshView& mesh, std::size_t count, const Face& face, const Use& use)
{
  constexpr std::size_t AHEAD = 12;
  const std::uint32_t* const corners = mesh.faces.data();
  const float* const positions = mesh.positions.data();
  for (std::size_t i = 0; i < count; ++i) {
    if (i + 2 * AHEAD < count) {
      __builtin_prefetch(corners + 3 * std::size_t{face(i + 2 * AHEAD)});
      const std::uint32_t* const next = corners + 3 * std::size_t{face(i + AHEAD)};
      __builtin_prefetch(positions + 3 * std::size_t{next[0]});
      __builtin_prefetch(positions + 3 * std::size_t{next[1]});
      __builtin_prefetch(positions + 3 * std::size_t{next[2]});
    }
    use(i);
  }
}

/// Some faces that are sound, evenly over the mesh: what a hierarchy is planned with.
class FaceSample
{
 public:
  explicit FaceSample(const MeshView& mesh);

  /// A center that lies among most of the triangles, however far away the others are; 0 along an
  /// axis where the mesh is near its origin, and else a number with few digits: then differences to
  /// it are exact nearly everywhere.
  std::array<float, 3> center() const;

  /// The box of most triangles' centers (of their boxes, twice their local coordinates).
  FloatBox mainBox(const LocalFrame& frame) const;

 private:
  MeshView mesh_;
  std::vector<std::uint32_t> faces_;
};

}  // namespace mesh_map
