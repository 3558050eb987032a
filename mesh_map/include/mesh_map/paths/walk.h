#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Why a walk ended.
enum class WalkEnd : std::uint8_t
{
  ARRIVED = 0,  ///< all of the length was walked, or the target of a line reached
  BORDER = 1,   ///< the surface ends there
  BLOCKED = 2,  ///< the next face does not count
  STEPS = 3,    ///< more faces than allowed
  NOWHERE = 4,  ///< no start: no such face, one without area, weights of no point in it, or numbers
                ///< that are not finite; or no direction: none along the face
  LOOP = 5      ///< a line came to where it has been: the cut does not lead to the target
};

/// What walks need to know of a mesh. The arrays have to outlive all use.
struct WalkMesh
{
  MeshView mesh;
  ArrayView<std::uint32_t> face_edges;  ///< of Topology
  ArrayView<std::uint8_t> face_flags;   ///< of Topology
  RowsView edge_faces;                  ///< of edgeFaces()
  RowsView vertex_faces;                ///< of Topology
};

/// Where somebody stands on a surface, and where he looks.
struct WalkPose
{
  std::uint32_t face = NO_INDEX;
  std::array<double, 3> barycentric{};  ///< weights of the corners of the face
  std::array<double, 3> direction{};    ///< given: any, what of it is along the face counts; found:
                                        ///< unit vector along the face
  std::array<double, 3> up{};  ///< on which side of the surface he is; given: 0 for the side from
                               ///< which the corners of the face run counter-clockwise; found: unit
                               ///< normal of the face to that side
};

/// Throws std::invalid_argument unless all arrays are of one mesh (faces are taken as checked): a
/// walk on what it accepts never reads beyond them.
void checkWalkMesh(const WalkMesh& mesh);

struct WalkOptions
{
  ArrayView<std::uint8_t> mask;     ///< per face: 0 = must not be entered (but may be left); empty:
                                    ///< all count
  std::size_t max_steps = 1000000;  ///< faces to cross
};

struct Walk
{
  WalkPose pose;
  std::array<double, 3> position{};
  double length = 0.0;  ///< that was walked, >= 0
  WalkEnd end = WalkEnd::NOWHERE;
};

/// The way of a walk: one point more than faces; face i has the points i and i + 1. Faces that are
/// only touched are not in it.
struct WalkTrace
{
  std::vector<double> points;  ///< 3 per point
  std::vector<std::uint32_t> faces;
};

/// Straight on over the surface from a pose: the straightest geodesic (K. Polthier, M. Schmies:
/// Straightest Geodesics on Polyhedral Surfaces, 1998). It goes straight where the faces that it
/// crosses are unfolded into the plane, whichever way round these are, and across faces without
/// area; a vertex is passed with as much angle on the left as on the right. Where faces do not go
/// all the way round a vertex (at a border, where only corners of pieces meet), it goes on in the
/// face there that contains its direction as seen along the normal of the face it was in; so it
/// does from a start at a vertex, too. Of more than two faces at an edge, it goes on in the one
/// that bends least (then in that of lowest index); duplicates of a face count for nothing.
///
/// A negative length is walked backwards: the pose looks where it did before. Two walks, one from
/// where the other ended, are one walk: also at an edge or vertex, where the pose may look out of
/// its face. The same numbers give the same walk. Throws std::invalid_argument for a mask of
/// another size.
///
/// Positions are exact to some 1e-15 of the size of the faces for each face crossed. What passes a
/// vertex by less than 1e-12 of the longest edge of the face passes through it. A start nearer to a
/// vertex than 1e-9 of that is at it where else the walk would end at the border at once.
Walk walkStraight(const WalkMesh& mesh, const WalkPose& start, double length,
                  const WalkOptions& options = {}, WalkTrace* trace = nullptr);

/// Over the surface to a target, straight as seen from above: along the cut of the surface with the
/// plane through start, target and `start.up` (0: the normal of the face), to where the way to the
/// target is done as seen along `up`. Whether that is the target, or above or below it, its
/// position tells. `start.direction` does not matter; the direction found is 0 where nothing was
/// walked. Ends BORDER where the cut leaves the surface.
///
/// The start is moved into its face by 1e-9 of it, so that no way runs exactly along a border. From
/// a vertex (or nearer than that), and through one at a border, it goes on in the face there that
/// contains the way to the target as seen along `up`.
Walk walkLine(const WalkMesh& mesh, const WalkPose& start, const std::array<double, 3>& target,
              const WalkOptions& options = {}, WalkTrace* trace = nullptr);

}  // namespace mesh_map
