#pragma once

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/reception.h"

namespace rviz_mesh_plugin {

/// What the GUI thread takes from the inbox: the newest of each kind, and the receptions so far.
struct InboxContent
{
  MeshDataConstPtr geometry;               ///< null: nothing new
  std::vector<CostLayerConstPtr> costs;    ///< at most one per uuid and type, in order of arrival
  std::vector<ColorLayerConstPtr> colors;  ///< at most one per uuid, in order of arrival
  Reception geometry_reception;
  Reception costs_reception;
  Reception colors_reception;
};

/// Between the thread that ROS calls back and the GUI thread: checks and converts messages on the
/// former, hands the newest over to the latter, so that a fast publisher can neither block RViz nor
/// fill its memory. Thread safe.
class MeshInbox
{
 public:
  void receive(const mesh_msgs::MeshGeometryStamped& message);
  void receive(const mesh_msgs::MeshVertexCostsStamped& message);
  void receive(const mesh_msgs::MeshVertexColorsStamped& message);

  /// Hands over and forgets what has arrived; the receptions go on counting.
  InboxContent take();

  /// Forget what has arrived on one topic, and its reception.
  void clearGeometry();
  void clearCosts();
  void clearColors();

 private:
  template <class Message, class Store>
  void receive(const Message& message, Reception InboxContent::*reception, const Store& store);

  std::mutex mutex_;
  InboxContent content_;
};

}  // namespace rviz_mesh_plugin
