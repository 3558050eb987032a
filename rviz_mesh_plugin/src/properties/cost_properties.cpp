#include "properties/cost_properties.h"

#include <cmath>
#include <initializer_list>

#include <QColor>

#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/message_traits.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>

namespace rviz_mesh_plugin {
namespace {

const char* const NO_COSTS = "-- None --";

/// More would leave nothing between both ends.
constexpr float MAX_CLIPPED = 49.0f;

template <class Message>
QString dataType()
{
  return QString::fromLatin1(ros::message_traits::datatype<Message>());
}

QColor toQColor(const Rgba8& color)
{
  return {color.red, color.green, color.blue};
}

Rgba8 fromProperty(const rviz::ColorProperty* property)
{
  const QColor color = property->getColor();
  return {static_cast<std::uint8_t>(color.red()), static_cast<std::uint8_t>(color.green()),
          static_cast<std::uint8_t>(color.blue()), 255};
}

}  // namespace

CostProperties::CostProperties(rviz::Property* parent) : QObject(parent)
{
  color_scale_ = new rviz::EnumProperty("Color Scale", "Rainbow",
                                        "The colors from the lower to the upper limit.", parent,
                                        SIGNAL(coloringChanged()), this);
  for (const NamedColorScale& scale : colorScales()) {
    color_scale_->addOption(scale.name, static_cast<int>(scale.scale));
  }
  addTopics(parent);
  addScale(parent);
  addColors(parent);
  addLegend(parent);
}

void CostProperties::addTopics(rviz::Property* parent)
{
  costs_topic_ = new rviz::RosTopicProperty(
      "Vertex Costs Topic", "", dataType<mesh_msgs::MeshVertexCostsStamped>(),
      "The cost layers, one message each.", parent, SIGNAL(topicsChanged()), this);
  update_topic_ = new rviz::RosTopicProperty(
      "Update Topic", "", dataType<mesh_msgs::MeshVertexCostsSparseStamped>(),
      "Changes of single costs. Where this is empty: \"updates\" below the Vertex Costs Topic.",
      parent, SIGNAL(topicsChanged()), this);
  face_costs_topic_ = new rviz::RosTopicProperty(
      "Face Costs Topic", "", dataType<mesh_msgs::MeshFaceCostsStamped>(),
      "Cost layers with one cost per face, one message each.", parent, SIGNAL(topicsChanged()),
      this);
  costs_type_ =
      new rviz::EnumProperty("Vertex Costs Type", NO_COSTS, "The cost layer that is shown.", parent,
                             SIGNAL(coloringChanged()), this);
  costs_type_->addOption(NO_COSTS);
}

void CostProperties::addScale(rviz::Property* parent)
{
  custom_limits_ = new rviz::BoolProperty(
      "Use Custom limits", false,
      "Whether the scale runs from the least to the greatest finite cost, or as given.", parent,
      SLOT(onCustomLimits()), this);
  custom_limits_->setDisableChildrenIfFalse(true);
  lower_limit_ =
      new rviz::FloatProperty("Vertex Costs Lower Limit", 0.0f, "The cost with the first color.",
                              custom_limits_, SIGNAL(coloringChanged()), this);
  upper_limit_ =
      new rviz::FloatProperty("Vertex Costs Upper Limit", 1.0f, "The cost with the last color.",
                              custom_limits_, SIGNAL(coloringChanged()), this);
  clip_percentile_ = new rviz::FloatProperty(
      "Clip Percentile", 0.0f,
      "Percent of the finite costs left out at each end of the automatic limits: a few outliers "
      "do not take all colors then.",
      parent, SIGNAL(coloringChanged()), this);
  clip_percentile_->setMin(0.0f);
  clip_percentile_->setMax(MAX_CLIPPED);
  inverted_ = new rviz::BoolProperty("Invert Colors", false, "Let the scale run backwards.", parent,
                                     SIGNAL(coloringChanged()), this);
  logarithmic_ = new rviz::BoolProperty(
      "Logarithmic", false,
      "Equal ratios of costs get equal distances on the scale. Costs that are not above 0 get the "
      "color of the lower limit.",
      parent, SIGNAL(coloringChanged()), this);
}

void CostProperties::addColors(rviz::Property* parent)
{
  const CostColoring defaults;
  const auto add = [this](const char* name, const Rgba8& color, const char* description,
                          rviz::Property* above) {
    return new rviz::ColorProperty(name, toQColor(color), description, above,
                                   SIGNAL(coloringChanged()), this);
  };
  lethal_color_ = add("Lethal Color", defaults.lethal, "Color of infinite costs.", parent);
  unknown_color_ = add("Unknown Color", defaults.unknown, "Color of costs that are NaN.", parent);
  mark_outside_ = new rviz::BoolProperty(
      "Mark Outside Limits", false,
      "Give costs outside the limits colors of their own, instead of those of the scale's ends.",
      parent, SIGNAL(coloringChanged()), this);
  mark_outside_->setDisableChildrenIfFalse(true);
  below_color_ =
      add("Below Color", defaults.below, "Color of costs below the limits.", mark_outside_);
  above_color_ =
      add("Above Color", defaults.above, "Color of costs above the limits.", mark_outside_);
}

void CostProperties::addLegend(rviz::Property* parent)
{
  legend_ = new rviz::BoolProperty("Legend", true,
                                   "Show the scale with its costs at the right of the 3D view.",
                                   parent, SIGNAL(legendChanged()), this);
  legend_->setDisableChildrenIfFalse(true);
  unit_ = new rviz::StringProperty("Unit", "", "Of the costs, for the legend: m, rad, ...", legend_,
                                   SIGNAL(legendChanged()), this);
}

std::string CostProperties::costsTopic() const
{
  return costs_topic_->getTopicStd();
}

std::string CostProperties::faceCostsTopic() const
{
  return face_costs_topic_->getTopicStd();
}

std::string CostProperties::updateTopic() const
{
  const std::string topic = update_topic_->getTopicStd();
  if (!topic.empty() || costsTopic().empty()) {
    return topic;
  }
  return costsTopic() + "/updates";
}

void CostProperties::setCostsTopic(const std::string& topic)
{
  costs_topic_->setStdString(topic);
}

void CostProperties::setFaceCostsTopic(const std::string& topic)
{
  face_costs_topic_->setStdString(topic);
}

std::string CostProperties::costsType() const
{
  const std::string type = costs_type_->getStdString();
  return type == NO_COSTS ? std::string() : type;
}

void CostProperties::setCostsTypes(const std::vector<std::string>& types)
{
  if (types == types_) {
    return;  // an open list of choices stays as it is
  }
  types_ = types;
  costs_type_->clearOptions();
  costs_type_->addOption(NO_COSTS);
  for (const std::string& type : types) {
    costs_type_->addOptionStd(type);
  }
}

CostColoring CostProperties::coloring() const
{
  const auto finite = [](float value, float otherwise) {
    return std::isfinite(value) ? value : otherwise;
  };
  CostColoring coloring;
  // -1 where a file names a scale that does not exist here.
  const int scale = color_scale_->getOptionInt();
  coloring.scale = colorScales()[scale < 0 ? 0 : static_cast<std::size_t>(scale)].scale;
  coloring.inverted = inverted_->getBool();
  coloring.logarithmic = logarithmic_->getBool();
  coloring.custom_limits = custom_limits_->getBool();
  coloring.limits = {finite(lower_limit_->getFloat(), 0.0f),
                     finite(upper_limit_->getFloat(), 1.0f)};
  coloring.clipped = finite(clip_percentile_->getFloat(), 0.0f);
  coloring.lethal = fromProperty(lethal_color_);
  coloring.unknown = fromProperty(unknown_color_);
  coloring.mark_outside = mark_outside_->getBool();
  coloring.below = fromProperty(below_color_);
  coloring.above = fromProperty(above_color_);
  return coloring;
}

bool CostProperties::legend() const
{
  return legend_->getBool();
}

std::string CostProperties::unit() const
{
  return unit_->getStdString();
}

void CostProperties::setHidden(bool hidden)
{
  hidden_ = hidden;
  updateHidden();
}

void CostProperties::setTopicsHidden(bool hidden)
{
  topics_hidden_ = hidden;
  updateHidden();
}

void CostProperties::onCustomLimits()
{
  updateHidden();
  Q_EMIT coloringChanged();
}

void CostProperties::updateHidden()
{
  for (rviz::Property* property : std::initializer_list<rviz::Property*>{
           color_scale_, costs_type_, custom_limits_, inverted_, logarithmic_, lethal_color_,
           unknown_color_, mark_outside_, legend_}) {
    property->setHidden(hidden_);
  }
  for (rviz::Property* property :
       std::initializer_list<rviz::Property*>{costs_topic_, update_topic_, face_costs_topic_}) {
    property->setHidden(hidden_ || topics_hidden_);
  }
  clip_percentile_->setHidden(hidden_ || custom_limits_->getBool());
}

}  // namespace rviz_mesh_plugin
