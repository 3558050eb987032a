#pragma once

#include <string>
#include <vector>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "coloring/cost_coloring.h"
#endif

namespace rviz {
class BoolProperty;
class ColorProperty;
class EnumProperty;
class FloatProperty;
class Property;
class RosTopicProperty;
class StringProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// The properties of the display type Vertex Costs: which layers there are, which is shown, and in
/// which colors. Names, types and defaults are those of .rviz files in the field.
class CostProperties : public QObject
{
  Q_OBJECT

 public:
  /// Adds the properties to @a parent ("Display Type"), which owns them from then on.
  explicit CostProperties(rviz::Property* parent);

  std::string costsTopic() const;
  std::string faceCostsTopic() const;
  /// Of sparse updates: "<costs topic>/updates" where none is given, empty without a costs topic.
  std::string updateTopic() const;
  void setCostsTopic(const std::string& topic);
  void setFaceCostsTopic(const std::string& topic);

  /// Name of the chosen cost layer, empty for "-- None --".
  std::string costsType() const;

  /// Fills the list of "Vertex Costs Type"; the choice stays, even if it is not among them (yet).
  void setCostsTypes(const std::vector<std::string>& types);

  CostColoring coloring() const;
  bool legend() const;
  std::string unit() const;

  /// Hides all of them: another display type is chosen.
  void setHidden(bool hidden);
  /// Hides the topics for good: another display decides them.
  void setTopicsHidden(bool hidden);

 Q_SIGNALS:
  void topicsChanged();
  void coloringChanged();  ///< which layer is shown, or in which colors
  void legendChanged();    ///< whether there is a legend, or the unit

 private Q_SLOTS:
  void onCustomLimits();

 private:
  void updateHidden();
  void addTopics(rviz::Property* parent);
  void addScale(rviz::Property* parent);
  void addColors(rviz::Property* parent);
  void addLegend(rviz::Property* parent);

  bool hidden_ = false;
  bool topics_hidden_ = false;
  std::vector<std::string> types_;
  rviz::EnumProperty* color_scale_;
  rviz::RosTopicProperty* costs_topic_;
  rviz::RosTopicProperty* update_topic_;
  rviz::RosTopicProperty* face_costs_topic_;
  rviz::EnumProperty* costs_type_;
  rviz::BoolProperty* custom_limits_;
  rviz::FloatProperty* lower_limit_;
  rviz::FloatProperty* upper_limit_;
  rviz::FloatProperty* clip_percentile_;
  rviz::BoolProperty* inverted_;
  rviz::BoolProperty* logarithmic_;
  rviz::ColorProperty* lethal_color_;
  rviz::ColorProperty* unknown_color_;
  rviz::BoolProperty* mark_outside_;
  rviz::ColorProperty* below_color_;
  rviz::ColorProperty* above_color_;
  rviz::BoolProperty* legend_;
  rviz::StringProperty* unit_;
};

}  // namespace rviz_mesh_plugin
