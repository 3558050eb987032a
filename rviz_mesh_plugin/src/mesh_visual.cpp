#include "rviz_mesh_plugin/mesh_visual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <OgreAxisAlignedBox.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include "rviz_mesh_plugin/mesh_material.h"
#include "rviz_mesh_plugin/mesh_object.h"

namespace rviz_mesh_plugin {
namespace {

Ogre::AxisAlignedBox bounds(const MeshData& mesh, float margin)
{
  return {mesh.lower[0] - margin, mesh.lower[1] - margin, mesh.lower[2] - margin,
          mesh.upper[0] + margin, mesh.upper[1] + margin, mesh.upper[2] + margin};
}

/// Two ends per line: the vertex, and @a length along its normal.
std::vector<std::array<float, 3>> normalLines(const MeshData& mesh, float length)
{
  const std::size_t stride = normalStride(mesh.vertexCount());
  std::vector<std::array<float, 3>> ends;
  ends.reserve(2 * (mesh.vertexCount() / stride + 1));
  for (std::size_t i = 0; i < mesh.vertexCount(); i += stride) {
    const auto& p = mesh.vertices[i].position;
    const auto& n = mesh.vertices[i].normal;
    ends.push_back(p);
    ends.push_back({p[0] + length * n[0], p[1] + length * n[1], p[2] + length * n[2]});
  }
  return ends;
}

}  // namespace

MeshVisual::MeshVisual(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent)
    : scene_manager_(scene_manager),
      parent_(parent),
      node_(parent->createChildSceneNode()),
      material_(std::make_unique<MeshMaterial>())
{
}

MeshVisual::~MeshVisual()
{
  normals_.reset();
  faces_.reset();
  destroySceneNode(node_);
}

void MeshVisual::setLayout(const MeshLayoutConstPtr& layout)
{
  normals_.reset();
  faces_.reset();
  layout_ = layout;
  translucent_colors_ = false;
  auto faces =
      std::make_unique<MeshObject>(scene_manager_, Ogre::RenderOperation::OT_TRIANGLE_LIST);
  faces->setVertices(layout->vertices.data(), layout->vertices.size(), true);
  faces->setIndices(layout->indices);
  faces->finish(bounds(*layout->mesh, 0.0f), material_->get());
  faces_ = std::move(faces);
  ++geometry_uploads_;
  applyStyle();
}

bool MeshVisual::upload(std::chrono::microseconds /*budget*/)
{
  return true;
}

float MeshVisual::progress() const
{
  return 1.0f;
}

void MeshVisual::setColors(const ColorSource& colors, bool translucent)
{
  colors_ = colors;
  std::vector<Rgba8> values(layout_->sources.size());
  colors(layout_->sources.data(), values.size(), values.data());
  faces_->setColors(values);
  ++color_uploads_;
  translucent_colors_ = translucent;
  applyStyle();
}

void MeshVisual::updateColors(const std::vector<std::uint32_t>& /*changed*/)
{
  setColors(colors_, translucent_colors_);
}

void MeshVisual::clearColors()
{
  if (faces_ && faces_->hasColors()) {
    faces_->clearColors();
    translucent_colors_ = false;
    applyStyle();
  }
}

void MeshVisual::setTexture(const TextureImageConstPtr& /*image*/) {}

void MeshVisual::clearTextures() {}

void MeshVisual::setStyle(const MeshStyle& style)
{
  style_ = style;
  applyStyle();
}

void MeshVisual::setPose(const Ogre::Vector3& position, const Ogre::Quaternion& orientation)
{
  node_->setPosition(position);
  node_->setOrientation(orientation);
}

void MeshVisual::setVisible(bool visible)
{
  if (visible == visible_) {
    return;
  }
  visible_ = visible;
  // Taken out of the scene: RViz makes all attached objects visible when the display is enabled.
  if (visible) {
    parent_->addChild(node_);
  } else {
    parent_->removeChild(node_);
  }
}

void MeshVisual::applyStyle()
{
  if (!faces_) {
    return;
  }
  material_->apply(style_, faces_->hasColors(), translucent_colors_);
  const bool anything = style_.faces != MeshStyle::Faces::HIDDEN || style_.show_wireframe;
  faces_->attachTo(anything ? node_ : nullptr);
  updateNormals();
}

void MeshVisual::updateNormals()
{
  if (!style_.show_normals) {
    normals_.reset();
    normals_material_.reset();
    return;
  }
  if (!normals_material_) {
    normals_material_ = std::make_unique<MeshMaterial>();
  }
  normals_material_->applyUnlit(style_.normals_color);
  if (normals_ && normals_length_ == style_.normals_length) {
    return;
  }
  normals_length_ = style_.normals_length;
  const auto ends = normalLines(*layout_->mesh, normals_length_);
  auto normals = std::make_unique<MeshObject>(scene_manager_, Ogre::RenderOperation::OT_LINE_LIST);
  normals->setVertices(ends.data(), ends.size(), false);
  normals->finish(bounds(*layout_->mesh, std::fabs(normals_length_)), normals_material_->get());
  normals_ = std::move(normals);
  normals_->attachTo(node_);
}

}  // namespace rviz_mesh_plugin
