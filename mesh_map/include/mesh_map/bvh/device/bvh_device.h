#pragma once

#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <cstdint>
#include <vector>

/// What a host of OpenCL does before and after the kernels of kernels/bvh.cl, without OpenCL.
///
/// Kernels compute in 32-bit floats with bounds of their errors. They name the few triangles one of
/// which is the answer, or say that they cannot (DEVICE_DOUBT). The answer is then found here in
/// double precision among these few, or by the native query. So it is that of the native query to
/// the last bit, whatever the device rounds. Answers that no kernel gives (a number that is no
/// triangle) are taken for doubt.
///
/// Buffers, all as they are in memory here:
///   nodes    const float4*  Bvh::nodes()                               read only
///   corners  const float*   Bvh::corners() with Bvh::TAIL floats more  read only
///   mask     const uchar*   deviceMask(), or any one byte              read only
/// Work items: one per ray, point or root; a global size above that is rounded up freely (kernels
/// are told the count). Work groups of DEVICE_WORK_GROUP, always: some drivers compile anew for
/// others. Slices of a batch (some ten thousand) are best packed, asked and finished on their own.
///
/// Counting (back_end.h) is the caller's: a batch that a device has answered counts as OPENCL. What
/// was in doubt counts as NATIVE besides.
namespace mesh_map {

/// OpenCL C 1.2, the text of kernels/bvh.cl.
extern const char* const BVH_KERNELS;

/// Text for clBuildProgram.
extern const char* const BVH_KERNEL_OPTIONS;

constexpr std::size_t DEVICE_WORK_GROUP = 64;

constexpr std::uint32_t DEVICE_NONE = 0xFFFFFFFFu;   ///< sure: nothing (more)
constexpr std::uint32_t DEVICE_DOUBT = 0xFFFFFFFEu;  ///< ask natively

/// Bits of `flags`.
constexpr std::uint32_t DEVICE_BACK_FACES = 1;  ///< faces seen from behind are hit
constexpr std::uint32_t DEVICE_MASKED = 2;      ///< the mask counts (else it may be one byte)
constexpr std::uint32_t DEVICE_ANY_HIT = 4;     ///< any hit will do: for finishRaysAny()

/// A mask per face as one per triangle, in the order of the leaves, which kernels read. Throws
/// std::invalid_argument for a mask of another size.
std::vector<std::uint8_t> deviceMask(const Bvh& bvh, ArrayView<std::uint8_t> mask);

/// Kernel cast_rays(nodes, corners, global const float4* rays, mask, uint flags, uint ray_count,
///                  global uint* answers)
/// rays: what packRays() gives: DEVICE_RAY_FLOATS for the mesh, then as many per ray.
/// answers: DEVICE_RAY_ANSWERS per ray: triangles (positions in the order of the leaves), one of
/// which is hit first if any is, filled up with DEVICE_NONE; or DEVICE_DOUBT first.
///
/// pack...() and finish...() throw Canceled, std::bad_alloc, or std::invalid_argument for arrays
/// that do not fit each other.
constexpr std::size_t DEVICE_RAY_FLOATS = 16;
constexpr std::size_t DEVICE_RAY_ANSWERS = 4;
std::vector<float> packRays(const Bvh& bvh, const RayBatch& rays, const BvhOptions& run = {});
RayHits finishRays(const Bvh& bvh, const RayBatch& rays, const RayOptions& options,
                   ArrayView<std::uint32_t> answers, const BvhOptions& run = {});

/// As raysHitAny(), after a kernel with DEVICE_ANY_HIT.
std::vector<std::uint8_t> finishRaysAny(const Bvh& bvh, const RayBatch& rays,
                                        const RayOptions& options, ArrayView<std::uint32_t> answers,
                                        const BvhOptions& run = {});

/// Kernel closest_points(nodes, corners, global const float4* points, mask, uint flags,
///                       uint point_count, global uint* answers)
/// points: what packPoints() gives: DEVICE_POINT_FLOATS for the mesh, then as many per point.
/// answers: DEVICE_CANDIDATES triangles per point, one of which is the closest, filled up with
/// DEVICE_NONE; or DEVICE_DOUBT first, also where they are more. Options have no normals.
constexpr std::size_t DEVICE_POINT_FLOATS = 8;
constexpr std::size_t DEVICE_CANDIDATES = 8;
std::vector<float> packPoints(const Bvh& bvh, ArrayView<double> points,
                              const ClosestOptions& options, const BvhOptions& run = {});
SurfaceHits finishPoints(const Bvh& bvh, ArrayView<double> points, const ClosestOptions& options,
                         ArrayView<std::uint32_t> answers, const BvhOptions& run = {});

/// Kernels select_sphere(nodes, corners, global const float4* region, global const uint2* roots,
///                       uint root_count, global uchar* verdicts)
///     and select_planes(nodes, corners, global const float4* region, uint plane_count,
///                       global const uint2* roots, uint root_count, global uchar* verdicts)
/// region: what packSphere() or packPlanes() gives; plane_count: ConvexRegion::planes().size().
/// roots: what selectionRoots() gives, two numbers per root, which is a subtree: BvhNode::child of
/// it, and the position of its first triangle (for a leaf: BvhNode::count of it). None: there is
/// nothing to select, and no kernel to run.
/// verdicts: a byte per triangle of the mesh, all 0 before, of DEVICE_OUTSIDE to DEVICE_UNSURE.
std::vector<std::uint32_t> selectionRoots(const Bvh& bvh, const Region& region);
constexpr std::uint8_t DEVICE_OUTSIDE = 0, DEVICE_TOUCHING = 1, DEVICE_INSIDE = 2,
                       DEVICE_UNSURE = 3;
std::vector<float> packSphere(const Bvh& bvh, const SphereRegion& sphere);
std::vector<float> packPlanes(const Bvh& bvh, const ConvexRegion& region);

/// As selectFaces().
std::vector<std::uint32_t> finishSelection(const Bvh& bvh, const Region& region, SelectionMode mode,
                                           ArrayView<std::uint8_t> mask,
                                           ArrayView<std::uint8_t> verdicts,
                                           const BvhOptions& run = {});

}  // namespace mesh_map
