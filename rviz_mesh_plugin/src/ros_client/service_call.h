#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <ros/serialized_message.h>

#include "ros_client/tcp_stream.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

/// Where a service is offered.
struct ServiceAddress
{
  std::string host;
  std::uint32_t port = 0;
};

/// Asks the ROS master; nothing where it knows no such service.
/// @throw ConnectionLost where the master does not answer; Cancelled
std::optional<ServiceAddress> lookUpService(const std::string& name,
                                            const Cancellation& cancellation);

/// A type of service that the caller understands.
struct ServiceType
{
  std::string name;  ///< as "mesh_msgs/GetMaterials"
  std::string md5;
};

/// What a service said.
struct ServiceAnswer
{
  std::size_t type = 0;  ///< which of the types it has
  std::string refusal;   ///< why there is no response; empty if there is one
  ros::SerializedMessage response;
};

/// A service of that name is there, but it cannot be called.
class WrongService : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// Calls a service over ROS's TCP protocol. In contrast to ros::ServiceClient it can be cancelled
/// at any time, tells why it was refused, and logs nothing.
/// @param types what it may be, all with the same request
/// @param request serialized, with its length
/// @param progress told how many bytes of how many there are so far
/// @throw ConnectionLost where there is no answer; WrongService, Cancelled
ServiceAnswer callService(const std::string& name, const ServiceAddress& address,
                          const std::vector<ServiceType>& types,
                          const ros::SerializedMessage& request, const Cancellation& cancellation,
                          const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace rviz_mesh_plugin
