#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <mesh_msgs/SetLabelColor.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "base/mesh_data.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// Has these faces stored as the label, instead of those it has (@a override) or beside them.
mesh_msgs::MeshFaceClusterStamped labelEdit(const MeshData& mesh, const std::string& label,
                                            const std::vector<std::uint32_t>& faces, bool override);

/// The way of edits to who owns the labels of a map (hdf5_map_server, label_manager). GUI thread
/// only; nothing waits for an answer.
class LabelClient
{
 public:
  /// Uses the topic cluster_label and the service set_label_color in this namespace; none where it
  /// is empty. @throw ros::InvalidNameException
  void connect(ros::NodeHandle& node_handle, const std::string& name_space);
  void disconnect();

  /// Where edits go; empty while not connected.
  std::string topic() const { return publisher_.getTopic(); }
  bool isHeard() const { return publisher_ && publisher_.getNumSubscribers() > 0; }

  /// See labelEdit().
  void store(const mesh_msgs::MeshFaceClusterStamped& edit) { publisher_.publish(edit); }

  /// Has a color stored by work(); null: none.
  void setColor(const std::string& uuid, const std::string& label, const Rgba8* color);

  /// To be called often. Returns why a color could not be stored; empty where nothing new went
  /// wrong.
  std::string work();

 private:
  std::string color_service_;
  ros::Publisher publisher_;
  /// By label: of a color that is dragged about, the newest counts.
  std::map<std::string, mesh_msgs::SetLabelColor::Request> requests_;
  BackgroundTask<std::string> storing_{"label owner", NAME_PATIENCE};
};

}  // namespace rviz_mesh_plugin
