#pragma once

#include <string>
#include <vector>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "coloring/cost_coloring.h"
#include "properties/property_maker.h"
#endif

namespace rviz_mesh_plugin {

/// The properties of the display type Vertex Costs, and of others that have a scale: which layers
/// there are, which is shown, and in which colors. Names, types and defaults are those of .rviz
/// files in the field.
class CostProperties : public QObject
{
  Q_OBJECT

 public:
  /// Adds the properties to @a parent ("Display Type"), which owns them from then on.
  explicit CostProperties(rviz::Property* parent);

  std::string costsTopic() const { return costs_topic_->getTopicStd(); }
  std::string faceCostsTopic() const { return face_costs_topic_->getTopicStd(); }
  /// Of sparse updates: "<costs topic>/updates" where none is given, empty without a costs topic.
  std::string updateTopic() const;
  void setCostsTopic(const QString& topic) { costs_topic_->setString(topic); }

  /// Name of the chosen cost layer, empty for "-- None --".
  std::string costsType() const;

  /// Fills the list of "Vertex Costs Type"; the choice stays, even if it is not among them (yet).
  void setCostsTypes(const std::vector<std::string>& types);

  CostColoring coloring() const { return coloring_.get(); }
  bool legend() const { return legend_->getBool(); }
  std::string unit() const { return unit_->getStdString(); }

  /// Chooses the combined costs, or else the first layer there is, where none is chosen; also when
  /// they come later, until somebody else chooses.
  void chooseLayer();
  /// Ends that, and takes its choice back.
  void forgetLayer();

  /// Whether coloringChanged() is of its own choice.
  bool isChoosing() const { return choosing_; }

  /// The scale that a display begins with.
  void setScale(ColorScale scale);

  /// Which of them are seen.
  enum class Seen
  {
    NONE,   ///< another display type is chosen
    SCALE,  ///< those of the scale, for heights
    ALL
  };
  void setSeen(Seen seen);
  /// Hides the topics for good: another display decides them.
  void setTopicsHidden(bool hidden);

 Q_SIGNALS:
  void topicsChanged();
  void coloringChanged();  ///< which layer is shown, or in which colors
  void legendChanged();    ///< whether there is a legend, or the unit

 private:
  void updateHidden();
  void addTopics(rviz::Property* parent);
  void addScale(const PropertyMaker& make, rviz::Property* parent);
  void addColors(const PropertyMaker& make, rviz::Property* parent);
  void addLegend(rviz::Property* parent);

  Seen seen_ = Seen::ALL;
  bool chooses_ = false;
  bool choosing_ = false;
  std::string own_choice_;
  bool topics_hidden_ = false;
  std::vector<std::string> types_;
  std::vector<rviz::Property*> all_;    ///< but for those below others of them
  std::vector<rviz::Property*> scale_;  ///< of these, what heights have, too
  rviz::EnumProperty* color_scale_;
  PropertyValue<CostColoring> coloring_;
  rviz::RosTopicProperty* costs_topic_;
  rviz::RosTopicProperty* update_topic_;
  rviz::RosTopicProperty* face_costs_topic_;
  rviz::EnumProperty* costs_type_;
  rviz::BoolProperty* custom_limits_;
  rviz::BoolProperty* invert_;
  rviz::FloatProperty* clip_percentile_;
  rviz::BoolProperty* legend_;
  rviz::StringProperty* unit_;
};

}  // namespace rviz_mesh_plugin
