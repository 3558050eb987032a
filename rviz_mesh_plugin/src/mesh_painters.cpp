#include "rviz_mesh_plugin/mesh_painters.h"

#include <algorithm>
#include <exception>

#include "rviz_mesh_plugin/label_color_feed.h"
#include "rviz_mesh_plugin/mesh_properties.h"
#include "rviz_mesh_plugin/mesh_store.h"

namespace rviz_mesh_plugin {

MeshPainters::Mesh* MeshPainters::find(const std::string& uuid)
{
  const auto found = std::find_if(meshes_.begin(), meshes_.end(),
                                  [&](const Mesh& mesh) { return mesh.painter->uuid() == uuid; });
  return found == meshes_.end() ? nullptr : &*found;
}

void MeshPainters::setLayouts(const std::vector<MeshLayoutConstPtr>& layouts)
{
  for (const MeshLayoutConstPtr& layout : layouts) {
    if (Mesh* mesh = find(layout->mesh->uuid)) {
      mesh->painter->setLayout(layout);
    }
  }
}

void MeshPainters::paint()
{
  // In the order of the store; those that it no longer has come last.
  std::list<Mesh> ordered;
  for (const MeshDataConstPtr& data : context_.store.meshes()) {
    const auto found = std::find_if(meshes_.begin(), meshes_.end(), [&](const Mesh& mesh) {
      return mesh.painter->uuid() == data->uuid;
    });
    if (found != meshes_.end()) {
      ordered.splice(ordered.end(), meshes_, found);
    } else {
      ordered.push_back({std::make_unique<MeshPainter>(context_, data->uuid),
                         std::make_unique<MeshLabels>(context_.scene_manager, context_.parent),
                         std::string()});
    }
  }
  ordered.splice(ordered.end(), meshes_);
  meshes_.swap(ordered);
  retire();
  for (Mesh& mesh : meshes_) {
    mesh.painter->paint();
    paintLabels(mesh);
  }
}

void MeshPainters::retire()
{
  const bool replaced =
      !context_.store.newest() ||
      (newest() && (newest()->painter->mesh() || !newest()->painter->error().empty()));
  meshes_.remove_if([&](const Mesh& mesh) {
    return !context_.store.mesh(mesh.painter->uuid()) && (replaced || !mesh.painter->mesh());
  });
}

void MeshPainters::attempt(Mesh& mesh, const std::function<void()>& draw_labels)
{
  try {
    draw_labels();
  } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
    mesh.labels->hide();
    mesh.labels_error = error.what();
  }
}

void MeshPainters::paintLabels(Mesh& mesh)
{
  mesh.labels_error.clear();
  attempt(mesh, [&] {
    if (context_.properties.labelsShown()) {
      mesh.labels->show(context_.store.mesh(mesh.painter->uuid()),
                        context_.store.attributes(mesh.painter->uuid()).labels,
                        context_.properties.labelsAlpha());
    } else {
      mesh.labels->hide();
    }
  });
}

bool MeshPainters::colorLabels(const LabelColorFeed& feed)
{
  bool changed = false;
  for (Mesh& mesh : meshes_) {
    attempt(mesh, [&] { changed |= mesh.labels->setOwnColors(feed.colors(mesh.painter->uuid())); });
  }
  return changed;
}

void MeshPainters::updateCosts(const CostLayerConstPtr& layer,
                               const std::vector<std::uint32_t>& vertices)
{
  if (Mesh* mesh = find(layer->uuid)) {
    mesh->painter->updateCosts(layer, vertices);
  }
}

bool MeshPainters::upload(std::chrono::microseconds budget)
{
  const auto start = std::chrono::steady_clock::now();
  const auto left = [&] {
    return budget - std::chrono::duration_cast<std::chrono::microseconds>(
                        std::chrono::steady_clock::now() - start);
  };
  bool done = true;
  for (Mesh& mesh : meshes_) {
    // At least one slice of one mesh, so that there is always some progress.
    if (!done && left().count() <= 0) {
      break;
    }
    done &= mesh.painter->upload(std::max(left(), std::chrono::microseconds(1)));
    attempt(mesh, [&] { done &= left().count() > 0 ? mesh.labels->upload(left()) : false; });
  }
  retire();
  return done;
}

void MeshPainters::setPoses(const FindPose& find_pose)
{
  for (Mesh& mesh : meshes_) {
    const MeshDataConstPtr drawn = mesh.painter->mesh();
    const MeshDataConstPtr data = drawn ? drawn : context_.store.mesh(mesh.painter->uuid());
    const auto pose = data ? find_pose(data->frame_id) : std::nullopt;
    mesh.painter->setPose(pose);
    mesh.labels->setPose(pose);
  }
}

}  // namespace rviz_mesh_plugin
