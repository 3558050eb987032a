#pragma once

#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// Where services are looked for. A relative name is tried in service_namespace alone, where that
/// is given; else in the namespace of the geometry topic, in those above it, and in RViz's own.
struct ServiceNames
{
  std::string colors = "get_vertex_colors";
  std::string materials = "get_materials";
  std::string texture = "get_texture";
  std::string geometry_topic;
  std::string service_namespace;
};

/// The names to try for one service, best first, resolved and remapped; none for an empty name.
/// @throw ros::InvalidNameException
std::vector<std::string> serviceCandidates(const std::string& name, const ServiceNames& names);

}  // namespace rviz_mesh_plugin
