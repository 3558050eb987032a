#include "rviz_mesh_plugin/mesh_properties.h"

#include <algorithm>
#include <array>
#include <utility>

#include <QColor>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <ros/message_traits.h>
#include <rviz/config.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>

#include "rviz_mesh_plugin/cost_properties.h"
#include "rviz_mesh_plugin/look_properties.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::array<std::pair<const char*, DisplayType>, 5> DISPLAY_TYPES{
    {{"Fixed Color", DisplayType::FIXED_COLOR},
     {"Vertex Color", DisplayType::VERTEX_COLOR},
     {"Textures", DisplayType::TEXTURES},
     {"Vertex Costs", DisplayType::VERTEX_COSTS},
     {"Hide Faces", DisplayType::HIDE_FACES}}};

const Ogre::ColourValue MISSING_COLORS{0.6f, 0.6f, 0.6f, 1.0f};

template <class Message>
rviz::RosTopicProperty* makeTopic(const char* name, const char* description, rviz::Property* parent,
                                  QObject* receiver)
{
  return new rviz::RosTopicProperty(name, "",
                                    QString::fromLatin1(ros::message_traits::datatype<Message>()),
                                    description, parent, SIGNAL(sourceChanged()), receiver);
}

rviz::StringProperty* makeService(const char* name, const char* service, const char* of_what,
                                  rviz::Property* parent, QObject* receiver)
{
  return new rviz::StringProperty(
      name, service,
      QString("Asked for %1 that no topic brings. A name without a slash in "
              "front is looked for "
              "beside the geometry topic, in the namespaces above it and in "
              "that of RViz.")
          .arg(of_what),
      parent, SIGNAL(sourceChanged()), receiver);
}

}  // namespace

MeshProperties::MeshProperties(rviz::Property* parent) : QObject(parent)
{
  geometry_topic_ =
      makeTopic<mesh_msgs::MeshGeometryStamped>("Geometry Topic", "The mesh.", parent, this);
  buffer_size_ = new rviz::IntProperty("Buffer Size", 1,
                                       "So many meshes (by their uuid) are shown, the newest ones.",
                                       parent, SIGNAL(contentChanged()), this);
  buffer_size_->setMin(1);
  display_type_ =
      new rviz::EnumProperty("Display Type", "Fixed Color", "What the faces are colored by.",
                             parent, SLOT(onDisplayType()), this);
  addFaces(display_type_);
  addTextures(display_type_);
  costs_ = new CostProperties(display_type_);
  update_rate_ = new rviz::FloatProperty("Visualization Update Rate", 10.0f,
                                         "How often updates of costs become seen, in Hz; "
                                         "those that come in between are put together.",
                                         display_type_);
  update_rate_->setMin(1.0f);
  alpha_ = makeAlpha("Alpha", "faces", display_type_, SIGNAL(styleChanged()), this);
  look_ = new LookProperties(parent);
  addLabels(parent);
  connect(costs_, SIGNAL(topicsChanged()), SIGNAL(sourceChanged()));
  connect(costs_, SIGNAL(coloringChanged()), SIGNAL(contentChanged()));
  connect(costs_, SIGNAL(legendChanged()), SIGNAL(styleChanged()));
  connect(look_, SIGNAL(styleChanged()), SIGNAL(styleChanged()));
  onDisplayType();
}

void MeshProperties::addFaces(rviz::Property* parent)
{
  faces_color_ = new rviz::ColorProperty("Faces Color", QColor(0, 255, 0),
                                         "Color of the faces; with textures: of those without a "
                                         "material.",
                                         parent, SIGNAL(styleChanged()), this);
  faces_alpha_ = makeAlpha("Faces Alpha", "faces", parent, SIGNAL(styleChanged()), this);
  colors_topic_ = makeTopic<mesh_msgs::MeshVertexColorsStamped>(
      "Vertex Colors Topic", "The colors of the vertices.", parent, this);
  colors_service_ =
      makeService("Vertex Color Service Name", "get_vertex_colors", "vertex colors", parent, this);
}

void MeshProperties::addTextures(rviz::Property* parent)
{
  only_textured_ = new rviz::BoolProperty("Show textured faces only", false,
                                          "Leave out the faces that have no texture.", parent,
                                          SIGNAL(styleChanged()), this);
  materials_service_ =
      makeService("Material Service Name", "get_materials", "materials", parent, this);
  texture_service_ = makeService("Texture Service Name", "get_texture", "textures", parent, this);
  materials_topic_ = makeTopic<mesh_msgs::MeshMaterialsStamped>(
      "Materials Topic", "The materials of the faces, where they are published.", parent, this);
  textures_topic_ = makeTopic<mesh_msgs::MeshTexture>(
      "Textures Topic", "The images of the materials, where they are published.", parent, this);
}

void MeshProperties::addLabels(rviz::Property* parent)
{
  show_labels_ = new rviz::BoolProperty("Show Labels", false,
                                        "Draw labelled faces in the color of their label.", parent,
                                        SIGNAL(contentChanged()), this);
  show_labels_->setDisableChildrenIfFalse(true);
  labels_topic_ = new rviz::RosTopicProperty(
      "Labels Topic", "",
      QString::fromLatin1(ros::message_traits::datatype<mesh_msgs::MeshFaceCluster>()),
      "Labels as they change.", show_labels_, SIGNAL(sourceChanged()), this);
  labels_alpha_ =
      makeAlpha("Labels Alpha", "labelled faces", show_labels_, SIGNAL(contentChanged()), this);
}

void MeshProperties::onDisplayType()
{
  const DisplayType type = displayType();
  const bool own = !given_;
  const bool colors = type == DisplayType::VERTEX_COLOR;
  const bool textures = type == DisplayType::TEXTURES;
  const bool costs = type == DisplayType::VERTEX_COSTS;
  const std::pair<rviz::Property*, bool> seen[] = {
      {faces_color_, type == DisplayType::FIXED_COLOR || textures},
      {faces_alpha_, type == DisplayType::FIXED_COLOR},
      {colors_topic_, colors && own},
      {colors_service_, colors && own},
      {only_textured_, textures},
      {materials_service_, textures && own},
      {texture_service_, textures && own},
      {materials_topic_, textures && own},
      {textures_topic_, textures && own},
      {update_rate_, costs},
      {alpha_, colors || textures || costs},
  };
  for (const auto& property : seen) {
    property.first->setHidden(!property.second);
  }
  costs_->setHidden(!costs);
  offerTypes();  // the one before is offered no longer where it has no data
  Q_EMIT contentChanged();
}

void MeshProperties::offerTypes()
{
  const bool offered[] = {true, !given_ || available_.colors, !given_ || available_.materials,
                          !given_ || available_.costs, true};
  const QString chosen = display_type_->getString();
  display_type_->clearOptions();
  for (const auto& type : DISPLAY_TYPES) {
    const int number = static_cast<int>(type.second);
    // A choice from a file stays and waits for its data.
    if (offered[number] || chosen == type.first) {
      display_type_->addOption(type.first, number);
    }
  }
}

void MeshProperties::setAvailable(const AvailableData& available)
{
  if (available.colors == available_.colors && available.materials == available_.materials &&
      available.costs == available_.costs) {
    return;
  }
  available_ = available;
  offerTypes();
}

MeshSource MeshProperties::source() const
{
  if (given_) {
    return *given_;
  }
  MeshSource source;
  source.geometry_topic = geometry_topic_->getTopicStd();
  source.costs_topic = costs_->costsTopic();
  source.face_costs_topic = costs_->faceCostsTopic();
  source.colors_topic = colors_topic_->getTopicStd();
  source.labels_topic = labels_topic_->getTopicStd();
  return source;
}

void MeshProperties::setSource(const MeshSource& source)
{
  given_ = source;
  geometry_topic_->hide();
  buffer_size_->hide();
  labels_topic_->hide();
  costs_->setTopicsHidden(true);
  onDisplayType();
  Q_EMIT sourceChanged();
}

void MeshProperties::setGeometryTopic(const QString& topic)
{
  geometry_topic_->setString(topic);
}

void MeshProperties::proposeTopics(const QString& costs, const QString& colors)
{
  if (colors_topic_->getTopic().isEmpty()) {
    colors_topic_->setString(colors);
  }
  if (costs_->costsTopic().empty()) {
    costs_->setCostsTopic(costs.toStdString());
  }
}

std::string MeshProperties::updatesTopic() const
{
  if (!given_) {
    return costs_->updateTopic();
  }
  return given_->costs_topic.empty() ? std::string() : given_->costs_topic + "/updates";
}

std::string MeshProperties::materialsTopic() const
{
  return given_ ? std::string() : materials_topic_->getTopicStd();
}

std::string MeshProperties::texturesTopic() const
{
  return given_ ? std::string() : textures_topic_->getTopicStd();
}

ServiceNames MeshProperties::services() const
{
  ServiceNames names;
  names.colors = colors_service_->getStdString();
  names.materials = materials_service_->getStdString();
  names.texture = texture_service_->getStdString();
  names.geometry_topic = source().geometry_topic;
  names.service_namespace = source().service_namespace;
  return names;
}

std::size_t MeshProperties::bufferSize() const
{
  return given_ ? 1 : static_cast<std::size_t>(std::max(1, buffer_size_->getInt()));
}

DisplayType MeshProperties::displayType() const
{
  const QString chosen = display_type_->getString();
  for (const auto& type : DISPLAY_TYPES) {
    if (chosen == type.first) {
      return type.second;
    }
  }
  return DisplayType::FIXED_COLOR;
}

float MeshProperties::updateRate() const
{
  return update_rate_->getFloat();
}

bool MeshProperties::labelsShown() const
{
  return show_labels_->getBool();
}

float MeshProperties::labelsAlpha() const
{
  return labels_alpha_->getFloat();
}

bool MeshProperties::normalsShown() const
{
  return look_->normalsShown();
}

MeshStyle MeshProperties::style(bool at_hand) const
{
  MeshStyle style;
  look_->apply(style);
  style.alpha = alpha_->getFloat();
  style.only_textured = only_textured_->getBool();
  style.faces_color = faces_color_->getOgreColor();
  switch (displayType()) {
    case DisplayType::FIXED_COLOR:
      style.faces_color.a = faces_alpha_->getFloat();
      return style;
    case DisplayType::HIDE_FACES:
      style.faces = MeshStyle::Faces::HIDDEN;
      return style;
    case DisplayType::TEXTURES:
      style.faces = MeshStyle::Faces::TEXTURES;
      style.faces_color.a = style.alpha;
      break;
    default:
      style.faces = MeshStyle::Faces::VERTEX_COLORS;
  }
  if (!at_hand) {
    style.faces = MeshStyle::Faces::FIXED_COLOR;
    style.faces_color = MISSING_COLORS;
  }
  return style;
}

void MeshProperties::loadOlderKeys(const rviz::Config& config)
{
  int size = 0;
  if (!config.mapGetInt("Buffer Size", &size) && config.mapGetInt("Mesh Buffer Size", &size)) {
    buffer_size_->setInt(size);
  }
}

}  // namespace rviz_mesh_plugin
