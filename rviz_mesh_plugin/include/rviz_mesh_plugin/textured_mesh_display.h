#pragma once

#include <map>
#include <memory>
#include <string>

#ifndef Q_MOC_RUN
#include <rviz/display.h>

#include "rviz_mesh_plugin/mesh_inbox.h"
#include "rviz_mesh_plugin/mesh_status.h"
#include "rviz_mesh_plugin/mesh_store.h"
#include "rviz_mesh_plugin/mesh_topics.h"
#endif

namespace rviz_mesh_plugin {

class MeshPainter;
class MeshProperties;
class MeshVisual;

/// Shows a mesh_msgs/MeshGeometryStamped topic in one color, in the colors of its vertices, or by a
/// cost layer.
///
/// Messages are checked and converted on RViz's thread for callbacks; update() takes the results
/// over. One status line per concern: Topic, Geometry, Costs, Colors, Textures, Transform.
class TexturedMeshDisplay : public rviz::Display
{
  Q_OBJECT

 public:
  TexturedMeshDisplay();
  ~TexturedMeshDisplay() override;

  void setTopic(const QString& topic, const QString& datatype) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

  /// What is drawn; null while disabled or without a mesh.
  const MeshVisual* visual() const;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void onGeometryTopic();
  void onColorsTopic();
  void onCostsTopic();
  void onColoring();
  void onStyle();

 private:
  void subscribe();
  void takeMessages();
  void showGeometry();
  void objectsChanged();
  void updatePose();
  void updateStatuses();
  CostsState costsState() const;
  AttributeState colorsState() const;
  void report(const char* name, const OptionalStatus& status);

  MeshProperties* properties_;
  std::shared_ptr<MeshInbox> inbox_;
  MeshTopics topics_;
  MeshStore store_;
  std::unique_ptr<MeshPainter> painter_;
  Reception geometry_reception_;
  Reception costs_reception_;
  Reception colors_reception_;
  std::string geometry_subscription_error_;
  std::string costs_subscription_error_;
  std::string colors_subscription_error_;
  std::map<std::string, StatusLine> lines_;  ///< as shown, so that only changes go to RViz
};

}  // namespace rviz_mesh_plugin
