#pragma once

#include <set>
#include <string>

#ifndef Q_MOC_RUN
#include <rviz/properties/property.h>

#include "labels/label_order.h"
#endif

namespace rviz {
class BoolProperty;
}

namespace rviz_mesh_plugin {

/// A group with a check box per class of labels, each with one per label of the class. What is
/// hidden is saved by name, and kept for labels that are not there (yet).
class LabelVisibility : public rviz::Property
{
  Q_OBJECT

 public:
  explicit LabelVisibility(rviz::Property* parent);

  bool isShown(const std::string& label) const;
  /// Shows its class, too.
  void setShown(const std::string& label, bool shown);

  void addLabel(const std::string& label);
  void removeLabel(const std::string& label);

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 Q_SIGNALS:
  void labelChanged(const QString& label);
  void classChanged(const QString& label_class);

 private:
  rviz::BoolProperty* addBox(const std::string& name, const char* what, bool shown,
                             rviz::Property* parent);
  void choose(std::set<std::string>& hidden, const std::string& name, bool shown);
  rviz::Property* classBox(const std::string& label_class) const;

  std::set<std::string> hidden_classes_;
  std::set<std::string> hidden_labels_;
};

}  // namespace rviz_mesh_plugin
