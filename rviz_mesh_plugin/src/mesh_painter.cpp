#include "rviz_mesh_plugin/mesh_painter.h"

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
    visual_->setGeometry(mesh);
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
  cost_summary_ = summarizeCosts(layer->costs);
  cost_limits_ = properties_.customLimits() ? properties_.limits() : cost_summary_.limits;
  visual_->setColors(costColors(properties_.colorScale(), cost_limits_, layer->costs));
  return true;
}

bool MeshPainter::uploadColors()
{
  const ColorLayerConstPtr layer = store_.colors();
  if (!layer || layer->colors.size() != store_.geometry()->vertexCount()) {
    return false;
  }
  visual_->setColors(layer->colors);
  return true;
}

}  // namespace rviz_mesh_plugin
