#ifndef MESH_TOOLS_TEST_EMBREE_SCENE_H
#define MESH_TOOLS_TEST_EMBREE_SCENE_H

#include <embree3/rtcore.h>
#include <mesh_map/base/parallel.h>
#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

/// Rays in single precision, as Embree takes them: origin and unit direction, 6 floats each.
using Rays = std::vector<float>;

/// What Embree says about a ray.
struct EmbreeHits
{
  std::vector<std::uint32_t> faces;
  std::vector<float> distances;

  explicit EmbreeHits(std::size_t count) : faces(count), distances(count) {}
};

/// A mesh in Embree 3, which the benchmark of the spatial index compares with.
class EmbreeScene
{
 public:
  /// `threads` 0: all cores.
  EmbreeScene(const std::vector<float>& vertices, const std::vector<std::uint32_t>& faces,
              RTCBuildQuality quality, unsigned threads, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE)
      : vertices_(vertices), faces_(faces)
  {
    device_ = rtcNewDevice(threads ? ("threads=" + std::to_string(threads)).c_str() : nullptr);
    if (!device_) {
      throw std::runtime_error("Embree makes no device");
    }
    rtcSetDeviceMemoryMonitorFunction(device_, count, &bytes_);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, flags);
    geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               vertices.data(), 0, 12, vertices.size() / 3);
    rtcSetSharedGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, faces.data(),
                               0, 12, faces.size() / 3);
    rtcSetGeometryPointQueryFunction(geometry_, nearer);
    if (flags & RTC_SCENE_FLAG_DYNAMIC) {
      rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_REFIT);
    }
    rtcCommitGeometry(geometry_);
    rtcAttachGeometryByID(scene_, geometry_, 0);
    rtcSetSceneBuildQuality(scene_, quality);
    rtcCommitScene(scene_);
  }

  ~EmbreeScene()
  {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// Bytes held beside the arrays of the mesh.
  std::size_t memory() const { return static_cast<std::size_t>(bytes_); }

  /// After the vertices have moved.
  void refit()
  {
    rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
  }

  /// The nearest hit of one ray; true if there is one.
  bool cast(const float* ray, std::uint32_t& face, float& distance) const
  {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit;
    hit.ray = {ray[0], ray[1], ray[2], 0.0f, ray[3], ray[4], ray[5], 0.0f, INFINITY, ~0u, 0, 0};
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &hit);
    const bool found = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    face = found ? hit.hit.primID : mesh_map::NO_INDEX;
    distance = hit.ray.tfar;
    return found;
  }

  /// All rays one by one (Intersect1), or eight at a time (Intersect8).
  void cast(const Rays& rays, unsigned width, unsigned threads, EmbreeHits& hits) const
  {
    mesh_map::parallelFor(rays.size() / 6, 4096, threads, [&]() -> mesh_map::RangeBody {
      return [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; i += width) {
          if (width == 8) {
            castEight(rays, i, std::min(end, i + 8), hits);
          } else {
            cast(&rays[6 * i], hits.faces[i], hits.distances[i]);
          }
        }
      };
    });
  }

  /// Whether there is any hit, for each ray.
  void occluded(const Rays& rays, unsigned threads, std::vector<std::uint8_t>& answers) const
  {
    mesh_map::parallelFor(rays.size() / 6, 4096, threads, [&]() -> mesh_map::RangeBody {
      return [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          RTCIntersectContext context;
          rtcInitIntersectContext(&context);
          const float* r = &rays[6 * i];
          RTCRay ray{r[0], r[1], r[2], 0.0f, r[3], r[4], r[5], 0.0f, INFINITY, ~0u, 0, 0};
          rtcOccluded1(scene_, &context, &ray);
          answers[i] = ray.tfar < 0.0f;
        }
      };
    });
  }

  /// The face nearest to each point (3 floats each).
  void closest(const std::vector<float>& points, unsigned threads, EmbreeHits& hits) const
  {
    mesh_map::parallelFor(points.size() / 3, 1024, threads, [&]() -> mesh_map::RangeBody {
      return [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          Query query = ask(&points[3 * i], INFINITY, nullptr);
          hits.faces[i] = query.face;
          hits.distances[i] = static_cast<float>(query.distance);
        }
      };
    });
  }

  /// The faces that touch a ball.
  std::vector<std::uint32_t> sphere(const float* center, float radius) const
  {
    std::vector<std::uint32_t> found;
    ask(center, radius, &found);
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  /// What a point query fills in: the nearest face, or all within the radius.
  struct Query
  {
    const EmbreeScene* scene;
    double point[3];
    double radius;
    std::vector<std::uint32_t>* all;
    std::uint32_t face = mesh_map::NO_INDEX;
    double distance = std::numeric_limits<double>::infinity();
  };

  Query ask(const float* point, float radius, std::vector<std::uint32_t>* all) const
  {
    Query query{this, {point[0], point[1], point[2]}, radius, all};
    RTCPointQuery where{point[0], point[1], point[2], 0.0f, radius};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &where, &context, nullptr, &query);
    return query;
  }

  static bool nearer(RTCPointQueryFunctionArguments* arguments)
  {
    Query& query = *static_cast<Query*>(arguments->userPtr);
    const std::uint32_t* face = &query.scene->faces_[3 * std::size_t{arguments->primID}];
    const float* corners = query.scene->vertices_.data();
    const double distance =
        mesh_map::closestPointOnTriangle(corners + 3 * face[0], corners + 3 * face[1],
                                         corners + 3 * face[2], query.point)
            .distance;
    if (query.all) {
      if (distance <= query.radius) {
        query.all->push_back(arguments->primID);
      }
      return false;
    }
    if (distance >= query.distance) {
      return false;
    }
    query.face = arguments->primID;
    query.distance = distance;
    arguments->query->radius = static_cast<float>(distance);
    return true;  // the radius has changed
  }

  void castEight(const Rays& rays, std::size_t begin, std::size_t end, EmbreeHits& hits) const
  {
    alignas(32) int valid[8];
    RTCRayHit8 packet;
    for (std::size_t k = 0; k < 8; ++k) {
      const float* ray = &rays[6 * std::min(begin + k, end - 1)];
      valid[k] = begin + k < end ? -1 : 0;
      packet.ray.org_x[k] = ray[0], packet.ray.org_y[k] = ray[1], packet.ray.org_z[k] = ray[2];
      packet.ray.dir_x[k] = ray[3], packet.ray.dir_y[k] = ray[4], packet.ray.dir_z[k] = ray[5];
      packet.ray.tnear[k] = packet.ray.time[k] = 0.0f;
      packet.ray.tfar[k] = INFINITY;
      packet.ray.mask[k] = ~0u;
      packet.ray.id[k] = packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(valid, scene_, &context, &packet);
    for (std::size_t i = begin; i < end; ++i) {
      const bool found = packet.hit.geomID[i - begin] != RTC_INVALID_GEOMETRY_ID;
      hits.faces[i] = found ? packet.hit.primID[i - begin] : mesh_map::NO_INDEX;
      hits.distances[i] = packet.ray.tfar[i - begin];
    }
  }

  static bool count(void* bytes, ssize_t change, bool)
  {
    *static_cast<std::atomic<std::int64_t>*>(bytes) += change;
    return true;
  }

  const std::vector<float>& vertices_;
  const std::vector<std::uint32_t>& faces_;
  std::atomic<std::int64_t> bytes_{0};
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  RTCGeometry geometry_ = nullptr;
};

#endif  // MESH_TOOLS_TEST_EMBREE_SCENE_H
