#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "base/mesh_data.h"
#include "labels/face_parents.h"
#include "labels/label_faces.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// What a label is to become, as it is published.
struct SentEdit
{
  std::string uuid;
  std::string label;
  bool override = false;  ///< instead of the faces that it has, else beside them
  std::size_t faces = 0;
  /// For any thread; copies the faces.
  std::function<mesh_msgs::MeshFaceClusterStamped()> make;
};

/// @param parents where the mesh was made of another one: all parts of the faces of that are sent;
/// else null
SentEdit sentEdit(const MeshData& mesh, const std::string& label, const LabelFacesConstPtr& faces,
                  bool override, const FaceParentsConstPtr& parents);

/// Publishes edits in the order in which they are given; those of more than MANY_FACES, and what
/// comes while they are on their way, on a thread. GUI thread only.
class EditPublisher
{
 public:
  /// @throw ros::InvalidNameException
  void advertise(ros::NodeHandle& node_handle, const std::string& topic, std::uint32_t queue);
  /// What has been given goes out nevertheless.
  void shutdown() { publisher_ = ros::Publisher(); }

  /// Empty while not advertised.
  std::string topic() const { return publisher_.getTopic(); }
  bool isHeard() const { return publisher_ && publisher_.getNumSubscribers() > 0; }

  void publish(const SentEdit& edit);

 private:
  ros::Publisher publisher_;
  std::shared_ptr<std::atomic<std::size_t>> unsent_ = std::make_shared<std::atomic<std::size_t>>(0);
  WorkThread thread_{"label edits"};
};

}  // namespace rviz_mesh_plugin
