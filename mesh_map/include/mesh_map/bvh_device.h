#ifndef MESH_MAP_BVH_DEVICE_H
#define MESH_MAP_BVH_DEVICE_H

#include <mesh_map/bvh.h>
#include <mesh_map/bvh_closest.h>
#include <mesh_map/bvh_rays.h>
#include <mesh_map/bvh_selection.h>

#include <cstdint>
#include <string>
#include <vector>

/// What a host of OpenCL does before and after the kernels of kernels/bvh.cl, without OpenCL.
///
/// Kernels compute in 32-bit floats with bounds of their errors, and say so where these leave a
/// doubt. What they are sure of is finished here in double precision, and what is in doubt is asked
/// natively, so that the answer is that of the native queries to the last bit, whatever the device
/// rounds.
///
/// Buffers: nodes = Bvh::nodes(), corners = Bvh::corners() with its tail, faces = Bvh::faces(), all
/// as they are in memory. Work items: one per ray, point or triangle; a global size above that is
/// rounded up freely (kernels are told the count).
namespace mesh_map {

/// OpenCL C 1.2, the text of kernels/bvh.cl.
extern const char* const BVH_KERNELS;

/// Text for clBuildProgram.
extern const char* const BVH_KERNEL_OPTIONS;

constexpr std::uint32_t DEVICE_NONE = 0xFFFFFFFFu;   ///< sure: nothing
constexpr std::uint32_t DEVICE_DOUBT = 0xFFFFFFFEu;  ///< ask natively

/// A mask per face as one per triangle, in the order of the leaves, which kernels read.
std::vector<std::uint8_t> deviceMask(const Bvh& bvh, ArrayView<std::uint8_t> mask);

/// Kernel `cast_rays(nodes, corners, rays, mask, flags, ray_count, answers)`: DEVICE_RAY_FLOATS per
/// ray; answers: a triangle (position in the order of the leaves), DEVICE_NONE or DEVICE_DOUBT.
constexpr std::size_t DEVICE_RAY_FLOATS = 12;
std::vector<float> packRays(const Bvh& bvh, const RayBatch& rays, const BvhOptions& run = {});
RayHits finishRays(const Bvh& bvh, const RayBatch& rays, const RayOptions& options,
                   ArrayView<std::uint32_t> answers, const BvhOptions& run = {});

/// Kernel `closest_points(nodes, corners, points, mask, flags, point_count, answers)`:
/// DEVICE_POINT_FLOATS per point; answers: DEVICE_CANDIDATES triangles per point, one of which is
/// the closest, filled up with DEVICE_NONE; the first is DEVICE_DOUBT where they are more.
constexpr std::size_t DEVICE_POINT_FLOATS = 8;
constexpr std::size_t DEVICE_CANDIDATES = 8;
std::vector<float> packPoints(const Bvh& bvh, ArrayView<double> points,
                              const ClosestOptions& options, const BvhOptions& run = {});
SurfaceHits finishPoints(const Bvh& bvh, ArrayView<double> points, const ClosestOptions& options,
                         ArrayView<std::uint32_t> answers, const BvhOptions& run = {});

/// Whether closest_points can do this question (a limit to the angle of normals it cannot).
bool deviceAnswers(const ClosestOptions& options);

/// Bits of `flags` of both kernels.
constexpr std::uint32_t DEVICE_BACK_FACES = 1;  ///< faces seen from behind are hit
constexpr std::uint32_t DEVICE_MASKED = 2;      ///< the mask counts (else it may be one byte)

/// Kernels `select_sphere(nodes, corners, region, roots, root_count, verdicts)` and `select_planes(
/// nodes, corners, region, plane_count, roots, root_count, verdicts)`: one work item per root,
/// which is a subtree (two numbers: BvhNode::child of it, position of its first triangle);
/// verdicts: a byte per triangle of the mesh, zero before, of DEVICE_OUTSIDE to DEVICE_UNSURE.
std::vector<std::uint32_t> selectionRoots(const Bvh& bvh, const Region& region);
constexpr std::uint8_t DEVICE_OUTSIDE = 0, DEVICE_TOUCHING = 1, DEVICE_INSIDE = 2,
                       DEVICE_UNSURE = 3;
std::vector<float> packSphere(const Bvh& bvh, const SphereRegion& sphere);
std::vector<float> packPlanes(const Bvh& bvh, const ConvexRegion& region);
std::vector<std::uint32_t> finishSelection(const Bvh& bvh, const Region& region, SelectionMode mode,
                                           ArrayView<std::uint8_t> mask,
                                           ArrayView<std::uint8_t> verdicts,
                                           const BvhOptions& run = {});

}  // namespace mesh_map

#endif  // MESH_MAP_BVH_DEVICE_H
