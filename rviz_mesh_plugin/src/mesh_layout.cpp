#include "rviz_mesh_plugin/mesh_layout.h"

#include <numeric>

namespace rviz_mesh_plugin {

MeshLayoutConstPtr layOut(const MeshDataConstPtr& mesh, Split split,
                          const MaterialsConstPtr& materials,
                          const std::atomic<bool>& /*cancelled*/)
{
  auto layout = std::make_shared<MeshLayout>();
  layout->mesh = mesh;
  layout->materials = materials;
  layout->split = split;
  layout->vertices = mesh->vertices;
  layout->sources.resize(mesh->vertexCount());
  std::iota(layout->sources.begin(), layout->sources.end(), 0);
  layout->indices = mesh->indices;
  layout->cell_sizes = {0.0f};
  MeshPart part;
  part.lower = mesh->lower;
  part.upper = mesh->upper;
  part.levels = {{0, static_cast<std::uint32_t>(mesh->indices.size())}};
  layout->parts = {part};
  return layout;
}

MeshLayoutConstPtr layOutPreview(const MeshDataConstPtr& mesh)
{
  const std::atomic<bool> cancelled{false};
  return layOut(mesh, Split::NONE, nullptr, cancelled);
}

}  // namespace rviz_mesh_plugin
