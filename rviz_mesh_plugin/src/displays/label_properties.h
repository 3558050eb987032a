#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "base/mesh_data.h"
#include "labels/label_name.h"
#include "properties/property_maker.h"
#endif

namespace rviz_mesh_plugin {

/// A group with a check box per class of labels, each with one per label of the class. What is
/// hidden is saved by name, and kept for labels that are not there (yet). Its signal changed()
/// tells that other labels are shown.
class LabelVisibility : public rviz::Property
{
 public:
  explicit LabelVisibility(rviz::Property* parent);

  bool isShown(const std::string& label) const;
  /// Shows its class, too.
  void setShown(const std::string& label, bool shown);

  void addLabel(const std::string& label);
  void removeLabel(const std::string& label);

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  void addBox(const std::string& name, const char* what, std::set<std::string>& hidden,
              rviz::Property* parent);
  rviz::Property* classBox(const std::string& label_class) const;

  std::set<std::string> hidden_classes_;
  std::set<std::string> hidden_labels_;
};

/// The properties of a display of labels. Names, types and defaults of those that the released
/// rviz_map_plugin/ClusterLabel has are the same.
class LabelProperties : public QObject
{
  Q_OBJECT

 public:
  /// Adds the properties to @a parent, which owns them from then on.
  explicit LabelProperties(rviz::Property* parent);

  std::string geometryTopic() const { return geometry_topic_->getTopicStd(); }
  std::string labelsTopic() const { return labels_topic_->getTopicStd(); }
  void setTopic(const QString& topic, bool of_labels);
  void setTopicsHidden(bool hidden);

  float brushSize() const { return brush_size_->getFloat(); }
  float alpha() const { return transparency_->getFloat(); }
  bool phantom() const { return phantom_->getBool(); }
  bool names() const { return names_->getBool(); }
  LabelVisibility& visibility() const { return *visibility_; }

  /// From now on there are these labels; properties for them are made and removed by work().
  void setLabels(const std::vector<std::string>& labels);
  /// The color of this label has changed, or is new.
  void setColor(const std::string& label, const Rgba8& color);
  /// Works for about this long; true where nothing is left to do.
  bool work(std::chrono::microseconds budget);

 Q_SIGNALS:
  void topicsChanged();
  void lookChanged();        ///< alpha, phantom or names
  void visibilityChanged();  ///< of labels
  void colorChosen(const QString& label, const QColor& color);

 private:
  void addLabel(const std::string& label);
  void removeLabel(const std::string& label);

  rviz::RosTopicProperty* geometry_topic_;
  rviz::RosTopicProperty* labels_topic_;
  rviz::EnumProperty* active_label_;
  rviz::FloatProperty* transparency_;
  rviz::Property* color_group_;
  LabelVisibility* visibility_;
  rviz::FloatProperty* brush_size_;
  rviz::BoolProperty* phantom_;
  rviz::BoolProperty* names_;
  std::map<std::string, Rgba8> wanted_colors_;
  std::deque<std::string> to_add_;
  std::deque<std::string> to_remove_;
  bool setting_color_ = false;
};

}  // namespace rviz_mesh_plugin
