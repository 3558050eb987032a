#pragma once

#include <string>

#include <QPointer>

#ifndef Q_MOC_RUN
#include <rviz/display_group.h>

#include "base/status_lines.h"
#include "displays/cluster_label_display.h"
#include "displays/textured_mesh_display.h"
#include "map_server/map_session.h"
#endif

namespace rviz {
class StringProperty;
class TfFrameProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// Shows a map file, or any mesh that can be imported, with its labels: a child process
/// hdf5_map_server reads the file and stores what is labelled, the children ClusterLabel and Mesh
/// show what it serves. Nothing in a file can end RViz.
///
/// Status lines: Map (what is shown), IO (the file and the process), Label (edits), Parts (what is
/// wrong with the children).
class Map3DDisplay : public rviz::DisplayGroup
{
  Q_OBJECT

 public:
  Map3DDisplay();

  /// The children; null where the user has removed one.
  TexturedMeshDisplay* meshDisplay() const { return mesh_; }
  ClusterLabelDisplay* labelDisplay() const { return labels_; }

  /// What reads and serves the file.
  const MapSession& session() const { return session_; }

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;
  Qt::ItemFlags getViewFlags(int column) const override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void onFile();
  void onFrame();

 private:
  void createChildren();
  void applySource();
  void applyFileParameter();
  std::string frame() const;

  rviz::StringProperty* file_property_;
  rviz::TfFrameProperty* frame_property_;
  QPointer<ClusterLabelDisplay> labels_;
  QPointer<TexturedMeshDisplay> mesh_;
  MapSession session_;
  std::string shown_namespace_;  ///< that the children have been told
  StatusLines lines_;
};

}  // namespace rviz_mesh_plugin
