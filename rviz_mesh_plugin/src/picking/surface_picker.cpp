#include "picking/surface_picker.h"

#include <algorithm>
#include <exception>
#include <limits>

#include <OgreMath.h>
#include <OgreRay.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>

#include "base/vectors.h"
#include "displays/display_tree.h"
#include "displays/textured_mesh_display.h"
#include "mesh_view/selectable_faces.h"
#include "picking/surface_index.h"
#include "rendering/ogre/finite_bounds.h"

namespace rviz_mesh_plugin {
namespace {

constexpr double INF = std::numeric_limits<double>::infinity();

/// Where a ray enters the box around a mesh; infinite where it does not.
double distanceToBox(const mesh_map::Ray& ray, const MeshData& mesh)
{
  const Ogre::Ray ogre_ray(ogreVector(ray.origin), ogreVector(ray.direction));
  const auto hit = Ogre::Math::intersects(ogre_ray, finiteBounds(mesh));
  return hit.first ? hit.second : INF;
}

SurfaceIndex::State stateOf(const MeshDataConstPtr& mesh)
{
  SurfaceIndex::State state;
  try {
    state = SurfaceIndex::instance().find(mesh);
  } catch (const std::exception& error) {  // no memory, no thread
    state.failure = error.what();
  }
  return state;
}

SurfaceHit describe(const ShownMesh& mesh, const std::shared_ptr<const SpatialQueries>& queries,
                    const mesh_map::RayHit& found)
{
  SurfaceHit hit;
  static_cast<ShownMesh&>(hit) = mesh;
  hit.queries = queries;
  hit.face = found.face;
  hit.barycentric = found.barycentric;
  hit.distance = found.distance;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (unsigned corner = 0; corner < 3; ++corner) {
    point += found.barycentric[corner] * vectorOf(cornerOf(*mesh.mesh, found.face, corner));
  }
  hit.point = arrayOf(point);
  hit.normal = arrayOf(normalOf(*mesh.mesh, found.face).normalized());
  return hit;
}

std::string whyNotReady(const ShownMesh& mesh, const SurfaceIndex::State& state)
{
  if (!state.failure.empty()) {
    return "the mesh of '" + mesh.display + "' cannot be clicked at: " + state.failure;
  }
  const int percent = static_cast<int>(100.0f * state.progress);
  return "the mesh of '" + mesh.display + "' is being prepared (" + std::to_string(percent) +
         " %): try again in a moment";
}

}  // namespace

SurfacePicker::SurfacePicker(rviz::DisplayContext* context)
    : context_(context), user_(SurfaceIndex::instance().user())
{
}

std::vector<ShownMesh> SurfacePicker::meshes() const
{
  std::vector<ShownMesh> meshes;
  visitDisplays<TexturedMeshDisplay>(context_->getRootDisplayGroup(), DisplayChoice::ALL,
                                     [&](const TexturedMeshDisplay& display) {
                                       const auto shown = display.shownMeshes();
                                       meshes.insert(meshes.end(), shown.begin(), shown.end());
                                     });
  return meshes;
}

bool SurfacePicker::exists(const MeshDataConstPtr& mesh) const
{
  bool found = false;
  visitDisplays<TexturedMeshDisplay>(
      context_->getRootDisplayGroup(), DisplayChoice::ALL,
      [&](const TexturedMeshDisplay& display) { found = found || display.has(mesh); });
  return found;
}

SurfacePicker::Search SurfacePicker::search(const std::string& uuid) const
{
  Search found;
  visitDisplays<TexturedMeshDisplay>(context_->getRootDisplayGroup(), DisplayChoice::ALL,
                                     [&](const TexturedMeshDisplay& display) {
                                       const MeshDataConstPtr mesh = display.drawn(uuid);
                                       if (mesh) {
                                         found.meshes.push_back(mesh);
                                       }
                                       found.others_expected |= display.mesh() == nullptr;
                                     });
  return found;
}

void SurfacePicker::prepare() const
{
  for (const ShownMesh& mesh : meshes()) {
    stateOf(mesh.mesh);
  }
}

Pick SurfacePicker::pick(const mesh_map::Ray& ray, bool back_faces) const
{
  mesh_map::RayOptions options;
  options.back_faces = back_faces;
  const std::vector<ShownMesh> shown = meshes();
  Pick result;
  double hidden_from = INF;  // by meshes that cannot answer yet
  std::string why_hidden, failure;
  for (const ShownMesh& mesh : shown) {
    mesh_map::Ray local = rayInMesh(ray, mesh);
    const auto seen = rayInSection(local.origin, local.direction, local.max_distance, mesh.section);
    if (!seen) {
      continue;
    }
    local.origin = seen->origin;
    local.max_distance = seen->max_distance;
    const SurfaceIndex::State state = stateOf(mesh.mesh);
    if (!state.queries) {
      const double distance = seen->skipped + distanceToBox(local, *mesh.mesh);
      if (!state.failure.empty()) {
        failure = distance < INF ? whyNotReady(mesh, state) : failure;
      } else if (distance < hidden_from) {
        hidden_from = distance;
        why_hidden = whyNotReady(mesh, state);
      }
      continue;
    }
    options.mask = mesh.hidden ? mesh.hidden->mask() : mesh_map::ArrayView<std::uint8_t>();
    mesh_map::RayHit found = state.queries->castRay(local, options);
    found.distance += seen->skipped;
    if (found.face != mesh_map::NO_INDEX &&
        (!result.hit || found.distance < result.hit->distance)) {
      result.hit = describe(mesh, state.queries, found);
    }
  }
  if (hidden_from < (result.hit ? result.hit->distance : INF)) {
    result.hit.reset();
    result.reason = why_hidden;
  } else if (shown.empty()) {
    result.reason =
        "no mesh is shown: add and enable a TexturedMesh or Map3D display, and look at its status";
  } else if (!result.hit) {
    const bool hides = std::any_of(shown.begin(), shown.end(),
                                   [](const ShownMesh& mesh) { return mesh.hidden != nullptr; });
    result.reason = !failure.empty() ? std::move(failure)
                    : hides ? "no surface under the cursor but perhaps hidden faces: Ctrl+H "
                              "with the tool ClusterLabel shows them"
                            : "no surface under the cursor: point at a mesh";
  }
  return result;
}

}  // namespace rviz_mesh_plugin
