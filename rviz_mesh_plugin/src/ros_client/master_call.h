#pragma once

#include <optional>
#include <string>
#include <vector>

#include <xmlrpcpp/XmlRpcValue.h>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

/// Calls the ROS master's API; nothing where it says that it cannot do that. In contrast to
/// ros::master::execute() it can be cancelled at any time, and logs nothing.
/// @param arguments after the name of this node; without characters that XML has to escape
/// @throw ConnectionLost where the master does not answer; Cancelled
std::optional<XmlRpc::XmlRpcValue> callMaster(const std::string& method,
                                              const std::vector<std::string>& arguments,
                                              const Cancellation& cancellation);

}  // namespace rviz_mesh_plugin
