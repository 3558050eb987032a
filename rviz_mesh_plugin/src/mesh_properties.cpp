#include "rviz_mesh_plugin/mesh_properties.h"

#include <QColor>

#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/message_traits.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>

namespace rviz_mesh_plugin {
namespace {

const char* const NO_COSTS = "-- None --";
const Ogre::ColourValue MISSING_COLORS{0.6f, 0.6f, 0.6f, 1.0f};

template <class Message>
QString dataType()
{
  return QString::fromLatin1(ros::message_traits::datatype<Message>());
}

Ogre::ColourValue color(const rviz::ColorProperty* property, const rviz::FloatProperty* alpha)
{
  Ogre::ColourValue value = property->getOgreColor();
  value.a = alpha->getFloat();
  return value;
}

rviz::FloatProperty* addAlpha(const char* name, const char* what, rviz::Property* parent,
                              QObject* receiver)
{
  auto* alpha = new rviz::FloatProperty(
      name, 1.0f, QString("Opacity of the %1: 0 is invisible, 1 opaque.").arg(what), parent,
      SIGNAL(styleChanged()), receiver);
  alpha->setMin(0.0f);
  alpha->setMax(1.0f);
  return alpha;
}

}  // namespace

MeshProperties::MeshProperties(rviz::Property* parent) : QObject(parent)
{
  geometry_topic_ =
      new rviz::RosTopicProperty("Geometry Topic", "", dataType<mesh_msgs::MeshGeometryStamped>(),
                                 "The mesh.", parent, SIGNAL(geometryTopicChanged()), this);
  display_type_ =
      new rviz::EnumProperty("Display Type", "Fixed Color", "What the faces are colored by.",
                             parent, SLOT(onDisplayType()), this);
  display_type_->addOption("Fixed Color", static_cast<int>(DisplayType::FIXED_COLOR));
  display_type_->addOption("Vertex Color", static_cast<int>(DisplayType::VERTEX_COLOR));
  display_type_->addOption("Textures", static_cast<int>(DisplayType::TEXTURES));
  display_type_->addOption("Vertex Costs", static_cast<int>(DisplayType::VERTEX_COSTS));
  display_type_->addOption("Hide Faces", static_cast<int>(DisplayType::HIDE_FACES));
  addFaces(display_type_);
  addCosts(display_type_);
  addLines(parent);
  onDisplayType();
}

void MeshProperties::addFaces(rviz::Property* parent)
{
  faces_color_ = new rviz::ColorProperty("Faces Color", QColor(0, 255, 0), "Color of all faces.",
                                         parent, SIGNAL(styleChanged()), this);
  faces_alpha_ = addAlpha("Faces Alpha", "faces", parent, this);
  colors_topic_ = new rviz::RosTopicProperty(
      "Vertex Colors Topic", "", dataType<mesh_msgs::MeshVertexColorsStamped>(),
      "The colors of the vertices.", parent, SIGNAL(colorsTopicChanged()), this);
}

void MeshProperties::addCosts(rviz::Property* parent)
{
  color_scale_ = new rviz::EnumProperty("Color Scale", "Rainbow",
                                        "The colors from the lower to the upper limit.", parent,
                                        SIGNAL(coloringChanged()), this);
  color_scale_->addOption("Rainbow", static_cast<int>(ColorScale::RAINBOW));
  color_scale_->addOption("Red Green", static_cast<int>(ColorScale::RED_GREEN));
  costs_topic_ = new rviz::RosTopicProperty(
      "Vertex Costs Topic", "", dataType<mesh_msgs::MeshVertexCostsStamped>(), "The cost layers.",
      parent, SIGNAL(costsTopicChanged()), this);
  costs_type_ =
      new rviz::EnumProperty("Vertex Costs Type", NO_COSTS, "The cost layer that is shown.", parent,
                             SIGNAL(coloringChanged()), this);
  costs_type_->addOption(NO_COSTS);
  custom_limits_ = new rviz::BoolProperty(
      "Use Custom limits", false,
      "Whether the scale runs from the least to the greatest finite cost, or as given.", parent,
      SIGNAL(coloringChanged()), this);
  custom_limits_->setDisableChildrenIfFalse(true);
  lower_limit_ =
      new rviz::FloatProperty("Vertex Costs Lower Limit", 0.0f, "The cost with the first color.",
                              custom_limits_, SIGNAL(coloringChanged()), this);
  upper_limit_ =
      new rviz::FloatProperty("Vertex Costs Upper Limit", 1.0f, "The cost with the last color.",
                              custom_limits_, SIGNAL(coloringChanged()), this);
}

void MeshProperties::addLines(rviz::Property* parent)
{
  show_wireframe_ = new rviz::BoolProperty("Show Wireframe", true, "Draw the edges.", parent,
                                           SIGNAL(styleChanged()), this);
  show_wireframe_->setDisableChildrenIfFalse(true);
  wireframe_color_ = new rviz::ColorProperty("Wireframe Color", Qt::black, "Color of the edges.",
                                             show_wireframe_, SIGNAL(styleChanged()), this);
  wireframe_alpha_ = addAlpha("Wireframe Alpha", "edges", show_wireframe_, this);
  show_normals_ =
      new rviz::BoolProperty("Show Normals", true, "Draw a line along the normal of each vertex.",
                             parent, SIGNAL(styleChanged()), this);
  show_normals_->setDisableChildrenIfFalse(true);
  normals_color_ =
      new rviz::ColorProperty("Normals Color", QColor(255, 0, 255), "Color of the normals.",
                              show_normals_, SIGNAL(styleChanged()), this);
  normals_alpha_ = addAlpha("Normals Alpha", "normals", show_normals_, this);
  normals_scale_ =
      new rviz::FloatProperty("Normals Scaling Factor", 0.1f, "Length of the normals in meters.",
                              show_normals_, SIGNAL(styleChanged()), this);
}

void MeshProperties::onDisplayType()
{
  const DisplayType type = displayType();
  // Textures are not drawn yet: the faces have their fixed color then.
  const bool fixed = type == DisplayType::FIXED_COLOR || type == DisplayType::TEXTURES;
  faces_color_->setHidden(!fixed);
  faces_alpha_->setHidden(!fixed);
  colors_topic_->setHidden(type != DisplayType::VERTEX_COLOR);
  for (rviz::Property* property :
       {static_cast<rviz::Property*>(color_scale_), static_cast<rviz::Property*>(costs_topic_),
        static_cast<rviz::Property*>(costs_type_), static_cast<rviz::Property*>(custom_limits_)}) {
    property->setHidden(type != DisplayType::VERTEX_COSTS);
  }
  Q_EMIT coloringChanged();
}

std::string MeshProperties::geometryTopic() const
{
  return geometry_topic_->getTopicStd();
}

std::string MeshProperties::colorsTopic() const
{
  return colors_topic_->getTopicStd();
}

std::string MeshProperties::costsTopic() const
{
  return costs_topic_->getTopicStd();
}

void MeshProperties::setGeometryTopic(const QString& topic)
{
  geometry_topic_->setString(topic);
}

DisplayType MeshProperties::displayType() const
{
  return static_cast<DisplayType>(display_type_->getOptionInt());
}

ColorScale MeshProperties::colorScale() const
{
  return static_cast<ColorScale>(color_scale_->getOptionInt());
}

std::string MeshProperties::costsType() const
{
  const std::string type = costs_type_->getStdString();
  return type == NO_COSTS ? std::string() : type;
}

void MeshProperties::setCostsTypes(const std::vector<std::string>& types)
{
  costs_type_->clearOptions();
  costs_type_->addOption(NO_COSTS);
  for (const std::string& type : types) {
    costs_type_->addOptionStd(type);
  }
}

bool MeshProperties::customLimits() const
{
  return custom_limits_->getBool();
}

CostLimits MeshProperties::limits() const
{
  return {lower_limit_->getFloat(), upper_limit_->getFloat()};
}

MeshStyle MeshProperties::style(bool colors_at_hand) const
{
  MeshStyle style;
  const DisplayType type = displayType();
  if (type == DisplayType::HIDE_FACES) {
    style.faces = MeshStyle::Faces::HIDDEN;
  } else if (type == DisplayType::VERTEX_COLOR || type == DisplayType::VERTEX_COSTS) {
    style.faces = colors_at_hand ? MeshStyle::Faces::VERTEX_COLORS : MeshStyle::Faces::FIXED_COLOR;
    style.faces_color = MISSING_COLORS;
  } else {
    style.faces_color = color(faces_color_, faces_alpha_);
  }
  style.show_wireframe = show_wireframe_->getBool();
  style.wireframe_color = color(wireframe_color_, wireframe_alpha_);
  style.show_normals = show_normals_->getBool();
  style.normals_color = color(normals_color_, normals_alpha_);
  style.normals_length = normals_scale_->getFloat();
  return style;
}

}  // namespace rviz_mesh_plugin
