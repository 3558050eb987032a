#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <ros/serialization.h>
#include <ros/service_traits.h>

#include "rviz_mesh_plugin/cancellation.h"
#include "rviz_mesh_plugin/message_lengths.h"
#include "rviz_mesh_plugin/service_asker.h"
#include "rviz_mesh_plugin/service_log.h"
#include "rviz_mesh_plugin/service_names.h"

namespace rviz_mesh_plugin {

template <class Service>
ServiceType serviceType()
{
  namespace traits = ros::service_traits;
  return {traits::datatype<Service>(), traits::md5sum<Service>()};
}

/// Questions to services of a map by their types, and what there is to be said about the answers.
class ServiceDialog
{
 public:
  /// All have to outlive this.
  ServiceDialog(const ServiceNames& names, const Cancellation& cancellation, ServiceLog& log);

  /// Waits for an answer. @throw Cancelled
  /// @param name that of the service that has answered
  /// @return whether there is a response; if not, the log says why
  template <class Service>
  bool get(const std::string& service, const typename Service::Request& request,
           typename Service::Response& response, std::string& name);

  /// @return whether there is a response; if not, the log says why
  template <class Response>
  bool read(const std::string& service, const ServiceAsker::Result& result, Response& response);

  /// @throw ros::InvalidNameException
  std::vector<std::string> candidates(const std::string& service) const;
  ServiceAsker& asker() { return asker_; }

  /// Whether an answer is about the mesh that was asked for.
  /// @param given by the answer; where it names none, the one asked for
  bool belongs(const std::string& service, const std::string& name, const std::string& asked,
               std::string& given);

  /// What became of an answer.
  /// @param remark more about one that was accepted
  /// @return @a accepted
  bool finish(const std::string& service, const std::string& name, bool accepted,
              const std::string& remark = std::string());

 private:
  bool findNames(const std::string& service, std::vector<std::string>& names);

  const ServiceNames& names_;
  ServiceLog& log_;
  ServiceAsker asker_;
};

template <class Response>
bool ServiceDialog::read(const std::string& service, const ServiceAsker::Result& result,
                         Response& response)
{
  if (result.outcome == ServiceAsker::Outcome::REFUSED) {
    log_.fail(service, result.name, "refuses: " + result.answer.refusal);
    return false;
  }
  try {
    const ros::SerializedMessage& bytes = result.answer.response;
    const std::string reason = findFalseLength<Response>(bytes.message_start, bytes.num_bytes);
    if (!reason.empty()) {
      throw std::length_error(reason);
    }
    ros::serialization::deserializeMessage(bytes, response);
    return true;
  } catch (const std::exception& error) {
    log_.fail(service, result.name,
              std::string("gives an answer that cannot be read: ") + error.what());
  }
  return false;
}

template <class Service>
bool ServiceDialog::get(const std::string& service, const typename Service::Request& request,
                        typename Service::Response& response, std::string& name)
{
  std::vector<std::string> names;
  if (!findNames(service, names)) {
    return false;
  }
  const auto result = asker_.ask(service, names, {serviceType<Service>()},
                                 ros::serialization::serializeMessage(request));
  name = result.name;
  return read(service, result, response);
}

}  // namespace rviz_mesh_plugin
