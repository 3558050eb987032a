#pragma once

class QWidget;

namespace rviz_mesh_plugin {

class ClusterLabelTool;
class LabelSession;

/// Opens a dialog that selects faces of the mesh that is being worked on by the values of its cost
/// layers, by height, by slope or by label, with a tool, and returns at once. It stays open beside
/// the 3D view until it is closed or the parent is gone.
/// @param session whose labels are offered; outlives the parent
void openSelectBy(QWidget* parent, ClusterLabelTool* tool, const LabelSession* session);

}  // namespace rviz_mesh_plugin
