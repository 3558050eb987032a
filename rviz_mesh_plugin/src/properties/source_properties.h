#pragma once

#include <optional>
#include <string>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "sources/mesh_source.h"
#include "sources/service_names.h"
#endif

namespace rviz {
class Property;
class RosTopicProperty;
class StringProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

class CostProperties;

/// The properties of a mesh display for topics and services, which lie among the others: they are
/// added one group after the other.
class SourceProperties : public QObject
{
  Q_OBJECT

 public:
  using QObject::QObject;

  void addGeometry(rviz::Property* parent);
  void addColors(rviz::Property* parent);
  void addTextures(rviz::Property* parent);
  void addCosts(CostProperties* costs);  ///< which has topics of its own
  void addLabels(rviz::Property* parent);

  /// Where everything comes from: as chosen, or as another display has given it.
  MeshSource source() const;
  /// All properties are hidden from then on.
  void give(const MeshSource& source);
  bool given() const { return given_.has_value(); }
  /// Which are shown besides those for the geometry and labels.
  void show(bool colors, bool textures);

  void setGeometryTopic(const QString& topic);
  /// For those that have not been chosen yet.
  void proposeTopics(const QString& costs, const QString& colors);

  std::string updatesTopic() const;
  std::string materialsTopic() const;
  std::string texturesTopic() const;
  ServiceNames services() const;

 Q_SIGNALS:
  void changed();

 private:
  rviz::RosTopicProperty* geometry_topic_ = nullptr;
  rviz::RosTopicProperty* colors_topic_ = nullptr;
  rviz::StringProperty* colors_service_ = nullptr;
  rviz::StringProperty* materials_service_ = nullptr;
  rviz::StringProperty* texture_service_ = nullptr;
  rviz::RosTopicProperty* materials_topic_ = nullptr;
  rviz::RosTopicProperty* textures_topic_ = nullptr;
  CostProperties* costs_ = nullptr;
  rviz::RosTopicProperty* labels_topic_ = nullptr;
  std::optional<MeshSource> given_;
};

}  // namespace rviz_mesh_plugin
