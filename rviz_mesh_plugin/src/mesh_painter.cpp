#include "rviz_mesh_plugin/mesh_painter.h"

#include <algorithm>
#include <atomic>
#include <exception>

#include "rviz_mesh_plugin/mesh_properties.h"
#include "rviz_mesh_plugin/mesh_store.h"
#include "rviz_mesh_plugin/mesh_visual.h"

namespace rviz_mesh_plugin {

MeshPainter::MeshPainter(const MeshStore& store, const MeshProperties& properties,
                         Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent)
    : store_(store), properties_(properties), scene_manager_(scene_manager), parent_(parent)
{
}

MeshPainter::~MeshPainter() = default;

void MeshPainter::paintGeometry()
{
  error_.clear();
  const MeshDataConstPtr& mesh = store_.geometry();
  if (!mesh) {
    visual_.reset();
    return;
  }
  attempt([&] {
    if (!visual_) {
      visual_ = std::make_unique<MeshVisual>(scene_manager_, parent_);
      visual_->setVisible(false);  // until its pose is known
    }
    const std::atomic<bool> cancelled{false};
    visual_->setLayout(layOut(mesh, Split::NONE, nullptr, cancelled));
  });
  paintColors();
}

void MeshPainter::paintColors()
{
  if (!visual_) {
    return;
  }
  attempt([this] {
    const DisplayType type = properties_.displayType();
    colors_shown_ = (type == DisplayType::VERTEX_COSTS && uploadCosts()) ||
                    (type == DisplayType::VERTEX_COLOR && uploadColors());
    if (!colors_shown_) {
      visual_->clearColors();
    }
    visual_->setStyle(properties_.style(colors_shown_));
  });
}

void MeshPainter::paintStyle()
{
  if (visual_) {
    attempt([this] { visual_->setStyle(properties_.style(colors_shown_)); });
  }
}

void MeshPainter::clear()
{
  visual_.reset();
  error_.clear();
}

void MeshPainter::attempt(const std::function<void()>& upload)
{
  try {
    upload();
  } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
    visual_.reset();
    error_ = error.what();
  }
}

bool MeshPainter::uploadCosts()
{
  const CostLayerConstPtr layer = store_.costs(properties_.costsType());
  if (!layer || layer->costs.size() != store_.geometry()->vertexCount()) {
    return false;
  }
  cost_summary_ = layer->summary;
  cost_limits_ = properties_.customLimits() ? properties_.limits() : cost_summary_.limits;
  const auto colors = [layer, scale = properties_.colorScale(), limits = cost_limits_](
                          const std::uint32_t* sources, std::size_t count, Rgba8* values) {
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = costColor(scale, limits, layer->costs[sources[i]]);
    }
  };
  visual_->setColors(colors, false);
  return true;
}

bool MeshPainter::uploadColors()
{
  const ColorLayerConstPtr layer = store_.colors();
  if (!layer || layer->colors.size() != store_.geometry()->vertexCount()) {
    return false;
  }
  const bool translucent = std::any_of(layer->colors.begin(), layer->colors.end(),
                                       [](const Rgba8& color) { return color.alpha < 255; });
  const auto colors = [layer](const std::uint32_t* sources, std::size_t count, Rgba8* values) {
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = layer->colors[sources[i]];
    }
  };
  visual_->setColors(colors, translucent);
  return true;
}

}  // namespace rviz_mesh_plugin
