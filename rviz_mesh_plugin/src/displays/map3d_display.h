#pragma once

#include <memory>
#include <string>

#include <QPointer>
#include <QString>

#ifndef Q_MOC_RUN
#include <rviz/display_group.h>

#include "base/status_lines.h"
#include "map_server/map_session.h"
#endif

namespace rviz {
class TfFrameProperty;
}

namespace rviz_mesh_plugin {

class ClusterLabelDisplay;
class MapFileProperty;
class TexturedMeshDisplay;

/// Shows a map file, or any mesh that can be imported, with its labels: a child process
/// hdf5_map_server reads the file and stores what is labelled, the children ClusterLabel and Mesh
/// show what it serves. Nothing in a file can end RViz.
///
/// Status lines: Map (what is shown), IO (the file and the process), Label (edits).
class Map3DDisplay : public rviz::DisplayGroup
{
  Q_OBJECT

 public:
  Map3DDisplay();
  ~Map3DDisplay() override;

  /// The children; null where the user has removed one.
  TexturedMeshDisplay* meshDisplay() const;
  ClusterLabelDisplay* labelDisplay() const;

  /// What reads and serves the file.
  const MapSession& session() const { return *session_; }

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

  MapFileProperty* file_property_;
  rviz::TfFrameProperty* frame_property_;
  QPointer<rviz::Display> labels_;
  QPointer<rviz::Display> mesh_;
  std::unique_ptr<MapSession> session_;
  std::string shown_namespace_;  ///< that the children have been told
  StatusLines lines_;
};

}  // namespace rviz_mesh_plugin
