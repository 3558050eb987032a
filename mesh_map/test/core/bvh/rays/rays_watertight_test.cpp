#include <mesh_map/bvh/tree/bvh.h>

#include "ray_checks.h"
#include "ray_samples.h"

using mesh_map::Bvh;
using mesh_map::castRay;
using mesh_map::NO_INDEX;
using mesh_map::Ray;
using mesh_map::RayHit;
using mesh_map::RayOptions;

namespace {

/// The cube, blown up to a ball about 0.
TestMesh ball(unsigned cells)
{
  TestMesh mesh = cube(cells);
  mesh.name = "ball " + std::to_string(cells);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    float* const p = mesh.positions.data() + i;
    const float v[3] = {p[0] - 0.5f, p[1] - 0.5f, p[2] - 0.5f};
    const float length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    std::transform(v, v + 3, p, [length](float coordinate) { return coordinate / length; });
  }
  return mesh;
}

TestMesh moved(TestMesh mesh, float scale, const std::array<float, 3>& by)
{
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] = mesh.positions[i] * scale + by[i % 3];
  }
  return mesh;
}

TEST(Watertight, a_ray_from_inside_a_closed_mesh_always_hits_it_from_behind_only)
{
  RayOptions front;
  front.back_faces = false;
  for (const auto& place : {std::array<float, 3>{0, 0, 0}, {148376, 1234, -223423}, {1e6, 0, 0}}) {
    const bool far = place[0] != 0.0f;
    for (const TestMesh& mesh :
         {moved(cube(4), far ? 100.0f : 1.0f, place), moved(ball(9), far ? 100.0f : 1.0f, place)}) {
      const Bvh bvh = Bvh::build(mesh.view());
      RaySamples samples(mesh);
      const Point center = samples.center();
      std::vector<Ray> rays;
      for (std::size_t i = 0; i < 4000; ++i) {
        Point eye = samples.point(0.5);
        if (i % 4 == 0) {  // rounded to floats, so that rays may run in the planes of edges
          std::transform(eye.begin(), eye.end(), eye.begin(),
                         [](double v) { return static_cast<double>(static_cast<float>(v)); });
        } else if (i % 4 == 1) {
          eye = center;
        }
        const std::size_t kind = i / 4 % 4;
        rays.push_back(kind == 0   ? Ray{eye, samples.direction()}
                       : kind == 1 ? rayTo(eye, samples.vertex())
                       : kind == 2 ? rayTo(eye, samples.edgePoint())
                                   : rayTo(eye, samples.surfacePoint()));
        if (i % 16 == 1) {
          rays.back().direction = {0.0, 0.0, 0.0};
          rays.back().direction[i / 16 % 3] = i % 32 == 1 ? 1.0 : -1.0;
        }
      }
      const RayArrays arrays(rays);
      const mesh_map::RayHits hits = mesh_map::castRays(bvh, arrays.batch());
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_NE(castRay(bvh, rays[i]).face, NO_INDEX) << mesh.name << ": " << describe(rays[i]);
        ASSERT_NE(hits.faces[i], NO_INDEX) << mesh.name << ": " << describe(rays[i]);
        ASSERT_EQ(castRay(bvh, rays[i], front).face, NO_INDEX)
            << mesh.name << ": " << describe(rays[i]);
      }
    }
  }
}

TEST(Watertight, a_ray_from_above_never_gets_through_a_terrain)
{
  for (const float offset : {0.0f, 1000.0f, 1e6f}) {
    const TestMesh mesh = terrain(40, offset == 0.0f ? 10.0f : 1000.0f, offset);
    const Bvh bvh = Bvh::build(mesh.view());
    RaySamples samples(mesh);
    for (std::size_t i = 0; i < 6000; ++i) {
      Point target = i % 3 == 0   ? samples.vertex()
                     : i % 3 == 1 ? samples.edgePoint()
                                  : samples.surfacePoint();
      // Inside the border, where else a ray may pass by a rounding.
      const Point center = samples.center();
      const double half = 0.49 * (offset == 0.0f ? 10.0 : 1000.0);
      if (std::abs(target[0] - center[0]) > half || std::abs(target[1] - center[1]) > half) {
        continue;
      }
      Point eye = target;
      eye[2] += samples.size();
      if (i % 2 == 0) {
        eye[0] += 0.3 * (samples.point()[0] - center[0]);
        eye[1] += 0.3 * (samples.point()[1] - center[1]);
      }
      const Ray ray = rayTo(eye, target);
      ASSERT_NE(castRay(bvh, ray).face, NO_INDEX) << mesh.name << ": " << describe(ray);
    }
  }
}

TEST(Watertight, shared_edges_are_seen_alike_from_both_sides)
{
  // Two triangles on either side of an edge: whatever is rounded, a ray through it hits one.
  const TestMesh mesh = cube(1);
  RaySamples samples(mesh);
  for (std::size_t i = 0; i < 20000; ++i) {
    std::vector<float> p;
    for (std::size_t k = 0; k < 12; ++k) {
      p.push_back(static_cast<float>(samples.number(-1, 1) + (k % 3 == 0 ? k / 6 * 3.0 : 0.0)));
    }
    // a and b, the edge, lie between c and d, with x from 0 to 3.
    const float edge[] = {p[3] * 0.5f + 1.5f, p[4], -2.0f, p[6] * 0.1f + 1.5f, p[7], 2.0f};
    const float left[] = {edge[0], edge[1], edge[2], edge[3], edge[4], edge[5], -9, p[1], p[2]};
    const float right[] = {edge[3], edge[4], edge[5], edge[0], edge[1], edge[2], 9, p[10], p[11]};
    const double weight = samples.number(0.2, 0.8);
    const Point on = between({edge[0], edge[1], edge[2]}, {edge[3], edge[4], edge[5]}, weight);
    const Ray ray = rayTo({on[0] + samples.number(-1, 1), 50.0, samples.number(-2, 2)}, on);
    const mesh_map::RayTest test(ray);
    EXPECT_TRUE(hitOf(test, left).face == 0 || hitOf(test, right).face == 0) << describe(ray);
  }
}

}  // namespace
