#include "ros_client/master_call.h"

#include <cstring>

#include <ros/master.h>
#include <ros/this_node.h>

#include "ros_client/tcp_stream.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t MOST_BYTES = 1 << 24;
constexpr int MILLISECONDS = 10000;

std::string parameter(const std::string& text)
{
  return "<param><value><string>" + text + "</string></value></param>";
}

std::string requestOf(const std::string& method, const std::vector<std::string>& arguments)
{
  std::string body = "<?xml version=\"1.0\"?>\n<methodCall><methodName>" + method +
                     "</methodName><params>" + parameter(ros::this_node::getName());
  for (const std::string& argument : arguments) {
    body += parameter(argument);
  }
  body += "</params></methodCall>\n";
  return "POST /RPC2 HTTP/1.0\r\nHost: " + ros::master::getHost() +
         "\r\nContent-Type: text/xml\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\nConnection: close\r\n\r\n" + body;
}

}  // namespace

std::optional<XmlRpc::XmlRpcValue> callMaster(const std::string& method,
                                              const std::vector<std::string>& arguments,
                                              const Cancellation& cancellation)
{
  std::string answer;
  try {
    TcpStream stream(ros::master::getHost(), ros::master::getPort(), cancellation);
    const std::string request = requestOf(method, arguments);
    stream.write(request.data(), request.size());
    answer = stream.readToEnd(MOST_BYTES, MILLISECONDS);
  } catch (const ConnectionLost& lost) {
    throw ConnectionLost(std::string("the ROS master cannot be asked: ") + lost.what());
  }
  const std::size_t start = answer.find("<param>");
  if (start == std::string::npos) {
    throw ConnectionLost("the ROS master's answer cannot be understood");
  }
  int offset = static_cast<int>(start + std::strlen("<param>"));
  XmlRpc::XmlRpcValue value(answer, &offset);  // code, text, result
  if (value.getType() != XmlRpc::XmlRpcValue::TypeArray || value.size() != 3 ||
      value[0].getType() != XmlRpc::XmlRpcValue::TypeInt || int(value[0]) != 1) {
    return std::nullopt;
  }
  return value[2];
}

}  // namespace rviz_mesh_plugin
