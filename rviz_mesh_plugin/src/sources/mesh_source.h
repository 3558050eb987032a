#pragma once

#include <string>

namespace rviz_mesh_plugin {

/// Where a display gets its mesh from when another display decides that (Map3D): its own properties
/// for topics and services are hidden then.
struct MeshSource
{
  std::string geometry_topic;
  std::string costs_topic;
  std::string updates_topic;  ///< of the costs; "updates" below them where a display is given this
  std::string face_costs_topic;
  std::string colors_topic;
  std::string materials_topic;
  std::string textures_topic;
  std::string labels_topic;       ///< mesh_msgs/MeshFaceCluster: labels as they are now
  std::string service_namespace;  ///< of get_materials, get_texture, get_labeled_clusters, …
  std::string frame;              ///< that the mesh lies in; empty: as its messages say
};

}  // namespace rviz_mesh_plugin
