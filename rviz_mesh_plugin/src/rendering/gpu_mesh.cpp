#include "rendering/gpu_mesh.h"

#include <algorithm>
#include <memory>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {

GpuMesh::GpuMesh(Ogre::SceneNode* parent, const MeshLayoutConstPtr& layout,
                 std::size_t indices_per_buffer)
    : PlacedVisual(parent),
      layout_(std::make_shared<LayoutOutline>(*layout)),
      colors_(layout_),
      materials_(layout_),
      masks_(layout_)
{
  setVisible(false);
  drawing_.cell_sizes = &layout_->cell_sizes;
  if (!layout->vertices.empty() && !layout->indices.empty()) {
    buffers_ = std::make_unique<MeshBuffers>(layout, indices_per_buffer);
    drawing_.buffers = buffers_.get();
    makeParts();
  }
  applyStyle();
}

void GpuMesh::makeParts()
{
  parts_.reserve(layout_->parts.size());
  for (const MeshPart& part : layout_->parts) {
    if (part.levels.empty()) {
      continue;
    }
    parts_.push_back(std::make_unique<MeshPartObject>(drawing_, part));
    node()->createChildSceneNode()->attachObject(parts_.back().get());
    masks_.add(*parts_.back());
    coarsest_end_ = std::max(coarsest_end_, part.levels.back().end());
  }
}

bool GpuMesh::drawable() const
{
  return !buffers_ || (buffers_->verticesComplete() && colors_.usable() &&
                       buffers_->uploadedIndices() >= coarsest_end_);
}

float GpuMesh::progress() const
{
  return !buffers_ || buffers_->bytes() == 0 ? 1.0f
                                             : static_cast<float>(buffers_->uploadedBytes()) /
                                                   static_cast<float>(buffers_->bytes());
}

bool GpuMesh::uploadSlice()
{
  if (!buffers_) {
    return false;
  }
  const bool faces_left = !buffers_->complete();
  // The first colors come before the faces, which later ones do not keep from coming.
  const bool colors_turn = !faces_left || !colors_.usable() || colors_turn_;
  if (buffers_->verticesComplete() && !colors_.complete() && colors_turn) {
    colors_turn_ = false;
    colors_.uploadSlice();
    if (colors_.buffer().get() != bound_colors_.get()) {
      bound_colors_ = colors_.buffer();
      buffers_->bindColors(bound_colors_);
      applyStyle();
    }
    return true;
  }
  if (faces_left) {
    colors_turn_ = true;
    buffers_->uploadSlice();
    drawing_.uploaded_indices = buffers_->uploadedIndices();
    return true;
  }
  if (!materials_.complete()) {
    if (materials_.uploadSlice()) {
      assignMaterials();
    }
    return true;
  }
  return false;
}

void GpuMesh::setStyle(const MeshStyle& style)
{
  if (style != style_) {
    style_ = style;
    applyStyle();
  }
}

void GpuMesh::applyStyle()
{
  drawing_.detail_pixels = style_.level_of_detail ? style_.detail_pixels : 0.0f;
  drawing_.section = style_.section;
  materials_.apply(style_, isSet(bound_colors_), colors_.translucent());
  assignMaterials();
}

void GpuMesh::assignMaterials()
{
  for (const auto& part : parts_) {
    part->useMaterial(materials_.of(part->part()));
    part->setColor(materials_.colorOf(part->part()));
  }
}

void GpuMesh::setColors(const ColorSource& colors, bool translucent)
{
  if (buffers_) {
    colors_.start(colors, translucent);
  }
}

void GpuMesh::updateColors(const ColorSource& colors, const std::vector<std::uint32_t>& changed)
{
  if (buffers_) {
    colors_.update(colors, changed);
  }
}

void GpuMesh::clearColors()
{
  colors_.clear();
  if (isSet(bound_colors_)) {
    bound_colors_ = Ogre::HardwareVertexBufferSharedPtr();
    buffers_->bindColors(bound_colors_);
    applyStyle();
  }
}

void GpuMesh::setTexture(const TextureImageConstPtr& image)
{
  materials_.setTexture(image);
  assignMaterials();
}

void GpuMesh::clearTextures()
{
  materials_.clearTextures();
  assignMaterials();
}

std::size_t GpuMesh::gpuBytes() const
{
  return (buffers_ ? buffers_->bytes() : 0) + colors_.bytes() + materials_.bytes() + masks_.bytes();
}

}  // namespace rviz_mesh_plugin
