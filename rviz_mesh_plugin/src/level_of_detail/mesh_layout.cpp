#include "level_of_detail/mesh_layout.h"

#include <mesh_map/base/parallel.h>

#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "level_of_detail/layout_parts.h"
#include "level_of_detail/layout_split.h"
#include "level_of_detail/mesh_region.h"
#include "level_of_detail/simplification.h"
#include "level_of_detail/sorted_mesh.h"
#include "level_of_detail/vertex_clusters.h"

namespace rviz_mesh_plugin {
namespace {

/// A preview has at most so many cells along its longest side.
constexpr int PREVIEW_CELLS = 160;

void refuseWrongMaterials(const MeshData& mesh, const Materials* materials)
{
  if (materials != nullptr && !materials->texture_coordinates.empty() &&
      materials->texture_coordinates.size() != mesh.vertexCount()) {
    throw std::invalid_argument(
        "there are " + std::to_string(materials->texture_coordinates.size()) +
        " texture coordinates for " + std::to_string(mesh.vertexCount()) + " vertices");
  }
}

}  // namespace

std::atomic<std::size_t> preview_threshold{2500000};

MeshLayoutConstPtr layOut(const MeshDataConstPtr& mesh, Split split,
                          const MaterialsConstPtr& materials, const std::atomic<bool>& canceled,
                          const PreviewReceiver& receive_preview)
{
  refuseWrongMaterials(*mesh, materials.get());
  if (canceled) {
    return nullptr;
  }
  const auto splitter = makeSplit(split, materials.get());
  const MeshRegion region = mainRegion(*mesh);
  if (receive_preview && mesh->faceCount() > preview_threshold) {
    receive_preview(layOutPreview(mesh));
  }
  if (canceled) {
    return nullptr;
  }
  const SortedMesh sorted = sortInSpace(mesh->vertices, mesh->indices, region);
  if (canceled) {
    return nullptr;
  }
  auto layout = std::make_shared<MeshLayout>();
  layout->mesh = mesh;
  layout->materials = split == Split::BY_MATERIAL ? materials : nullptr;
  layout->split = split;
  std::vector<SimplifiedLevel> levels;
  SplitFaces faces;
  std::unique_ptr<LayoutParts> parts;
  mesh_map::parallelJobs({[&]() {
                            levels = simplifyInLevels(sorted.vertices, sorted.indices, region,
                                                      typicalEdge(*mesh), canceled);
                          },
                          [&]() {
                            faces = splitter->split(sorted, *layout);
                            parts = std::make_unique<LayoutParts>(faces, *layout);
                          }},
                         2);
  if (canceled) {
    return nullptr;
  }
  parts->write(levels, *splitter);
  layout->vertices.shrink_to_fit();
  layout->sources.shrink_to_fit();
  layout->texture_coordinates.shrink_to_fit();
  return layout;
}

MeshLayoutConstPtr layOutPreview(const MeshDataConstPtr& mesh)
{
  const MeshRegion region = mainRegion(*mesh);
  if (!region.hasExtent()) {
    return nullptr;
  }
  const auto indices = clusterVertices(*mesh, region, PREVIEW_CELLS);
  if (indices.empty() || 2 * indices.size() > mesh->indices.size()) {
    return nullptr;
  }
  const SortedMesh sorted = sortInSpace(mesh->vertices, indices, region);
  const auto splitter = makeSplit(Split::NONE, nullptr);
  auto layout = std::make_shared<MeshLayout>();
  layout->mesh = mesh;
  layout->preview = true;
  const SplitFaces faces = splitter->split(sorted, *layout);
  LayoutParts(faces, *layout).write({}, *splitter);
  layout->cell_sizes = {region.extent() / PREVIEW_CELLS};
  return layout;
}

}  // namespace rviz_mesh_plugin
