#include "sources/edit_publisher.h"

#include <exception>

#include <ros/console.h>

#include "rendering/labels/label_parts.h"

namespace rviz_mesh_plugin {

SentEdit sentEdit(const MeshData& mesh, const std::string& label, const LabelFacesConstPtr& faces,
                  bool override, const FaceParentsConstPtr& parents)
{
  SentEdit edit;
  edit.uuid = mesh.uuid;
  edit.label = label;
  edit.override = override;
  edit.faces = faces->size();
  edit.make = [frame_id = mesh.frame_id, uuid = mesh.uuid, label, override, faces, parents] {
    mesh_msgs::MeshFaceClusterStamped message;
    message.header.frame_id = frame_id;
    message.header.stamp = ros::Time::now();
    message.uuid = uuid;
    message.cluster.label = label;
    message.cluster.face_indices = parents ? wholeFaces(*faces, *parents) : *faces;
    message.override = override;
    return message;
  };
  return edit;
}

void EditPublisher::advertise(ros::NodeHandle& node_handle, const std::string& topic,
                              std::uint32_t queue)
{
  publisher_ = node_handle.advertise<mesh_msgs::MeshFaceClusterStamped>(topic, queue);
}

/// The thread has a publisher of its own, which outlives shutdown().
void EditPublisher::publish(const SentEdit& edit)
{
  if (!publisher_) {
    return;
  }
  if (edit.faces <= MANY_FACES && *unsent_ == 0) {
    publisher_.publish(edit.make());
    return;
  }
  ++*unsent_;
  thread_.add([publisher = publisher_, make = edit.make, label = edit.label,
               unsent = unsent_](const Cancellation& /*cancellation*/) {
    try {
      publisher.publish(make());
    } catch (const std::exception& error) {
      ROS_ERROR("the label '%s' is not sent: %s", label.c_str(), error.what());
    }
    --*unsent;
  });
}

}  // namespace rviz_mesh_plugin
