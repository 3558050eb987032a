#include "rendering/mesh_part_object.h"

#include <cmath>

#include <OgreCamera.h>
#include <OgreNode.h>
#include <OgreRenderOperation.h>
#include <OgreRenderQueue.h>

#include "rendering/level_choice.h"
#include "rendering/mesh_buffers.h"
#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"
#include "rendering/two_sided_lighting.h"

namespace rviz_mesh_plugin {

MeshPartObject::MeshPartObject(const PartDrawing& drawing, const MeshPart& part)
    : Ogre::SimpleRenderable(uniqueName("Part")), drawing_(drawing), part_(part)
{
  setBoundingBox(finiteBounds(part));
  setCastShadows(false);
  setColor(Ogre::ColourValue::White);
}

void MeshPartObject::useMaterial(const Ogre::MaterialPtr& material)
{
  material_ = material;
  opaque_ = !isSet(material) || !material->isTransparent();
}

void MeshPartObject::setColor(const Ogre::ColourValue& color)
{
  setCustomParameter(PART_COLOR, Ogre::Vector4(color.r, color.g, color.b, color.a));
}

void MeshPartObject::mask(const Ogre::HardwareIndexBufferSharedPtr& indices, std::size_t count)
{
  masked_ = true;
  mask_ = indices;
  mask_count_ = count;
}

void MeshPartObject::unmask()
{
  masked_ = in_full_ = false;
  mask_ = Ogre::HardwareIndexBufferSharedPtr();
  mask_count_ = 0;
}

void MeshPartObject::_notifyCurrentCamera(Ogre::Camera* camera)
{
  Ogre::SimpleRenderable::_notifyCurrentCamera(camera);
  drawn_ = choose(*camera);
}

IndexRange MeshPartObject::choose(const Ogre::Camera& camera) const
{
  if (!drawing_.section.touches(part_)) {
    return IndexRange();
  }
  if (masked_) {
    return {0, static_cast<std::uint32_t>(mask_count_)};
  }
  std::size_t level = 0;
  if (drawing_.detail_pixels > 0.0f && mParentNode && !in_full_) {
    const Ogre::Vector3 eye = mParentNode->_getDerivedOrientation().Inverse() *
                              (camera.getDerivedPosition() - mParentNode->_getDerivedPosition());
    const float distance = std::sqrt(static_cast<float>(getBoundingBox().squaredDistance(eye)));
    level =
        chooseLevel(*drawing_.cell_sizes, drawing_.detail_pixels * pixelSize(camera).at(distance));
  }
  for (; level < part_.levels.size(); ++level) {
    IndexRange range = part_.levels[level];
    if (range.end() <= drawing_.uploaded_indices) {
      // What lies there twice is seen twice where it is translucent.
      range.count += opaque_ ? range.seam_count : 0;
      range.seam_count = 0;
      return range;
    }
  }
  return IndexRange();
}

void MeshPartObject::_updateRenderQueue(Ogre::RenderQueue* queue)
{
  if (isSet(material_) && drawn_.count > 0) {
    queue->addRenderable(this, mRenderQueueID, mRenderQueuePriority);
  }
}

void MeshPartObject::visitRenderables(Ogre::Renderable::Visitor* visitor,
                                      bool /*debug_renderables*/)
{
  if (isSet(material_)) {  // visitors ask for it
    visitor->visit(this, 0, false);
  }
}

void MeshPartObject::getRenderOperation(Ogre::RenderOperation& operation)
{
  if (masked_) {
    index_data_.indexBuffer = mask_;
    index_data_.indexStart = 0;
  } else {
    const MeshBuffers::IndexBuffer& indices = drawing_.buffers->indexBuffer(drawn_.start);
    index_data_.indexBuffer = indices.buffer;
    index_data_.indexStart = drawn_.start - indices.begin;
  }
  index_data_.indexCount = drawn_.count;
  operation.operationType = Ogre::RenderOperation::OT_TRIANGLE_LIST;
  operation.vertexData = drawing_.buffers->vertices();
  operation.useIndexes = true;
  operation.indexData = &index_data_;
}

Ogre::Real MeshPartObject::getSquaredViewDepth(const Ogre::Camera* camera) const
{
  const Ogre::Vector3 center = _getParentNodeFullTransform() * getBoundingBox().getCenter();
  return (center - camera->getDerivedPosition()).squaredLength();
}

}  // namespace rviz_mesh_plugin
