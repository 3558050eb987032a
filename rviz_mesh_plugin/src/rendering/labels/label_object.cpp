#include "rendering/labels/label_object.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <OgreCamera.h>
#include <OgreHardwareBufferManager.h>
#include <OgrePass.h>
#include <OgreRenderOperation.h>
#include <OgreRenderQueue.h>
#include <OgreTechnique.h>

#include "rendering/level_choice.h"
#include "rendering/mesh_style.h"
#include "rendering/ogre/finite_bounds.h"
#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Where a mesh is drawn with less detail, it may differ from its faces by so many pixels.
constexpr float DETAIL_PIXELS = 3.0f;

/// Opaque labels are drawn before the mesh, which then does not get in front of them but for its
/// wireframe; translucent ones after it.
constexpr Ogre::uint8 BEFORE_MESHES = Ogre::RENDER_QUEUE_MAIN - 1;
constexpr Ogre::uint8 AFTER_MESHES = Ogre::RENDER_QUEUE_MAIN + 1;

constexpr std::size_t FACE_BYTES = 3 * sizeof(std::uint32_t);

/// That are prepared at a time.
constexpr std::size_t UPLOAD_SLICE = 1 << 18;

/// To look at a face takes as long as to upload so many bytes.
constexpr std::size_t LOOK_BYTES = 4;

/// Simplified faces stand for those that are smaller than so many pixels, as in meshes; where all
/// faces of a part are drawn, so that there is no outline in it, for larger ones, which then differ
/// more from the mesh. (Opaque ones save the mesh below them what they cost.)
const float SIMPLIFIED_PIXELS = MeshStyle().detail_pixels;
constexpr float WHOLE_SIMPLIFIED_PIXELS = 8.0f;
constexpr float WHOLE_DETAIL_PIXELS = 6.0f;

}  // namespace

/// One part in one level of detail.
class LabelObject::PartRenderable : public Ogre::Renderable
{
 public:
  /// @param nearer see LabelObject::nearer_
  PartRenderable(const LabelObject& label, const Ogre::HardwareIndexBufferSharedPtr& buffer,
                 const IndexRange& range, const Ogre::Vector3& center, float nearer)
      : label_(&label), buffer_(buffer), range_(range), center_(center), nearer_(nearer)
  {
  }

  std::size_t faces() const { return range_.count / 3; }
  float nearer() const { return nearer_; }

  const Ogre::MaterialPtr& getMaterial() const override { return label_->getMaterial(); }
  void getRenderOperation(Ogre::RenderOperation& operation) override
  {
    indices_.indexBuffer = buffer_;
    indices_.indexStart = range_.start;
    indices_.indexCount = range_.count;
    operation.operationType = Ogre::RenderOperation::OT_TRIANGLE_LIST;
    operation.useIndexes = true;
    operation.vertexData = label_->vertices_.data();
    operation.indexData = &indices_;
    operation.srcRenderable = this;
  }
  void getWorldTransforms(Ogre::Matrix4* transform) const override
  {
    label_->transform(transform, nearer_);
  }
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override
  {
    return (center_ - camera->getDerivedPosition()).squaredLength();
  }
  const Ogre::LightList& getLights() const override { return label_->getLights(); }

 private:
  const LabelObject* label_;
  Ogre::HardwareIndexBufferSharedPtr buffer_;
  IndexRange range_;
  Ogre::Vector3 center_;
  float nearer_;
  Ogre::IndexData indices_;
};

LabelObject::LabelObject(Ogre::SceneNode* parent, LabelVertices& vertices, bool growing)
    : Ogre::SimpleRenderable(uniqueName("Label")),
      node_(parent->createChildSceneNode()),
      vertices_(vertices),
      growing_(growing)
{
  setCastShadows(false);
  setQueryFlags(0);
  node_->attachObject(this);
}

LabelObject::~LabelObject()
{
  node_->detachObject(this);
  destroySceneNode(node_);
}

void LabelObject::setFaces(std::shared_ptr<const IndexSlots::Faces> faces, bool in_parts,
                           const HiddenFacesConstPtr& hidden)
{
  if (!parts_ && !in_parts && faces->size() <= MANY_FACES) {
    wanted_ = withoutHidden(faces, hidden);
    return;
  }
  if (!parts_) {
    parts_ = std::make_unique<LabelParts>(vertices_, false);
  }
  parts_->setFaces([faces = std::move(faces), hidden, count = vertices_.mesh()->faceCount()] {
    FaceBits drawn(count, *faces);
    if (hidden) {
      drawn.remove(hidden->bits());
    }
    return drawn;
  });
}

void LabelObject::setFaces(std::shared_ptr<const FaceBits> faces)
{
  if (!parts_) {
    parts_ = std::make_unique<LabelParts>(vertices_, true);
  }
  parts_->setFaces([faces = std::move(faces)] { return *faces; });
}

std::size_t LabelObject::upload(std::size_t& left)
{
  if (parts_) {
    const bool were_drawn = parts_->isDrawable();
    const std::size_t uploaded = parts_->upload(left);
    if (!were_drawn && parts_->isDrawable()) {  // instead of few faces
      wanted_.reset();
      slots_ = IndexSlots();
      dirty_.clear();
      buffer_ = drawn_.indexBuffer = Ogre::HardwareIndexBufferSharedPtr();
      drawn_.indexCount = 0;
    }
    if (drawsParts()) {
      Ogre::AxisAlignedBox box;
      for (const auto& part : parts_->parts()) {
        box.merge(finiteBounds(parts_->levels()->parts[part.first]));
      }
      setBoundingBox(box);
      node_->needUpdate();
    }
    return uploaded;
  }
  prepare(left);
  std::size_t faces_left = dirty_.empty() ? 0 : std::max<std::size_t>(1, left / FACE_BYTES);
  std::size_t written = 0;
  while (!dirty_.empty() && faces_left > 0) {
    IndexSlots::Range& range = dirty_.back();
    const std::size_t begin =
        range.begin + faces_left < range.end ? range.end - faces_left : range.begin;
    write(begin, range.end);
    faces_left -= range.end - begin;
    written += range.end - begin;
    range.end = begin;
    if (range.end == range.begin) {
      dirty_.pop_back();
    }
  }
  if (written > 0) {
    node_->needUpdate();
    if (dirty_.empty()) {
      drawAll();
    }
  }
  left -= std::min(left, written * FACE_BYTES);
  return written * FACE_BYTES;
}

std::size_t LabelObject::changeFaces(const IndexSlots::Faces& added,
                                     const IndexSlots::Faces& removed)
{
  slots_.change(added, removed);
  takeChanges();
  std::size_t uploaded = 0;
  while (!dirty_.empty()) {
    std::size_t left = UPLOAD_SLICE;
    uploaded += upload(left);
  }
  return uploaded;
}

/// What is being uploaded is finished first, so that faces that change all the time show, too.
void LabelObject::prepare(std::size_t& left)
{
  if (!dirty_.empty()) {
    return;
  }
  if (slots_.isSettled() && wanted_) {
    slots_.assign(std::move(wanted_));
    wanted_.reset();
  }
  const std::size_t looked = slots_.work(std::max<std::size_t>(1, left / LOOK_BYTES));
  left -= std::min(left, looked * LOOK_BYTES);
  if (looked > 0 && slots_.isSettled()) {
    takeChanges();
  }
}

void LabelObject::takeChanges()
{
  dirty_ = slots_.takeChanged();
  const std::size_t count = slots_.faces().size();
  if (!isSet(buffer_) || buffer_->getNumIndexes() < 3 * count) {
    buffer_ = Ogre::HardwareBufferManager::getSingleton().createIndexBuffer(
        Ogre::HardwareIndexBuffer::IT_32BIT, 3 * (growing_ ? count + count / 4 + 16 : count),
        Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY);
    dirty_ = {{0, count}};
    setBoundingBox(Ogre::AxisAlignedBox::BOX_NULL);
  } else {
    drawn_.indexCount = std::min(drawn_.indexCount, 3 * count);
  }
  if (dirty_.empty()) {
    drawAll();
  }
}

void LabelObject::drawAll()
{
  drawn_.indexBuffer = buffer_;
  drawn_.indexCount = 3 * slots_.faces().size();
}

void LabelObject::write(std::size_t begin, std::size_t end)
{
  const MeshData& mesh = *vertices_.mesh();
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * (end - begin));
  Ogre::AxisAlignedBox box = getBoundingBox();
  for (std::size_t place = begin; place < end; ++place) {
    const std::size_t face = slots_.faces()[place];
    for (std::size_t corner = 3 * face; corner < 3 * face + 3; ++corner) {
      const std::uint32_t index = mesh.indices[corner];
      indices.push_back(index);
      const auto& p = mesh.vertices[index].position;
      box.merge(Ogre::Vector3(p[0], p[1], p[2]));
    }
  }
  buffer_->writeData(FACE_BYTES * begin, FACE_BYTES * (end - begin), indices.data(), false);
  setBoundingBox(box);
}

std::size_t LabelObject::gpuBytes() const
{
  std::size_t bytes = isSet(buffer_) ? buffer_->getSizeInBytes() : 0;
  if (isSet(drawn_.indexBuffer) && drawn_.indexBuffer.get() != buffer_.get()) {
    bytes += drawn_.indexBuffer->getSizeInBytes();
  }
  return bytes + (parts_ ? parts_->gpuBytes() : 0);
}

std::size_t LabelObject::facesDrawn() const
{
  if (!drawsParts()) {
    return drawn_.indexCount / 3;
  }
  std::size_t faces = 0;
  for (const auto& part : drawn_parts_) {
    faces += part->faces();
  }
  return faces;
}

Ogre::Real LabelObject::getBoundingRadius() const
{
  return getBoundingBox().isFinite() ? radiusAboutOrigin(getBoundingBox()) : 0.0f;
}

bool LabelObject::isVisible() const
{
  return shown_ && (drawsParts() || drawn_.indexCount > 0) && material_ && vertices_.complete() &&
         Ogre::MovableObject::isVisible();
}

void LabelObject::_notifyCurrentCamera(Ogre::Camera* camera)
{
  Ogre::SimpleRenderable::_notifyCurrentCamera(camera);
  const PixelSize pixel = pixelSize(*camera);
  parallel_ = !pixel.grows_with_distance;
  eye_ = camera->getDerivedPosition();
  towards_camera_ = -camera->getDerivedDirection();
  const Ogre::AxisAlignedBox& box = vertices_.box();
  const float farthest =
      eye_.distance(_getParentNodeFullTransform() * box.getCenter()) + box.getHalfSize().length();
  // The mesh is drawn with less detail only where two edges are smaller than a few pixels.
  const bool coarse = 2.0f * vertices_.edge() < DETAIL_PIXELS * pixel.at(farthest);
  nearer_ = coarse ? DETAIL_PIXELS * pixel.meters : 0.0f;
  chooseParts(*camera, pixel);
}

/// Those in sight, each in the level that the mesh has there.
void LabelObject::chooseParts(const Ogre::Camera& camera, const PixelSize& pixel)
{
  drawn_parts_.clear();
  if (!drawsParts()) {
    return;
  }
  const bool translucent = material_ && material_->isTranslucent();
  // Else what lies there twice is seen twice.
  const bool once =
      material_ && material_->get()->getTechnique(0)->getPass(0)->getDepthWriteEnabled();
  const OverlayLevels& levels = *parts_->levels();
  const Ogre::Vector3 eye =
      node_->_getDerivedOrientation().Inverse() * (eye_ - node_->_getDerivedPosition());
  for (const auto& entry : parts_->parts()) {
    const LabelParts::Part& part = entry.second;
    Ogre::AxisAlignedBox box = finiteBounds(levels.parts[entry.first]);
    const float distance = std::sqrt(static_cast<float>(box.squaredDistance(eye)));
    const bool coarser = part.whole && translucent && once;
    const float pixels = coarser ? WHOLE_SIMPLIFIED_PIXELS : SIMPLIFIED_PIXELS;
    const std::size_t level = chooseLevel(levels.cell_sizes, pixels * pixel.at(distance));
    const float nearer = coarser && level > 0 ? WHOLE_DETAIL_PIXELS * pixel.meters : nearer_;
    IndexRange range = part.levels[std::min(level, part.levels.size() - 1)];
    range.count += once ? range.seam_count : 0;
    box.transform(_getParentNodeFullTransform());
    if (range.count > 0 && camera.isVisible(box)) {
      drawn_parts_.push_back(
          std::make_unique<PartRenderable>(*this, part.buffer, range, box.getCenter(), nearer));
    }
  }
}

void LabelObject::getWorldTransforms(Ogre::Matrix4* transform) const
{
  this->transform(transform, nearer_);
}

void LabelObject::transform(Ogre::Matrix4* transform, float nearer) const
{
  Ogre::SimpleRenderable::getWorldTransforms(transform);
  if (nearer <= 0.0f) {
    return;
  }
  for (int row = 0; row < 3; ++row) {
    if (parallel_) {
      (*transform)[row][3] += nearer * towards_camera_[row];
      continue;
    }
    // Scaled about the eye: each point stays where it is in the picture.
    const float share = 1.0f - std::min(nearer, 0.1f);
    for (int column = 0; column < 3; ++column) {
      (*transform)[row][column] *= share;
    }
    (*transform)[row][3] = eye_[row] + share * ((*transform)[row][3] - eye_[row]);
  }
}

void LabelObject::_updateRenderQueue(Ogre::RenderQueue* queue)
{
  if (material_->isTranslucent()) {
    addTo(queue, AFTER_MESHES, OGRE_RENDERABLE_DEFAULT_PRIORITY);
  } else {
    addTo(queue, BEFORE_MESHES,
          static_cast<Ogre::ushort>(OGRE_RENDERABLE_DEFAULT_PRIORITY + layer_));
  }
}

void LabelObject::addTo(Ogre::RenderQueue* queue, Ogre::uint8 group, Ogre::ushort priority)
{
  if (!drawsParts()) {
    queue->addRenderable(this, group, priority);
  }
  // The nearer ones first, for what is drawn once. (There are none among opaque ones, whose
  // priority is their layer.)
  const bool translucent = material_->isTranslucent();
  for (const auto& part : drawn_parts_) {
    const bool second = translucent && part->nearer() <= nearer_;
    queue->addRenderable(part.get(), group, static_cast<Ogre::ushort>(priority + (second ? 1 : 0)));
  }
}

void LabelObject::visitRenderables(Ogre::Renderable::Visitor* visitor, bool /*debug_renderables*/)
{
  if (!material_) {
    return;
  }
  if (!drawsParts()) {
    visitor->visit(this, 0, false);
  }
  for (const auto& part : drawn_parts_) {
    visitor->visit(part.get(), 0, false);
  }
}

void LabelObject::getRenderOperation(Ogre::RenderOperation& operation)
{
  operation.operationType = Ogre::RenderOperation::OT_TRIANGLE_LIST;
  operation.useIndexes = true;
  operation.vertexData = vertices_.data();
  operation.indexData = &drawn_;
  operation.srcRenderable = this;
}

Ogre::Real LabelObject::getSquaredViewDepth(const Ogre::Camera* camera) const
{
  return (getWorldBoundingBox(true).getCenter() - camera->getDerivedPosition()).squaredLength();
}

}  // namespace rviz_mesh_plugin
