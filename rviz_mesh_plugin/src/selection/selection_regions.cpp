#include "selection/selection_regions.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

#include <OgreCamera.h>
#include <OgreViewport.h>

#include "base/erase_if.h"
#include "base/vectors.h"
#include "mesh_view/selectable_faces.h"

namespace rviz_mesh_plugin {
namespace {

/// Takes out the faces that are seen from behind (they are counterclockwise from the front), and
/// those seen edge-on.
void dropBackFaces(const MeshData& mesh, const std::array<double, 3>& eye,
                   FaceSelection::Faces& faces)
{
  const auto is_back = [&](std::uint32_t face) {
    const Eigen::Vector3d towards = vectorOf(eye) - vectorOf(cornerOf(mesh, face, 0));
    return !(normalOf(mesh, face).dot(towards) > 0.0);
  };
  eraseIf(faces, is_back);
}

/// Rays that have met hidden faces go on to what is not hidden: these alone natively, which knows
/// of masks.
void castBehindHidden(const mesh_map::RayBatch& rays, const HiddenFaces& hidden,
                      const SpatialQueries& queries, const mesh_map::BvhOptions& run,
                      mesh_map::RayHits& hits)
{
  std::vector<std::size_t> again;
  std::vector<double> origins, directions, distances;
  for (std::size_t i = 0; i < hits.faces.size(); ++i) {
    if (hidden.contains(hits.faces[i])) {
      const mesh_map::Ray ray = rays[i];
      again.push_back(i);
      origins.insert(origins.end(), ray.origin.begin(), ray.origin.end());
      directions.insert(directions.end(), ray.direction.begin(), ray.direction.end());
      distances.push_back(ray.max_distance);
    }
  }
  mesh_map::RayOptions options;
  options.mask = hidden.mask();
  const mesh_map::RayHits behind =
      mesh_map::castRays(queries.bvh(), {origins, directions, distances}, options, run);
  for (std::size_t i = 0; i < again.size(); ++i) {
    hits.set(again[i], {behind.faces[i],
                        behind.distances[i],
                        {behind.barycentric[3 * i], behind.barycentric[3 * i + 1],
                         behind.barycentric[3 * i + 2]}});
  }
}

/// Rays meet only what is in the section, and not hidden. @return the faces that they meet;
/// distances are less by what is before the section
mesh_map::RayHits castAtShown(const mesh_map::RayBatch& rays, const ShownMesh& shown,
                              const SpatialQueries& queries, const mesh_map::BvhOptions& run)
{
  std::vector<double> origins, directions, distances;
  origins.reserve(3 * rays.size());
  directions.reserve(3 * rays.size());
  distances.reserve(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    mesh_map::Ray ray = rays[i];
    const Eigen::Vector3d way = vectorOf(ray.direction);
    const double length = way.norm();
    const auto direction = arrayOf(length > 0.0 ? Eigen::Vector3d(way / length) : way);
    const auto seen = ray.max_distance < 0.0
                          ? std::nullopt
                          : rayInSection(ray.origin, direction, ray.max_distance, shown.section);
    const std::array<double, 3>& origin = seen ? seen->origin : ray.origin;
    origins.insert(origins.end(), origin.begin(), origin.end());
    directions.insert(directions.end(), direction.begin(), direction.end());
    distances.push_back(seen ? seen->max_distance : -1.0);
  }
  mesh_map::RayHits hits = queries.castRays({origins, directions, distances}, run);
  if (shown.hidden) {
    castBehindHidden({origins, directions, distances}, *shown.hidden, queries, run, hits);
  }
  return hits;
}

}  // namespace

PicturePoint pointOf(const std::array<double, 2>& pixels, const Ogre::Viewport& viewport)
{
  return {2.0 * (pixels[0] - viewport.getActualLeft()) / viewport.getActualWidth() - 1.0,
          1.0 - 2.0 * (pixels[1] - viewport.getActualTop()) / viewport.getActualHeight()};
}

PicturePoint pointOf(const Pixel& pixel, const Ogre::Viewport& viewport)
{
  return pointOf(std::array<double, 2>{pixel.x + 0.5, pixel.y + 0.5}, viewport);
}

std::vector<PicturePoint> pointsOf(const std::vector<Pixel>& pixels, const Ogre::Viewport& viewport)
{
  std::vector<PicturePoint> points;
  points.reserve(pixels.size());
  for (const Pixel& pixel : pixels) {
    points.push_back(pointOf(pixel, viewport));
  }
  return points;
}

mesh_map::ConvexRegion boxRegion(const PicturePoint& corner, const PicturePoint& opposite,
                                 const std::array<double, 16>& mesh_to_clip)
{
  // Of clip coordinates: sign * row + limit * w >= 0.
  const auto plane = [&](unsigned row, double sign, double limit) {
    mesh_map::Plane plane;
    for (unsigned i = 0; i < 4; ++i) {
      plane[i] = sign * mesh_to_clip[4 * row + i] + limit * mesh_to_clip[12 + i];
    }
    return plane;
  };
  std::vector<mesh_map::Plane> planes;
  for (unsigned row = 0; row < 2; ++row) {
    planes.push_back(plane(row, 1.0, -std::min(corner[row], opposite[row])));
    planes.push_back(plane(row, -1.0, std::max(corner[row], opposite[row])));
  }
  planes.push_back(plane(2, 1.0, 1.0));
  planes.push_back(plane(2, -1.0, 1.0));
  return mesh_map::ConvexRegion(planes);
}

double pixelsOf(double length, double distance, const Ogre::Viewport& viewport)
{
  const Ogre::Matrix4& projection = viewport.getCamera()->getProjectionMatrix();
  const bool parallel = projection[3][3] != 0.0f;
  return length * projection[1][1] * 0.5 * viewport.getActualHeight() / (parallel ? 1.0 : distance);
}

double faceArea(const MeshData& mesh, std::uint32_t face)
{
  return 0.5 * normalOf(mesh, face).norm();
}

std::size_t FaceSearch::most() const
{
  std::size_t most = 0;
  for (const auto& region : regions) {
    if (visible_only || dynamic_cast<const mesh_map::LassoRegion*>(region.get())) {
      return std::numeric_limits<std::size_t>::max();
    }
    most += queries->mostFaces(*region);
  }
  return most;
}

FaceSelection::Faces FaceSearch::facesIn(const mesh_map::Region& region,
                                         const std::atomic<bool>* cancel) const
{
  mesh_map::BvhOptions run;
  run.cancel = cancel;
  const SelectableFaces selectable(shown);
  if (!selectable.all()) {
    return selectableFacesIn(region, selectable, run);
  }
  return seenIn(region, queries->selectFaces(region, run), cancel);
}

/// Of faces that touch the region, where all may be selected.
FaceSelection::Faces FaceSearch::seenIn(const mesh_map::Region& region, FaceSelection::Faces faces,
                                        const std::atomic<bool>* cancel) const
{
  mesh_map::BvhOptions run;
  run.cancel = cancel;
  if (!back_faces) {
    dropBackFaces(*shown.mesh, eye, faces);
  }
  return visible_only ? queries->seenFaces(region, faces, eye, run) : faces;
}

/// The same where not all is shown: what is not hides nothing.
FaceSelection::Faces FaceSearch::selectableFacesIn(const mesh_map::Region& region,
                                                   const SelectableFaces& selectable,
                                                   const mesh_map::BvhOptions& run) const
{
  const auto part = selectable.seenPart(region);
  if (!part) {
    return {};
  }
  const bool convex = dynamic_cast<const mesh_map::ConvexRegion*>(&region) != nullptr;
  const mesh_map::Region& looked_at = convex ? *part : region;
  auto faces = queries->selectFaces(looked_at, run);
  selectable.keep(faces, run.cancel);
  if (!back_faces) {
    dropBackFaces(*shown.mesh, eye, faces);
  }
  if (!visible_only) {
    return faces;
  }
  return mesh_map::seenFaces(
      queries->bvh(), selectable.cut() ? *part : looked_at, faces, eye,
      [&](const mesh_map::RayBatch& rays) { return castAtShown(rays, shown, *queries, run); });
}

FaceSelection::Faces FaceSearch::chosenOf(FaceSelection::Faces faces,
                                          const std::atomic<bool>* cancel) const
{
  const SelectableFaces selectable(shown);
  if (!visible_only) {
    selectable.keep(faces, cancel);
    if (!back_faces) {
      dropBackFaces(*shown.mesh, eye, faces);
    }
    return faces;
  }
  mesh_map::BvhOptions run;
  run.cancel = cancel;
  FaceSelection::Faces chosen;
  for (const auto& region : regions) {
    const auto there = selectable.all() ? queries->selectFaces(*region, run)
                                        : selectableFacesIn(*region, selectable, run);
    FaceSelection::Faces both;
    std::set_intersection(there.begin(), there.end(), faces.begin(), faces.end(),
                          std::back_inserter(both));
    const auto seen = selectable.all() ? seenIn(*region, std::move(both), cancel) : std::move(both);
    chosen.insert(chosen.end(), seen.begin(), seen.end());
  }
  return chosen;
}

FaceSelection::Faces FaceSearch::operator()(const std::atomic<bool>* cancel) const
{
  FaceSelection::Faces all;
  for (const auto& region : regions) {
    auto faces = facesIn(*region, cancel);
    if (all.empty()) {
      all = std::move(faces);
    } else {
      all.insert(all.end(), faces.begin(), faces.end());
    }
  }
  return all;
}

FaceBits FaceSearch::bits(const std::atomic<bool>* cancel) const
{
  FaceBits all(shown.mesh->faceCount());
  for (const auto& region : regions) {
    all.add(facesIn(*region, cancel));
  }
  return all;
}

}  // namespace rviz_mesh_plugin
