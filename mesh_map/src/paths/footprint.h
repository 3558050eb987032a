#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// The ground that a robot covers: what is above and below a convex polygon, between two heights,
/// in the frame of the robot (meters).
struct Footprint
{
  std::vector<std::array<double, 2>> corners;  ///< counter-clockwise, at least 3
  double lowest = 0.0, highest = 0.0;          ///< z of the band
};

/// What is under footprints: one entry per pose.
struct FootprintCosts
{
  std::vector<float> max_costs;  ///< of the part of the faces that is in the band, over the corners
                                 ///< of these parts, where cost is linear; only of faces whose
                                 ///< costs are all known and not lethal; 0 without such
  std::vector<std::uint8_t> lethal;   ///< a face touches the band that has a lethal corner (+inf)
  std::vector<std::uint8_t> unknown;  ///< ... that has a corner of unknown cost (NaN)
  std::vector<double> ground;  ///< share of the polygon above or below which there are faces in the
                               ///< band, of a grid of points
  std::vector<std::uint32_t> face_counts;  ///< faces that touch the band
};

/// Points of the grid on the longer side of the box around the footprint.
constexpr std::size_t GROUND_SAMPLES = 24;

/// Costs (one per vertex) under a footprint at each pose: 12 numbers, the upper three rows of the
/// matrix from the frame of the robot to that of the mesh (a rotation and a shift; not checked). A
/// face counts if it touches the band anywhere, its border included. A pose that is not finite has
/// no faces. Throws std::invalid_argument for a polygon that is not convex and counter-clockwise,
/// for a mesh that is not that of the hierarchy, or arrays of other sizes, Canceled, or
/// std::bad_alloc.
FootprintCosts footprintCosts(const Bvh& bvh, const MeshView& mesh, ArrayView<float> costs,
                              const Footprint& footprint, ArrayView<double> poses,
                              const BvhOptions& run = {});

/// The vertices under footprints: those of pose i are vertices[offsets[i]] to
/// vertices[offsets[i + 1] - 1], ascending.
struct FootprintVertices
{
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint32_t> vertices;
};

/// The vertices that say what the ground under a footprint is: each stands for those points of its
/// faces to which it is the nearest corner, and counts if one of these points is in the band (its
/// border included). Arguments and exceptions are those of footprintCosts().
FootprintVertices footprintVertices(const Bvh& bvh, const MeshView& mesh,
                                    const Footprint& footprint, ArrayView<double> poses,
                                    const BvhOptions& run = {});

}  // namespace mesh_map
