#include "device_check.h"

#include <mesh_map/bvh_closest.h>
#include <mesh_map/bvh_rays.h>
#include <mesh_map/bvh_selection.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "device_queries.h"

namespace rviz_mesh_plugin {

namespace {

constexpr unsigned CELLS = 16;  // per side

/// A wavy square from 0 to CELLS.
mesh_map::Bvh smallMesh()
{
  std::vector<float> positions;
  std::vector<std::uint32_t> faces;
  for (unsigned i = 0; i <= CELLS; ++i) {
    for (unsigned j = 0; j <= CELLS; ++j) {
      const float x = static_cast<float>(i), y = static_cast<float>(j);
      positions.insert(positions.end(), {x, y, std::sin(0.7f * x) * std::cos(0.5f * y)});
      if (i < CELLS && j < CELLS) {
        const unsigned a = i * (CELLS + 1) + j, b = a + CELLS + 1;
        faces.insert(faces.end(), {a, b, a + 1, a + 1, b, b + 1});
      }
    }
  }
  return mesh_map::Bvh::build({positions, faces});
}

void expect(bool same, const char* what)
{
  if (!same) {
    throw std::runtime_error(std::string("the device computes ") + what + " wrongly");
  }
}

bool operator==(const mesh_map::RayHits& a, const mesh_map::RayHits& b)
{
  return a.faces == b.faces && a.distances == b.distances && a.barycentric == b.barycentric;
}

bool operator==(const mesh_map::SurfaceHits& a, const mesh_map::SurfaceHits& b)
{
  return a.faces == b.faces && a.distances == b.distances && a.positions == b.positions &&
         a.barycentric == b.barycentric;
}

}  // namespace

void checkDevice(const std::shared_ptr<const OpenClProgram>& program,
                 const std::function<void()>& go_on)
{
  const mesh_map::Bvh bvh = smallMesh();
  const DeviceQueries device(program, bvh);
  std::vector<double> points, directions;
  for (unsigned i = 0; i < 300; ++i) {  // the last fifth beside the mesh
    points.insert(points.end(), {0.07 * i, 0.05 * (i * 37 % 300), 3.0});
    directions.insert(directions.end(), {0.3, -0.2, -1.0});
  }
  const mesh_map::RayBatch rays{points, directions, {}};
  mesh_map::RayHits hits;
  device.castRays(rays, {}, {}, hits);
  expect(hits == mesh_map::castRays(bvh, rays), "rays");

  go_on();
  std::vector<std::uint8_t> any;
  device.raysHitAny(rays, {}, {}, any);
  expect(any == mesh_map::raysHitAny(bvh, rays), "rays");

  go_on();
  mesh_map::SurfaceHits closest;
  device.closestPoints(points, {}, {}, closest);
  expect(closest == mesh_map::closestPoints(bvh, points), "closest points");

  const mesh_map::SphereRegion sphere({5.0, 6.0, 0.0}, 3.0);
  const auto box = mesh_map::ConvexRegion::box(
      {8.0, 8.0, 0.0}, {{{0.8, 0.6, 0.0}, {-0.6, 0.8, 0.0}, {0.0, 0.0, 1.0}}}, {5.0, 3.0, 0.5});
  for (const mesh_map::Region* region : {static_cast<const mesh_map::Region*>(&sphere),
                                         static_cast<const mesh_map::Region*>(&box)}) {
    go_on();
    for (const auto mode : {mesh_map::SelectionMode::TOUCHING, mesh_map::SelectionMode::INSIDE}) {
      expect(device.selectFaces(*region, mesh_map::selectionRoots(bvh, *region), mode, {}, {}) ==
                 mesh_map::selectFaces(bvh, *region, mode),
             "selections");
    }
  }
}

}  // namespace rviz_mesh_plugin
