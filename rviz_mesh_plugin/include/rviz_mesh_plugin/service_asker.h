#pragma once

#include <string>
#include <vector>

#include "rviz_mesh_plugin/cancellation.h"
#include "rviz_mesh_plugin/service_call.h"
#include "rviz_mesh_plugin/service_log.h"

namespace rviz_mesh_plugin {

/// Asks services that may not be there yet, and says in the log how that goes, but for the end.
class ServiceAsker
{
 public:
  ServiceAsker(const Cancellation& cancellation, ServiceLog& log);

  enum class Outcome
  {
    ANSWERED,
    REFUSED,
    NOT_YET
  };
  struct Result
  {
    Outcome outcome = Outcome::NOT_YET;
    std::string name;  ///< of the service that answered or refused
    ServiceAnswer answer;
  };

  /// Tries each of the names once. @throw Cancelled
  Result tryOnce(const std::string& service, const std::vector<std::string>& names,
                 const std::vector<ServiceType>& types, const ros::SerializedMessage& request);

  /// Once a second, until there is an answer or a refusal. @throw Cancelled
  Result ask(const std::string& service, const std::vector<std::string>& names,
             const std::vector<ServiceType>& types, const ros::SerializedMessage& request);

  /// A second. @throw Cancelled
  void pause() const;

 private:
  const Cancellation& cancellation_;
  ServiceLog& log_;
};

}  // namespace rviz_mesh_plugin
