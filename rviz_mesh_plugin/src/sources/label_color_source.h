#pragma once

#include <memory>
#include <set>
#include <string>

#include <ros/node_handle.h>

#include "base/status_lines.h"
#include "labels/label_colors.h"
#include "ros_client/topic_receiver.h"
#include "sources/mesh_source.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// The namespace of who owns the labels (hdf5_map_server, label_manager): that of the services,
/// else that of the topic of the labels; empty where neither is named.
std::string labelNamespace(const MeshSource& source);

/// The labels' own colors, as who owns the labels has them: asked of get_label_colors, followed on
/// label_colors. GUI thread only; nothing waits for an answer.
class LabelColorSource
{
 public:
  LabelColorSource();

  /// Follows the colors in this namespace; those of another one are forgotten. Nothing happens
  /// where it does so already; where it is empty, nothing is followed. @throw
  /// ros::InvalidNameException
  void connect(ros::NodeHandle& node_handle, const std::string& name_space);
  /// What is known stays.
  void disconnect();
  void clear();

  /// Asks for the colors of a mesh, once while it is connected.
  void request(const std::string& uuid);

  /// Null while they are not known; another pointer only where they have changed. Those of 8
  /// meshes are kept, that have changed or been asked for last.
  OwnColorsConstPtr colors(const std::string& uuid) const;

  /// Why the newest colors were refused; nothing if they were not.
  OptionalStatus status() const;

 private:
  struct Known;
  static void ask(Known& known, const std::string& service, const std::string& uuid,
                  const Cancellation& cancellation);

  std::string namespace_;  ///< where what is known comes from
  bool connected_ = false;
  TopicReceiver receiver_;
  TopicReceiver::Subscription subscription_;
  std::shared_ptr<Known> known_;
  std::set<std::string> asked_;  ///< uuids
  WorkThread thread_{"label colors", NAME_PATIENCE};
};

}  // namespace rviz_mesh_plugin
