#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/region.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace mesh_map {

enum class SelectionMode
{
  TOUCHING,  ///< faces that touch the region
  INSIDE     ///< faces of which all is in the region
};

/// The faces that a region selects, ascending. `mask` (per face, 0 = never; empty: all) filters.
/// Throws Canceled, or std::bad_alloc; it uses one thread, and tells no progress.
std::vector<std::uint32_t> selectFaces(const Bvh& bvh, const Region& region,
                                       SelectionMode mode = SelectionMode::TOUCHING,
                                       ArrayView<std::uint8_t> mask = {},
                                       const BvhOptions& run = {});

/// How a batch of rays is cast: natively or on a device, with the same answer.
using RayCast = std::function<RayHits(const RayBatch&)>;

/// Of these faces (ascending; they touch the region), those that are seen from the eye, ascending.
///
/// A face is seen if one of its sample points is: the centroid of the face and those of its three
/// corner triangles (cut off by lines between the middles of the edges) as far as they are in the
/// region, or the region's witness if none is. A sample is seen if the first face on the way from
/// the eye to it is the face itself or one that touches the sample, or if there is none. What is
/// nearer to the sample than its distance to the eye times 1e-9, plus the step of 32-bit floats of
/// the size of its coordinates, touches it and is not on the way. From an eye that is not finite,
/// nothing is seen.
///
/// Rays are cast in few batches: to the centroids first, then to the other samples of faces that
/// are not seen yet (2^18 faces at a time). Unused places have a negative maximum distance, so they
/// hit nothing. Throws what `cast` throws.
std::vector<std::uint32_t> seenFaces(const Bvh& bvh, const Region& region,
                                     ArrayView<std::uint32_t> faces,
                                     const std::array<double, 3>& eye, const RayCast& cast);

/// The faces that show in a picture, ascending: those that the rays hit first, as far as the hit is
/// in the region and the mask has the face (which hides what is behind it in any case). Throws what
/// `cast` throws.
std::vector<std::uint32_t> facesInPicture(const Bvh& bvh, const Region& region,
                                          const RayBatch& pixels, ArrayView<std::uint8_t> mask,
                                          const RayCast& cast);

/// Rays through the pixels of a picture: origins has 3 numbers for each, or 3 for all.
struct PixelRays
{
  std::vector<double> origins, directions;
};

/// Rays from the eye through the centers of columns x rows cells of a frustum whose first four
/// planes are its sides, left, right, bottom and top, and meet in the eye; row by row from the
/// bottom, each from the left. Throws std::invalid_argument where they do not.
PixelRays frustumPixels(const ConvexRegion& frustum, const std::array<double, 3>& eye,
                        std::size_t columns, std::size_t rows);

/// Rays, from the near plane on, through the centers of those of columns x rows pixels of the whole
/// picture that are in the polygon; row by row from the bottom, each from the left. Throws
/// std::invalid_argument for a matrix without an inverse.
PixelRays lassoPixels(const LassoRegion& lasso, std::size_t columns, std::size_t rows);

}  // namespace mesh_map
