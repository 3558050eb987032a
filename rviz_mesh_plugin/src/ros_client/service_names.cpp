#include "ros_client/service_names.h"

#include <algorithm>

#include <ros/exceptions.h>
#include <ros/names.h>

namespace rviz_mesh_plugin {
namespace {

/// The namespaces that a topic lies in, the innermost first; the last is "".
std::vector<std::string> namespacesOf(const std::string& topic)
{
  std::vector<std::string> namespaces;
  std::string name;
  try {
    name = topic.empty() ? topic : ros::names::resolve(topic);
  } catch (const ros::InvalidNameException&) {  // said where the topic is subscribed to
  }
  while (!name.empty()) {
    name.resize(name.rfind('/'));
    namespaces.push_back(name);
  }
  return namespaces;
}

}  // namespace

std::vector<std::string> serviceCandidates(const std::string& name, const ServiceNames& names)
{
  std::vector<std::string> candidates;
  const auto add = [&](const std::string& candidate) {
    const std::string resolved = ros::names::resolve(candidate);
    if (std::find(candidates.begin(), candidates.end(), resolved) == candidates.end()) {
      candidates.push_back(resolved);
    }
  };
  if (name.empty()) {
    return candidates;
  }
  if (name[0] == '/' || name[0] == '~') {
    add(name);
  } else if (!names.service_namespace.empty()) {
    add(ros::names::append(ros::names::resolve(names.service_namespace), name));
  } else {
    for (const std::string& space : namespacesOf(names.geometry_topic)) {
      add(space + "/" + name);
    }
    add(name);
  }
  return candidates;
}

}  // namespace rviz_mesh_plugin
