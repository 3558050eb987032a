#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/run_options.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <cstdint>
#include <vector>

namespace mesh_map {

/// What collisions() is asked for.
struct CollisionQuery
{
  MeshView mesh;                    ///< z is up
  RowsView vertex_faces;            ///< the faces around each vertex
  ArrayView<std::uint32_t> solids;  ///< of each face, see solids.h
  /// How far above each vertex the next face is that is above step_height, or infinity; or none: it
  /// is a short cut, and changes nothing.
  ArrayView<float> rooms;

  double radius = 0.0;        ///< of the body; >= 0
  double step_height = 0.0;   ///< what the robot climbs
  double robot_height = 0.0;  ///< above step_height
};

/// For each vertex 1 where a body that stands there meets something, else 0.
///
/// The body is upright: what is more than step_height above the ground, and less than robot_height,
/// by 0.1 mm each (or four times the distance of neighboring floats, where that is more). A vertex
/// stands for what is nearer to it than to the other corners of the faces around it (its cell). It
/// has 1
///
/// * where a face is in the body of a point, with no radius, of its cell; faces within 1.2 degrees
///   of upright have no cells, and a vertex that has only such faces, or none, is a cell by itself;
/// * where there is Material half way up its body;
/// * where a face is in its body with the radius, and is no ground. Ground is what is reached from
///   the vertex from face to face within the radius, as long as all corners are at most step_height
///   and their distance (in plan) above the vertex: slopes of up to 45 degrees, and stairs. Onto
///   faces without cells, such as risers, it goes from vertices alone that have 0 without a radius.
///
/// So a path that passes no vertex with 1, nor a face with one, passes under or through nothing,
/// whatever the size of the faces.
///
/// Throws Canceled, std::bad_alloc, or std::invalid_argument for arrays that do not fit each other.
std::vector<std::uint8_t> collisions(const Bvh& bvh, const CollisionQuery& query,
                                     const BvhOptions& options = {});

}  // namespace mesh_map
