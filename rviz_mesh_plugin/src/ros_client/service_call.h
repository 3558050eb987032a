#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <ros/serialization.h>
#include <ros/serialized_message.h>
#include <ros/service_traits.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include "conversion/validation.h"
#include "ros_client/message_lengths.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

/// Where services are looked for. A relative name is tried in service_namespace alone, where that
/// is given; else in the namespace of the geometry topic and in the one above it; where no topic is
/// named, in RViz's own.
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

/// No connection, or no more.
class ConnectionLost : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// The host answers, and nobody is at that port: the process that was there has ended.
class ConnectionRefused : public ConnectionLost
{
 public:
  using ConnectionLost::ConnectionLost;
};

/// A service of that name is there, but it cannot be called.
class WrongService : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// Calls a service, or the ROS master, and can be given up: all members throw Canceled as soon as
/// that is wanted, and ConnectionLost where nobody answers.
///
/// It speaks ROS's TCP protocol itself, since roscpp cannot do this. ros::ServiceClient waits for
/// an answer however long it takes, and its shutdown() waits with it; of a refusal it only logs the
/// text; and it makes room for as many bytes as a server announces, before any has come. Here a
/// server that lies about that gets memory only as the bytes arrive. ros::master::execute() tries
/// again for ever while the master is away, and logs that.
class ServiceCall
{
 public:
  /// A type of service that the caller understands.
  struct Type
  {
    std::string name;  ///< as "mesh_msgs/GetMaterials"
    std::string md5;
  };
  template <class Service>
  static Type typeOf()
  {
    namespace traits = ros::service_traits;
    return {traits::datatype<Service>(), traits::md5sum<Service>()};
  }

  /// What a service said.
  struct Answer
  {
    std::size_t type = 0;  ///< which of the types it has
    std::string refusal;   ///< why there is no response; empty if there is one
    ros::SerializedMessage response;

    /// @throw RejectedMessage that says which length lies
    template <class Response>
    Response read() const
    {
      const std::string reason =
          findFalseLength<Response>(response.message_start, response.num_bytes);
      if (!reason.empty()) {
        throw RejectedMessage(reason);
      }
      Response read;
      ros::serialization::deserializeMessage(response, read);
      return read;
    }
  };

  /// Told how many bytes of how many there are so far; 0 of 0 as soon as the service is found.
  using Progress = std::function<void(std::size_t bytes, std::size_t of)>;

  /// @param cancellation outlives this
  explicit ServiceCall(const Cancellation& cancellation) : cancellation_(cancellation) {}

  /// Calls the service of this name; nothing where the ROS master knows none.
  /// @param types what it may be, all with the same request
  /// @param request serialized, with its length
  /// @throw WrongService
  std::optional<Answer> call(const std::string& name, const std::vector<Type>& types,
                             const ros::SerializedMessage& request,
                             const Progress& progress = nullptr) const;

  /// The same for a server that may just be starting: it is looked for five times, a second apart.
  template <class Service>
  std::optional<Answer> callPatiently(const std::string& name,
                                      const typename Service::Request& request) const
  {
    constexpr int TRIES = 5;
    std::optional<Answer> answer;
    for (int i = 0; i < TRIES && !answer; ++i) {
      answer = call(name, {typeOf<Service>()}, ros::serialization::serializeMessage(request));
      if (!answer) {
        cancellation_.wait(-1, 0, 1000);
      }
    }
    return answer;
  }

  /// Calls the ROS master's API; nothing where it says that it cannot do that.
  /// @param arguments after the name of this node; without characters that XML has to escape
  std::optional<XmlRpc::XmlRpcValue> callMaster(const std::string& method,
                                                const std::vector<std::string>& arguments) const;

 private:
  const Cancellation& cancellation_;
};

}  // namespace rviz_mesh_plugin
