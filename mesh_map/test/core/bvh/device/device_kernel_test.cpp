// What the kernels of kernels/bvh.cl answer, on the first OpenCL device there is, is what the
// native queries answer, bit by bit.
#include <gtest/gtest.h>

#include "test_queries.h"

#ifdef MESH_MAP_TEST_OPENCL
#include "test_device.h"

#include <algorithm>
#include <cstring>

using namespace mesh_map;

namespace {

#define DEVICE_OR_SKIP(device)                                            \
  const auto device = TestDevice::get();                                  \
  if (!device) {                                                          \
    GTEST_SKIP() << "there is no OpenCL device: install pocl-opencl-icd"; \
  }

/// Bit by bit, NaN too.
template <class T>
::testing::AssertionResult same(const std::vector<T>& a, const std::vector<T>& b, std::size_t width)
{
  if (a.size() != b.size()) {
    return ::testing::AssertionFailure() << a.size() << " numbers instead of " << b.size();
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(T)) != 0) {
      return ::testing::AssertionFailure()
             << "query " << i / width << ": " << a[i] << " instead of " << b[i];
    }
  }
  return ::testing::AssertionSuccess();
}

void expectSame(const RayHits& a, const RayHits& b)
{
  EXPECT_TRUE(same(a.faces, b.faces, 1));
  EXPECT_TRUE(same(a.distances, b.distances, 1));
  EXPECT_TRUE(same(a.barycentric, b.barycentric, 3));
}

void expectSame(const SurfaceHits& a, const SurfaceHits& b)
{
  EXPECT_TRUE(same(a.faces, b.faces, 1));
  EXPECT_TRUE(same(a.distances, b.distances, 1));
  EXPECT_TRUE(same(a.positions, b.positions, 3));
  EXPECT_TRUE(same(a.barycentric, b.barycentric, 3));
}

/// The share of queries whose first of `width` answers is this one.
template <class T>
double share(const std::vector<T>& answers, std::size_t width, T answer)
{
  std::size_t count = 0;
  for (std::size_t i = 0; i < answers.size(); i += width) {
    count += answers[i] == answer ? 1 : 0;
  }
  return static_cast<double>(count * width) / static_cast<double>(answers.size());
}

}  // namespace

TEST(DeviceKernel, RaysEqualNativeOnes)
{
  DEVICE_OR_SKIP(device);
  for (const TestMesh& mesh : testMeshes()) {
    SCOPED_TRACE(mesh.name);
    const Bvh bvh = Bvh::build(mesh.view());
    const DeviceMesh on_device(device, bvh);
    const TestQueries queries(mesh, 100);
    const RayBatch rays{queries.origins, queries.directions, queries.max_distances};
    for (unsigned i = 0; i < 4; ++i) {
      RayOptions options;
      options.back_faces = i % 2 == 0;
      options.mask = i / 2 == 0 ? ArrayView<std::uint8_t>() : queries.mask;
      expectSame(finishRays(bvh, rays, options, on_device.castRays(rays, options)),
                 castRays(bvh, rays, options));
      EXPECT_TRUE(same(finishRaysAny(bvh, rays, options, on_device.castRays(rays, options, true)),
                       raysHitAny(bvh, rays, options), 1));
    }
  }
}

TEST(DeviceKernel, PointsEqualNativeOnes)
{
  DEVICE_OR_SKIP(device);
  for (const TestMesh& mesh : testMeshes()) {
    SCOPED_TRACE(mesh.name);
    const Bvh bvh = Bvh::build(mesh.view());
    const DeviceMesh on_device(device, bvh);
    const TestQueries queries(mesh, 60);
    for (double max_distance :
         {std::numeric_limits<double>::infinity(), 0.3, 0.0, -1.0, std::nan("")}) {
      ClosestOptions options;
      options.max_distance = max_distance;
      options.mask = max_distance == 0.3 ? queries.mask : ArrayView<std::uint8_t>();
      expectSame(finishPoints(bvh, queries.points, options,
                              on_device.closestPoints(queries.points, options)),
                 closestPoints(bvh, queries.points, options));
    }
  }
}

TEST(DeviceKernel, SelectionsEqualNativeOnes)
{
  DEVICE_OR_SKIP(device);
  for (const TestMesh& mesh : testMeshes()) {
    SCOPED_TRACE(mesh.name);
    const Bvh bvh = Bvh::build(mesh.view());
    const DeviceMesh on_device(device, bvh);
    const TestQueries queries(mesh, 1);
    std::vector<const Region*> regions;
    for (const SphereRegion& sphere : queries.spheres) {
      regions.push_back(&sphere);
    }
    for (const ConvexRegion& convex : queries.convexes) {
      regions.push_back(&convex);
    }
    for (std::size_t i = 0; i < regions.size(); ++i) {
      SCOPED_TRACE(i);
      const std::vector<std::uint8_t> verdicts = on_device.select(*regions[i]);
      for (const SelectionMode mode : {SelectionMode::TOUCHING, SelectionMode::INSIDE}) {
        const ArrayView<std::uint8_t> mask = i % 2 == 0 ? ArrayView<std::uint8_t>() : queries.mask;
        EXPECT_EQ(finishSelection(bvh, *regions[i], mode, mask, verdicts),
                  selectFaces(bvh, *regions[i], mode, mask));
      }
    }
  }
}

/// Products neither grow beyond floats nor vanish below them.
TEST(DeviceKernel, MeshesOfAnySizeEqualNativeOnes)
{
  DEVICE_OR_SKIP(device);
  const auto flushing = device->withoutDenormals();
  for (const TestMesh& unit : {terrain(5, 1.0f), cube(4), soup(300), withGiant(soup(300))}) {
    for (float scale = 1e-9f; scale < 1e17f; scale *= 4.7f) {
      TestMesh mesh = unit;
      for (float& x : mesh.positions) {
        x *= scale;
      }
      SCOPED_TRACE(mesh.name + ", times " + std::to_string(scale));
      std::mt19937 random(4);
      std::uniform_real_distribution<double> place(-1.0, 2.0);
      std::vector<double> points, directions;
      for (unsigned i = 0; i < 300; ++i) {
        const double height = i % 2 == 0 ? place(random) : 0.002 * place(random);
        points.insert(points.end(), {scale * place(random), scale * place(random), scale * height});
        directions.insert(directions.end(), {place(random), place(random), place(random) - 2.0});
      }
      const Bvh bvh = Bvh::build(mesh.view());
      const RayBatch rays{points, directions, {}};
      const RayHits hits = castRays(bvh, rays);
      const SurfaceHits closest = closestPoints(bvh, points);
      for (const auto& which : {device, flushing}) {
        const DeviceMesh on_device(which, bvh);
        expectSame(finishRays(bvh, rays, {}, on_device.castRays(rays, {})), hits);
        expectSame(finishPoints(bvh, points, {}, on_device.closestPoints(points, {})), closest);
      }
    }
  }
}

/// The kernels do the work: on ordinary meshes hardly anything is left to the host.
TEST(DeviceKernel, DoubtsAreRare)
{
  DEVICE_OR_SKIP(device);
  for (const float offset : {0.0f, 1000.0f}) {
    const TestMesh mesh = terrain(200, 100.0f, offset);
    const Bvh bvh = Bvh::build(mesh.view());
    const DeviceMesh on_device(device, bvh);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(offset, offset + 100.0), tilt(-1.0, 1.0);
    std::vector<double> origins, directions;
    for (unsigned i = 0; i < 20000; ++i) {
      origins.insert(origins.end(), {place(random), place(random), offset + 30.0});
      directions.insert(directions.end(), {tilt(random), tilt(random), -1.0});
    }
    EXPECT_LT(
        share(on_device.castRays({origins, directions, {}}, {}), DEVICE_RAY_ANSWERS, DEVICE_DOUBT),
        0.001);
    std::vector<double> points;
    const RayHits hits = castRays(bvh, {origins, directions, {}});
    for (std::size_t i = 0; i < hits.faces.size(); ++i) {
      if (hits.faces[i] != NO_INDEX) {  // 0.2 m in front of the surface
        for (std::size_t k = 0; k < 3; ++k) {
          const double length = std::sqrt(directions[3 * i] * directions[3 * i] +
                                          directions[3 * i + 1] * directions[3 * i + 1] + 1.0);
          points.push_back(origins[3 * i + k] +
                           directions[3 * i + k] / length * (hits.distances[i] - 0.2));
        }
      }
    }
    EXPECT_LT(share(on_device.closestPoints(points, {}), DEVICE_CANDIDATES, DEVICE_DOUBT), 0.01);
    const SphereRegion sphere({offset + 50.0, offset + 50.0, offset + 0.0}, 30.0);
    EXPECT_LT(share(on_device.select(sphere), 1, DEVICE_UNSURE), 0.001);
    const auto box = ConvexRegion::box({offset + 50.0, offset + 50.0, offset + 0.0},
                                       {{{0.6, 0.8, 0.0}, {-0.8, 0.6, 0.0}, {0.0, 0.0, 1.0}}},
                                       {20.0, 10.0, 3.0});
    EXPECT_LT(share(on_device.select(box), 1, DEVICE_UNSURE), 0.002);
  }
}

#else

TEST(DeviceKernel, EqualsNative)
{
  GTEST_SKIP() << "built without OpenCL: install ocl-icd-opencl-dev and opencl-clhpp-headers";
}

#endif
