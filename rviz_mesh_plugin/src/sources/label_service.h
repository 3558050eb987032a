#pragma once

#include <optional>
#include <string>

#include <ros/serialization.h>
#include <ros/service_traits.h>

#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {

/// Calls a service of who owns the labels, which may just be starting: it is looked for five times,
/// a second apart. Nothing where nobody offers it.
/// @throw ConnectionLost, WrongService, Cancelled
template <class Service>
std::optional<ServiceAnswer> callLabelService(const std::string& name,
                                              const typename Service::Request& request,
                                              const Cancellation& cancellation)
{
  constexpr int TRIES = 5;
  namespace traits = ros::service_traits;
  const ServiceType type = {traits::datatype<Service>(), traits::md5sum<Service>()};
  for (int i = 0; i < TRIES; ++i) {
    if (const auto address = lookUpService(name, cancellation)) {
      return callService(name, *address, {type}, ros::serialization::serializeMessage(request),
                         cancellation, [](std::size_t, std::size_t) {});
    }
    cancellation.wait(-1, 0, 1000);
  }
  return std::nullopt;
}

}  // namespace rviz_mesh_plugin
