#include "picking/surface_paths.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <mesh_map/distance/fast_marching/fast_marching.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>
#include <mesh_map/mesh/topology.h>
#include <mesh_map/paths/field_trace.h>
#include <mesh_map/paths/geodesic.h>

#include "base/vectors.h"
#include "selection/face_neighbors.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// A mesh as fronts and paths want it.
struct Surface
{
  explicit Surface(const MeshData& mesh)
      : positions(positionsOf(mesh)),
        faces(joinedCorners(mesh)),
        topology(mesh_map::buildTopology(faces, mesh.vertexCount()))
  {
  }

  mesh_map::MeshView view() const { return {positions, faces}; }
  mesh_map::RowsView vertexFaces() const
  {
    return {topology.vertex_face_offsets, topology.vertex_faces};
  }
  std::uint32_t corner(std::uint32_t face, std::size_t corner) const
  {
    return faces.at(3 * std::size_t{face} + corner);
  }
  std::vector<float> positions;
  std::vector<std::uint32_t> faces;  ///< vertices in the same place are one
  mesh_map::Topology topology;
};

/// Down a front from `from`, so the way begins at `to`. False where the front does not come there.
bool follow(const MeshData& mesh, const Surface& surface, const SurfacePoint& from,
            const SurfacePoint& to, const std::atomic<bool>* cancel, mesh_map::FieldPath& path)
{
  std::vector<mesh_map::FastMarchingSeed> seeds;
  std::vector<std::uint32_t> targets;
  mesh_map::FastMarchingStop stop;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t start = surface.corner(from.face, i);
    seeds.push_back({start, distance(cornerOf(mesh, from.face, i), from.position)});
    targets.push_back(surface.corner(to.face, i));
    // So that the field is known all around the end.
    stop.offset = std::max(stop.offset, 2.0 * distance(cornerOf(mesh, to.face, i), to.position));
  }
  stop.targets = targets;
  stop.cancel = cancel;
  auto front_mesh =
      std::make_shared<const mesh_map::FastMarchingMesh>(surface.view(), surface.vertexFaces());
  throwIfCanceled(cancel);
  mesh_map::FastMarchingField front(std::make_shared<mesh_map::FastMarchingPool>(front_mesh), seeds,
                                    {});
  if (!front.extend({}, stop)) {
    throw Canceled();
  }
  const auto end =
      mesh_map::tracePath({surface.view(), surface.vertexFaces(), surface.topology.face_flags},
                          {front.labels(), front.limit(), {}, from.face, from.position}, to.face,
                          to.position, cancel, path);
  throwIfCanceled(cancel);
  return end == mesh_map::TraceEnd::ARRIVED;
}

/// The same way from its other end.
mesh_map::WalkTrace reversed(const mesh_map::FieldPath& path)
{
  mesh_map::WalkTrace trace;
  for (std::size_t i = path.points.size(); i > 0; i -= 3) {
    trace.points.insert(trace.points.end(), &path.points[i - 3], &path.points[i - 3] + 3);
  }
  trace.faces.assign(path.faces.rbegin(), path.faces.rend());
  return trace;
}

}  // namespace

SurfacePath findPath(const MeshData& mesh, const SurfacePoint& from, const SurfacePoint& to,
                     const std::atomic<bool>* cancel)
{
  SurfacePath way;
  throwIfCanceled(cancel);
  const Surface surface(mesh);
  throwIfCanceled(cancel);
  mesh_map::FieldPath path;
  if (!follow(mesh, surface, from, to, cancel, path)) {
    return way;
  }
  const mesh_map::Topology& topology = surface.topology;
  const auto edge_faces = mesh_map::edgeFaces(topology.face_edges, topology.edgeCount());
  mesh_map::GeodesicOptions options;
  options.cancel = cancel;
  mesh_map::Geodesic geodesic =
      mesh_map::shortenPath({surface.view(),
                             topology.face_edges,
                             topology.face_flags,
                             edge_faces.rows(),
                             {topology.vertex_face_offsets, topology.vertex_faces}},
                            reversed(path), options);
  if (geodesic.canceled) {
    throw Canceled();
  }
  way.connected = true;
  way.length = geodesic.length;
  way.points = std::move(geodesic.path.points);
  return way;
}

}  // namespace rviz_mesh_plugin
