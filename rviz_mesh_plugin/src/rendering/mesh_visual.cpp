#include "rendering/mesh_visual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <OgreHardwareBufferManager.h>
#include <OgreSimpleRenderable.h>

#include "rendering/gpu_mesh.h"
#include "rendering/mesh_material.h"
#include "rendering/ogre/finite_bounds.h"
#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Colors of one can be used for the other.
bool sameSources(const LayoutOutline& a, const LayoutOutline& b)
{
  return a.mesh == b.mesh && (a.split == Split::BY_FACE) == (b.split == Split::BY_FACE);
}

/// Two ends per line: the vertex, and @a length along its normal. Vertices of hidden faces alone
/// have none.
std::vector<std::array<float, 3>> normalLines(const LayoutOutline& layout, float length)
{
  const MeshData& mesh = *layout.mesh;
  const std::size_t count = layout.hidden ? layout.sources.size() : mesh.vertexCount();
  const auto vertex = [&](std::size_t i) -> std::size_t {
    if (!layout.hidden) {
      return i;
    }
    const std::size_t source = layout.sources[i];
    return layout.split == Split::BY_FACE ? mesh.indices[3 * source] : source;
  };
  const std::size_t stride = normalStride(count);
  std::vector<std::array<float, 3>> ends;
  ends.reserve(2 * (count / stride + 1));
  for (std::size_t i = 0; i < count; i += stride) {
    const auto& p = mesh.vertices[vertex(i)].position;
    const auto& n = mesh.vertices[vertex(i)].normal;
    ends.push_back(p);
    ends.push_back({p[0] + length * n[0], p[1] + length * n[1], p[2] + length * n[2]});
  }
  return ends;
}

}  // namespace

/// Lines from the vertices of a mesh along their normals.
class MeshVisual::NormalLines : public Ogre::SimpleRenderable
{
 public:
  /// @param layout has vertices
  NormalLines(const LayoutOutline& layout, float length, const Ogre::MaterialPtr& material)
      : Ogre::SimpleRenderable(uniqueName("Normals")), material_(material)
  {
    setCastShadows(false);
    setBoundingBox(finiteBounds(*layout.mesh, std::fabs(length)));
    const auto ends = normalLines(layout, length);
    auto buffer = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        sizeof(ends[0]), ends.size(), Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    buffer->writeData(0, buffer->getSizeInBytes(), ends.data(), true);
    constexpr unsigned short BINDING = 0;
    vertices_.vertexCount = ends.size();
    vertices_.vertexDeclaration->addElement(BINDING, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
    vertices_.vertexBufferBinding->setBinding(BINDING, buffer);
    mRenderOp.operationType = Ogre::RenderOperation::OT_LINE_LIST;
    mRenderOp.vertexData = &vertices_;
    mRenderOp.useIndexes = false;
  }

  const Ogre::MaterialPtr& getMaterial() const override { return material_; }
  Ogre::Real getBoundingRadius() const override { return radiusAboutOrigin(getBoundingBox()); }
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override
  {
    return mParentNode->getSquaredViewDepth(camera);
  }

 private:
  Ogre::MaterialPtr material_;
  Ogre::VertexData vertices_;
};

MeshVisual::MeshVisual(Ogre::SceneNode* parent, std::size_t indices_per_buffer)
    : PlacedVisual(parent), indices_per_buffer_(indices_per_buffer)
{
}

MeshVisual::~MeshVisual() = default;

void MeshVisual::setLayout(const MeshLayoutConstPtr& layout)
{
  if (layout_ && layout == given_.lock()) {
    return;
  }
  const bool keep_colors = layout_ && sameSources(*layout_, *layout);
  coming_.reset();
  layout_ = shown_layout_;
  given_.reset();
  if (!keep_colors) {
    colors_ = nullptr;
  }
  auto picture = std::make_unique<GpuMesh>(node(), layout, indices_per_buffer_);
  picture->setStyle(style_);
  if (colors_) {
    picture->setColors(colors_, translucent_colors_);
  }
  if (layout_ && layout_->mesh != layout->mesh) {
    hidden_.reset();
  }
  layout_ = picture->layout();
  given_ = layout;
  coming_ = std::move(picture);
  fresh_ = true;
  uploadIfSmall();
}

void MeshVisual::uploadIfSmall()
{
  if (newest()->gpuBytes() <= SLICE_BYTES) {
    upload();
  }
}

bool MeshVisual::upload(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  if (std::exchange(fresh_, false) && newest() && newest()->nextSliceIsLong()) {
    return false;  // setLayout() has taken its time already
  }
  try {
    do {
      if (!uploadSlice()) {
        return !shown_ || shown_->isHiddenComplete();
      }
    } while (std::chrono::steady_clock::now() < end && !newest()->nextSliceIsLong());
  } catch (...) {
    // What is drawn stays as it is, but for colors that never became complete.
    if (coming_) {
      coming_.reset();
      layout_ = shown_layout_;
      given_.reset();
    }
    colors_ = nullptr;
    throw;
  }
  return false;
}

bool MeshVisual::uploadSlice()
{
  GpuMesh* picture = newest();
  if (!picture) {
    return false;
  }
  if (shown_ && shown_->uploadHiddenSlice()) {
    return true;
  }
  const bool geometry_complete = picture->geometryComplete();
  const std::size_t color_uploads = picture->colorUploads();
  const bool worked = picture->uploadSlice();
  geometry_uploads_ += !geometry_complete && picture->geometryComplete() ? 1 : 0;
  color_uploads_ += picture->colorUploads() - color_uploads;
  if (coming_ && coming_->drawable()) {
    showComing();
  }
  return worked;
}

void MeshVisual::showComing()
{
  shown_ = std::move(coming_);
  shown_layout_ = layout_;
  shown_->hide(hidden_);
  shown_->setVisible(true);
  updateNormals();
}

float MeshVisual::progress() const
{
  return newest() ? newest()->progress() : 1.0f;
}

void MeshVisual::setColors(const ColorSource& colors, bool translucent)
{
  if (!newest()) {
    return;
  }
  colors_ = colors;
  translucent_colors_ = translucent;
  newest()->setColors(colors, translucent);
  uploadIfSmall();
}

void MeshVisual::updateColors(const ColorSource& colors, const std::vector<std::uint32_t>& changed)
{
  if (newest() && colors_) {
    colors_ = colors;
    newest()->updateColors(colors, changed);
    uploadIfSmall();
  }
}

void MeshVisual::clearColors()
{
  colors_ = nullptr;
  if (newest()) {
    newest()->clearColors();
  }
}

void MeshVisual::setTexture(const TextureImageConstPtr& image)
{
  if (newest()) {
    newest()->setTexture(image);
  }
}

void MeshVisual::clearTextures()
{
  if (newest()) {
    newest()->clearTextures();
  }
}

void MeshVisual::hide(const HiddenFacesConstPtr& hidden)
{
  hidden_ = hidden;
  if (shown_) {
    shown_->hide(hidden);
  }
}

bool MeshVisual::hides(const HiddenFacesConstPtr& hidden) const
{
  return !shown_ || (shown_layout_->hidden == hidden) ||
         (hidden == hidden_ && shown_layout_->faces && shown_->isHiddenComplete());
}

void MeshVisual::setStyle(const MeshStyle& style)
{
  style_ = style;
  for (GpuMesh* picture : {shown_.get(), coming_.get()}) {
    if (picture) {
      picture->setStyle(style);
    }
  }
  updateNormals();
}

std::size_t MeshVisual::facesDrawn() const
{
  std::size_t count = 0;
  if (shown_) {
    for (const auto& part : shown_->parts()) {
      count += part->drawn().count / 3;
    }
  }
  return count;
}

std::size_t MeshVisual::gpuBytes() const
{
  return (shown_ ? shown_->gpuBytes() : 0) + (coming_ ? coming_->gpuBytes() : 0);
}

void MeshVisual::updateNormals()
{
  if (!style_.show_normals || !shown_) {
    normals_.reset();
    normals_material_.reset();
    normals_mesh_.reset();
    normals_hidden_.reset();
    return;
  }
  if (!normals_material_) {
    normals_material_ = std::make_unique<MeshMaterial>();
  }
  normals_material_->applyUnlit(style_.normals_color, style_.section);
  const MeshDataConstPtr& mesh = shown_layout_->mesh;
  if (normals_mesh_ == mesh && normals_hidden_ == shown_layout_->hidden &&
      normals_length_ == style_.normals_length) {
    return;
  }
  normals_.reset();
  normals_mesh_ = mesh;
  normals_hidden_ = shown_layout_->hidden;
  normals_length_ = style_.normals_length;
  if (mesh->vertexCount() > 0 && !(normals_hidden_ && shown_layout_->sources.empty())) {
    normals_ =
        std::make_unique<NormalLines>(*shown_layout_, normals_length_, normals_material_->get());
    node()->attachObject(normals_.get());
  }
}

}  // namespace rviz_mesh_plugin
