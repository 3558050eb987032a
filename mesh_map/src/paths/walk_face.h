#pragma once

#include <mesh_map/paths/walk.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/vector3.h"

namespace mesh_map {

inline const float* position(const WalkMesh& mesh, std::uint32_t vertex)
{
  return mesh.mesh.vertex(vertex);
}

inline std::uint32_t cornerOf(const WalkMesh& mesh, std::uint32_t face, std::size_t k)
{
  return mesh.mesh.faces[3 * std::size_t{face} + k];
}

/// The place of a vertex among the corners of a face.
std::size_t slotOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex);

/// The face on the other side of the edge opposite to a corner; NO_INDEX at a border. See
/// walkStraight() for edges of more than two faces.
std::uint32_t faceAcross(const WalkMesh& mesh, std::uint32_t face, std::size_t opposite_slot);

/// A face laid into the plane as seen from the side of the walker: corner 0 in the origin, corner 1
/// on the x axis, corner 2 at y >= 0.
class FlatFace
{
 public:
  /// From corner `first` on; in the order of the face, or the other way round.
  FlatFace(const WalkMesh& mesh, std::uint32_t face, std::size_t first, bool reversed);

  /// Such that corner 0 and 1 are these vertices.
  static FlatFace along(const WalkMesh& mesh, std::uint32_t face, std::uint32_t from,
                        std::uint32_t to);

  std::uint32_t face() const { return face_; }

  /// The place of corner k in the face, and its vertex.
  std::size_t slot(std::size_t k) const { return slots_[k]; }
  std::uint32_t vertex(std::size_t k) const { return vertices_[k]; }
  const Vector2& corner(std::size_t k) const { return corners_[k]; }

  /// Whether it has a plane.
  bool hasArea() const { return has_area_; }

  /// Of its sides.
  double longest() const { return longest_; }

  /// Lengths that are smaller are nothing.
  double tolerance() const { return tolerance_; }

  /// Of directions in space, and back. Only with an area.
  Vector2 flat(const Vector3& way) const { return {dot(way, x_axis_), dot(way, y_axis_)}; }
  Vector3 inSpace(const Vector2& way) const { return way[0] * x_axis_ + way[1] * y_axis_; }
  const Vector3& normal() const { return normal_; }

  /// Weights of the corners of the face (by slots) at a point, 0 to 1.
  std::array<double, 3> barycentric(const Vector2& point) const;
  Vector2 point(const std::array<double, 3>& barycentric) const;

  /// In space, of weights by slots.
  Vector3 positionOf(const std::array<double, 3>& barycentric) const
  {
    return origin_ + (barycentric[slots_[1]] * u_ + barycentric[slots_[2]] * w_);
  }

 private:
  std::uint32_t face_;
  std::array<std::size_t, 3> slots_;
  std::array<std::uint32_t, 3> vertices_;
  std::array<Vector2, 3> corners_{};
  Vector3 origin_, u_, w_;  // corner 0, and the sides from it
  Vector3 x_axis_{}, y_axis_{}, normal_{};
  double longest_ = 0.0, tolerance_ = 0.0;
  bool has_area_ = false;
};

/// How a ray leaves a face.
struct FaceExit
{
  enum Kind
  {
    EDGE,    ///< across the edge from corner `index` to the next, `share` of it from there
    CORNER,  ///< through corner `index`
    TURN     ///< it starts in corner `index` and points out of the face
  };
  Kind kind;
  std::size_t index;
  double distance;  ///< on the way there
  double share = 0.0;
};

/// `point` in the face, `direction` of length 1.
FaceExit exitOf(const FlatFace& face, const Vector2& point, const Vector2& direction);

}  // namespace mesh_map
