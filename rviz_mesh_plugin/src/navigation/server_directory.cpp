#include "navigation/server_directory.h"

#include <algorithm>
#include <utility>

#include <mbf_msgs/MoveBaseActionResult.h>
#include <ros/message_traits.h>
#include <ros/names.h>

#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

using XmlRpc::XmlRpcValue;
using Names = std::vector<std::string>;

const char* const USUAL_SERVERS[] = {"move_base_flex", "mbf_mesh_nav"};
/// Of servers on meshes, and of those on grids.
const char* const CLEAR_SERVICES[] = {"clear_mesh", "clear_costmaps"};
constexpr std::size_t MOST_NAMES = 100;

bool isText(const XmlRpcValue& value)
{
  return value.getType() == XmlRpcValue::TypeString;
}

bool isArray(const XmlRpcValue& value)
{
  return value.getType() == XmlRpcValue::TypeArray;
}

/// Of pairs of a name and a type: whose actions are of the right one.
Names serversOf(XmlRpcValue topics)
{
  const std::string result = "/move_base/result";
  Names servers;
  for (int i = 0; isArray(topics) && i < topics.size(); ++i) {
    XmlRpcValue& topic = topics[i];
    if (!isArray(topic) || topic.size() != 2 || !isText(topic[0]) || !isText(topic[1])) {
      continue;
    }
    const std::string name = topic[0], type = topic[1];
    if (type == ros::message_traits::datatype<mbf_msgs::MoveBaseActionResult>() &&
        name.size() > result.size() &&
        name.compare(name.size() - result.size(), result.size(), result) == 0) {
      servers.push_back(name.substr(0, name.size() - result.size()));
    }
  }
  std::sort(servers.begin(), servers.end());
  return servers;
}

/// Of a list of {name: …, type: …}; what is none is left out.
Names pluginsOf(std::optional<XmlRpcValue> list)
{
  Names names;
  for (int i = 0; list && isArray(*list) && i < list->size() && names.size() < MOST_NAMES; ++i) {
    XmlRpcValue& plugin = (*list)[i];
    if (plugin.getType() == XmlRpcValue::TypeStruct && plugin.hasMember("name") &&
        isText(plugin["name"])) {
      const std::string name = plugin["name"];
      if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
        names.push_back(name);
      }
    }
  }
  return names;
}

/// Of what getSystemState says: publishers, subscribers, and then services with their nodes.
Names clearServicesOf(std::optional<XmlRpcValue> state, const std::string& server)
{
  Names found;
  if (!state || !isArray(*state) || state->size() != 3 || !isArray((*state)[2])) {
    return found;
  }
  XmlRpcValue& services = (*state)[2];
  for (const char* name : CLEAR_SERVICES) {
    for (int i = 0; i < services.size(); ++i) {
      if (isArray(services[i]) && services[i].size() == 2 && isText(services[i][0]) &&
          std::string(services[i][0]) == server + "/" + name) {
        found.push_back(server + "/" + name);
      }
    }
  }
  return found;
}

}  // namespace

void ServerDirectory::update(Clock::time_point now, const std::string& server)
{
  if (auto answer = question_.take()) {
    asked_ = true;
    problem_ = answer->error;
    if (answer->result) {
      known_ = std::move(*answer->result);
    }
  }
  if (known_.server != server) {  // what is known is of another one
    known_.planners.clear();
    known_.controllers.clear();
    known_.clear_services.clear();
  }
  const bool due = !asked_at_ || now - *asked_at_ >= INTERVAL || asked_for_ != server;
  if (due && !question_.isRunning()) {
    asked_at_ = now;
    asked_for_ = server;
    question_.start(
        [server](const Cancellation& cancellation) { return ask(server, cancellation); });
  }
}

ServerDirectory::Known ServerDirectory::ask(const std::string& server,
                                            const Cancellation& cancellation)
{
  const ServiceCall call(cancellation);
  Known known;
  known.server = server;
  const auto topics = call.callMaster("getPublishedTopics", {""});
  if (!topics) {
    throw ConnectionLost("the ROS master refuses to list topics");
  }
  known.servers = serversOf(*topics);
  if (!server.empty()) {
    known.planners = pluginsOf(call.callMaster("getParam", {server + "/planners"}));
    known.controllers = pluginsOf(call.callMaster("getParam", {server + "/controllers"}));
    known.clear_services = clearServicesOf(call.callMaster("getSystemState", {}), server);
  }
  return known;
}

bool ServerDirectory::lists(const std::string& server) const
{
  return std::binary_search(known_.servers.begin(), known_.servers.end(), server);
}

std::string ServerDirectory::usualServer() const
{
  if (known_.servers.empty()) {
    return ros::names::resolve(USUAL_SERVERS[0]);
  }
  if (known_.servers.size() == 1) {
    return known_.servers.front();
  }
  std::string found;
  for (const char* usual : USUAL_SERVERS) {
    const std::string name = ros::names::resolve(usual);
    if (lists(name)) {
      if (!found.empty()) {
        return {};
      }
      found = name;
    }
  }
  return found;
}

}  // namespace rviz_mesh_plugin
