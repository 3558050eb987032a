#include "rviz_mesh_plugin/textured_mesh_display.h"

#include <OgreQuaternion.h>
#include <OgreSceneNode.h>

#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/validate_floats.h>

#include "rviz_mesh_plugin/mesh_painter.h"
#include "rviz_mesh_plugin/mesh_properties.h"
#include "rviz_mesh_plugin/mesh_visual.h"

namespace rviz_mesh_plugin {

TexturedMeshDisplay::TexturedMeshDisplay()
    : properties_(new MeshProperties(this)), inbox_(std::make_shared<MeshInbox>()), topics_(inbox_)
{
}

TexturedMeshDisplay::~TexturedMeshDisplay()
{
  topics_.unsubscribe();
}

void TexturedMeshDisplay::onInitialize()
{
  painter_ = std::make_unique<MeshPainter>(store_, *properties_, scene_manager_, scene_node_);
  connect(properties_, SIGNAL(geometryTopicChanged()), SLOT(onGeometryTopic()));
  connect(properties_, SIGNAL(colorsTopicChanged()), SLOT(onColorsTopic()));
  connect(properties_, SIGNAL(costsTopicChanged()), SLOT(onCostsTopic()));
  connect(properties_, SIGNAL(coloringChanged()), SLOT(onColoring()));
  connect(properties_, SIGNAL(styleChanged()), SLOT(onStyle()));
}

const MeshVisual* TexturedMeshDisplay::visual() const
{
  return painter_ ? painter_->visual() : nullptr;
}

void TexturedMeshDisplay::setTopic(const QString& topic, const QString& /*datatype*/)
{
  properties_->setGeometryTopic(topic);
}

void TexturedMeshDisplay::onEnable()
{
  subscribe();
  showGeometry();
}

void TexturedMeshDisplay::onDisable()
{
  topics_.unsubscribe();
  painter_->clear();
  clearStatuses();
  lines_.clear();
}

void TexturedMeshDisplay::reset()
{
  Display::reset();
  lines_.clear();
  topics_.unsubscribe();
  inbox_->clearGeometry();
  inbox_->clearCosts();
  inbox_->clearColors();
  store_.clear();
  properties_->setCostsTypes({});
  painter_->clear();
  if (isEnabled()) {
    subscribe();
  }
}

void TexturedMeshDisplay::subscribe()
{
  geometry_subscription_error_ =
      topics_.subscribeGeometry(threaded_nh_, properties_->geometryTopic());
  costs_subscription_error_ = topics_.subscribeCosts(threaded_nh_, properties_->costsTopic());
  colors_subscription_error_ = topics_.subscribeColors(threaded_nh_, properties_->colorsTopic());
}

void TexturedMeshDisplay::onGeometryTopic()
{
  topics_.subscribeGeometry(threaded_nh_, "");
  inbox_->clearGeometry();
  store_.setGeometry(nullptr);
  showGeometry();
  if (isEnabled()) {
    geometry_subscription_error_ =
        topics_.subscribeGeometry(threaded_nh_, properties_->geometryTopic());
  }
}

void TexturedMeshDisplay::onCostsTopic()
{
  topics_.subscribeCosts(threaded_nh_, "");
  inbox_->clearCosts();
  store_.clearCosts();
  properties_->setCostsTypes({});
  onColoring();
  if (isEnabled()) {
    costs_subscription_error_ = topics_.subscribeCosts(threaded_nh_, properties_->costsTopic());
  }
}

void TexturedMeshDisplay::onColorsTopic()
{
  topics_.subscribeColors(threaded_nh_, "");
  inbox_->clearColors();
  store_.clearColors();
  onColoring();
  if (isEnabled()) {
    colors_subscription_error_ = topics_.subscribeColors(threaded_nh_, properties_->colorsTopic());
  }
}

void TexturedMeshDisplay::onColoring()
{
  painter_->paintColors();
  objectsChanged();
}

void TexturedMeshDisplay::onStyle()
{
  painter_->paintStyle();
  objectsChanged();
}

void TexturedMeshDisplay::update(float /*wall_dt*/, float /*ros_dt*/)
{
  takeMessages();
  updatePose();
  updateStatuses();
}

void TexturedMeshDisplay::takeMessages()
{
  const InboxContent content = inbox_->take();
  geometry_reception_ = content.geometry_reception;
  costs_reception_ = content.costs_reception;
  colors_reception_ = content.colors_reception;
  if (content.geometry) {
    store_.setGeometry(content.geometry);
  }
  const std::string shown = store_.geometry() ? store_.geometry()->uuid : std::string();
  const DisplayType type = properties_->displayType();
  bool recolor = false;
  for (const CostLayerConstPtr& layer : content.costs) {
    store_.addCosts(layer);
    recolor |= type == DisplayType::VERTEX_COSTS && layer->uuid == shown &&
               layer->type == properties_->costsType();
  }
  for (const ColorLayerConstPtr& layer : content.colors) {
    store_.addColors(layer);
    recolor |= type == DisplayType::VERTEX_COLOR && layer->uuid == shown;
  }
  if (content.geometry || !content.costs.empty()) {
    properties_->setCostsTypes(store_.costTypes());
  }
  if (content.geometry) {
    showGeometry();
  } else if (recolor) {
    onColoring();
  }
}

void TexturedMeshDisplay::showGeometry()
{
  if (isEnabled()) {
    painter_->paintGeometry();
  } else {
    painter_->clear();
  }
  objectsChanged();
}

void TexturedMeshDisplay::objectsChanged()
{
  setVisibilityBits(getVisibilityBits());  // for the objects that are new
  queueRender();
}

void TexturedMeshDisplay::updatePose()
{
  MeshVisual* visual = painter_->visual();
  if (!visual) {
    report("Transform", std::nullopt);
    return;
  }
  const std::string& frame = store_.geometry()->frame_id;
  rviz::FrameManager* frames = context_->getFrameManager();
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  // The newest transform: a mesh is a map, its stamp tells when it was made.
  const bool known = frames->getTransform(frame, ros::Time(), position, orientation);
  const bool finite = known && rviz::validateFloats(position) && rviz::validateFloats(orientation);
  visual->setVisible(finite);
  if (finite) {
    orientation.normalise();
    visual->setPose(position, orientation);
    report("Transform",
           StatusLine{StatusLine::OK, "frame '" + frame + "' is known in the fixed frame '" +
                                          frames->getFixedFrame() + "'"});
    return;
  }
  std::string reason = "the transform contains NaN or infinity";
  if (!known && !frames->transformHasProblems(frame, ros::Time(), reason)) {
    reason = "nobody publishes it yet";
  }
  report("Transform",
         StatusLine{StatusLine::ERROR, "no transform from frame '" + frame +
                                           "' to the fixed frame '" + frames->getFixedFrame() +
                                           "', the mesh is hidden until then: " + reason});
}

void TexturedMeshDisplay::updateStatuses()
{
  report("Topic", topicStatus(properties_->geometryTopic(), geometry_subscription_error_,
                              geometry_reception_));
  if (painter_->error().empty()) {
    report("Geometry", geometryStatus(store_.geometry(), geometry_reception_,
                                      properties_->style(false).show_normals));
  } else {
    report("Geometry",
           StatusLine{StatusLine::ERROR, "the mesh cannot be drawn: " + painter_->error()});
  }
  report("Costs", costsStatus(costsState()));
  report("Colors", colorsStatus(colorsState()));
  if (properties_->displayType() == DisplayType::TEXTURES) {
    report(
        "Textures",
        StatusLine{StatusLine::WARN,
                   "textures are not drawn by this version; the faces have 'Faces Color' instead"});
  } else {
    report("Textures", std::nullopt);
  }
}

CostsState TexturedMeshDisplay::costsState() const
{
  CostsState state;
  state.chosen = properties_->displayType() == DisplayType::VERTEX_COSTS;
  state.topic = properties_->costsTopic();
  state.subscription_error = costs_subscription_error_;
  state.reception = costs_reception_;
  state.mesh_shown = store_.geometry() != nullptr;
  state.vertex_count = state.mesh_shown ? store_.geometry()->vertexCount() : 0;
  state.waiting = store_.waitingCosts();
  state.type = properties_->costsType();
  state.types = store_.costTypes();
  state.summary = painter_->costSummary();
  state.limits = painter_->costLimits();
  if (const CostLayerConstPtr layer = store_.costs(state.type)) {
    state.size = layer->costs.size();
  }
  return state;
}

AttributeState TexturedMeshDisplay::colorsState() const
{
  AttributeState state;
  state.chosen = properties_->displayType() == DisplayType::VERTEX_COLOR;
  state.topic = properties_->colorsTopic();
  state.subscription_error = colors_subscription_error_;
  state.reception = colors_reception_;
  state.mesh_shown = store_.geometry() != nullptr;
  state.vertex_count = state.mesh_shown ? store_.geometry()->vertexCount() : 0;
  state.waiting = store_.waitingColors();
  if (const ColorLayerConstPtr layer = store_.colors()) {
    state.size = layer->colors.size();
  }
  return state;
}

void TexturedMeshDisplay::report(const char* name, const OptionalStatus& status)
{
  const auto shown = lines_.find(name);
  if (!status) {
    if (shown != lines_.end()) {
      lines_.erase(shown);
      deleteStatus(name);
    }
    return;
  }
  if (shown != lines_.end() && shown->second.level == status->level &&
      shown->second.text == status->text) {
    return;
  }
  lines_[name] = *status;
  setStatusStd(static_cast<rviz::StatusProperty::Level>(status->level), name, status->text);
}

}  // namespace rviz_mesh_plugin
