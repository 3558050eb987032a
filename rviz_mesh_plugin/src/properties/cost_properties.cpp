#include "properties/cost_properties.h"

#include <algorithm>

#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

namespace rviz_mesh_plugin {
namespace {

const char* const NO_COSTS = "-- None --";
/// The layer of mesh_map in which all others are put together.
const char* const COMBINED_COSTS = "Combined Costs";

/// More would leave nothing between both ends.
constexpr float MAX_CLIPPED = 49.0f;

}  // namespace

CostProperties::CostProperties(rviz::Property* parent) : QObject(parent)
{
  const int first = parent->numChildren();
  const PropertyMaker make(this, [this] { Q_EMIT coloringChanged(); });
  std::vector<const char*> scales;
  for (const NamedColorScale& scale : colorScales()) {
    scales.push_back(scale.name);
  }
  color_scale_ =
      coloring_.bind(make.choice("Color Scale", "Rainbow",
                                 "The colors from the lower to the upper limit.", parent, scales),
                     &CostColoring::scale);
  addTopics(parent);
  costs_type_ = make.choice("Vertex Costs Type", NO_COSTS, "The cost layer that is shown.", parent,
                            {NO_COSTS});
  addScale(make, parent);
  addColors(make, parent);
  addLegend(parent);
  for (int i = first; i < parent->numChildren(); ++i) {
    all_.push_back(parent->childAt(i));
  }
  scale_ = {color_scale_, custom_limits_, invert_, legend_};
}

void CostProperties::addTopics(rviz::Property* parent)
{
  const PropertyMaker make(this, [this] { Q_EMIT topicsChanged(); });
  costs_topic_ = make.topic<mesh_msgs::MeshVertexCostsStamped>(
      "Vertex Costs Topic", "The cost layers, one message each.", parent);
  update_topic_ = make.topic<mesh_msgs::MeshVertexCostsSparseStamped>(
      "Update Topic",
      "Changes of single costs. Where this is empty: \"updates\" below the Vertex Costs Topic.",
      parent);
  face_costs_topic_ = make.topic<mesh_msgs::MeshFaceCostsStamped>(
      "Face Costs Topic", "Cost layers with one cost per face, one message each.", parent);
}

void CostProperties::addScale(const PropertyMaker& make, rviz::Property* parent)
{
  custom_limits_ = coloring_.bind(
      make.group("Use Custom limits", false,
                 "Whether the scale runs from the least to the greatest finite cost, or as given.",
                 parent),
      &CostColoring::custom_limits);
  connect(custom_limits_, &rviz::Property::changed, this, &CostProperties::updateHidden);
  coloring_.bind(make.number("Vertex Costs Lower Limit", 0.0f, "The cost with the first color.",
                             custom_limits_),
                 [](CostColoring& coloring) -> float& { return coloring.limits.lower; });
  coloring_.bind(make.number("Vertex Costs Upper Limit", 1.0f, "The cost with the last color.",
                             custom_limits_),
                 [](CostColoring& coloring) -> float& { return coloring.limits.upper; });
  clip_percentile_ = coloring_.bind(
      make.number("Clip Percentile", 0.0f,
                  "Percent of the finite costs left out at each end of the automatic limits: a few "
                  "outliers do not take all colors then.",
                  parent, 0.0f, MAX_CLIPPED),
      &CostColoring::clipped);
  invert_ = coloring_.bind(make.box("Invert Colors", false, "Let the scale run backwards.", parent),
                           &CostColoring::inverted);
  coloring_.bind(make.box("Logarithmic", false,
                          "Equal ratios of costs get equal distances on the scale. Costs that are "
                          "not above 0 get the color of the lower limit.",
                          parent),
                 &CostColoring::logarithmic);
}

void CostProperties::addColors(const PropertyMaker& make, rviz::Property* parent)
{
  const auto add = [&](const char* name, Rgba8 CostColoring::*color, const char* description,
                       rviz::Property* above) {
    coloring_.bind(make.color(name, toQColor(CostColoring().*color), description, above), color);
  };
  add("Lethal Color", &CostColoring::lethal, "Color of infinite costs.", parent);
  coloring_.bind(make.box("Mark Lethal", true,
                          "Give costs that the map calls lethal, such as those above the threshold "
                          "of their layer, the Lethal Color, too.",
                          parent),
                 &CostColoring::mark_lethal);
  add("Unknown Color", &CostColoring::unknown, "Color of costs that are NaN.", parent);
  rviz::Property* outside = coloring_.bind(
      make.group("Mark Outside Limits", false,
                 "Give costs outside the limits colors of their own, instead of those of the "
                 "scale's ends.",
                 parent),
      &CostColoring::mark_outside);
  add("Below Color", &CostColoring::below, "Color of costs below the limits.", outside);
  add("Above Color", &CostColoring::above, "Color of costs above the limits.", outside);
}

void CostProperties::addLegend(rviz::Property* parent)
{
  const PropertyMaker make(this, [this] { Q_EMIT legendChanged(); });
  legend_ = make.group("Legend", true, "Show the scale with its costs at the right of the 3D view.",
                       parent);
  unit_ = make.line(
      "Unit", "",
      "Of the costs, for the legend: m, rad, ... Where this is empty, what the map says.", legend_);
}

std::string CostProperties::updateTopic() const
{
  const std::string topic = update_topic_->getTopicStd();
  return topic.empty() && !costsTopic().empty() ? costsTopic() + "/updates" : topic;
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
  if (chooses_) {
    chooseLayer();
  }
}

void CostProperties::chooseLayer()
{
  chooses_ = costsType() == (chooses_ ? own_choice_ : std::string());
  if (!chooses_) {
    return;
  }
  own_choice_ = costsType();
  const bool combined = std::find(types_.begin(), types_.end(), COMBINED_COSTS) != types_.end();
  if (combined || (own_choice_.empty() && !types_.empty())) {
    own_choice_ = combined ? COMBINED_COSTS : types_.front();
    choosing_ = true;
    costs_type_->setStdString(own_choice_);
    choosing_ = false;
  }
}

void CostProperties::forgetLayer()
{
  if (chooses_ && costsType() == own_choice_) {
    costs_type_->setString(NO_COSTS);
  }
  chooses_ = false;
}

void CostProperties::setScale(ColorScale scale)
{
  for (const NamedColorScale& named : colorScales()) {
    if (named.scale == scale) {
      color_scale_->setString(named.name);
    }
  }
}

void CostProperties::setSeen(Seen seen)
{
  seen_ = seen;
  updateHidden();
}

void CostProperties::setTopicsHidden(bool hidden)
{
  topics_hidden_ = hidden;
  updateHidden();
}

void CostProperties::updateHidden()
{
  for (rviz::Property* property : all_) {
    const bool is_topic = qobject_cast<rviz::RosTopicProperty*>(property) != nullptr;
    const bool is_of_scale = std::find(scale_.begin(), scale_.end(), property) != scale_.end();
    property->setHidden(seen_ == Seen::NONE || (seen_ == Seen::SCALE && !is_of_scale) ||
                        (is_topic && topics_hidden_) ||
                        (property == clip_percentile_ && custom_limits_->getBool()));
  }
}

}  // namespace rviz_mesh_plugin
