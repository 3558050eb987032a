#include "ros_client/service_call.h"

#include <algorithm>

#include <ros/header.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <boost/shared_array.hpp>

#include "ros_client/master_call.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t MOST_HEADER_BYTES = 1 << 20;
constexpr std::uint32_t MOST_TEXT_BYTES = 1 << 20;

/// The fields of the header with which the peer answers.
ros::Header readHeader(TcpStream& stream)
{
  std::uint32_t size = 0;
  stream.readExactly(&size, sizeof(size));
  if (size > MOST_HEADER_BYTES) {
    throw ConnectionLost("the answer is none of a ROS service");
  }
  const boost::shared_array<std::uint8_t> bytes(new std::uint8_t[size + 1]);
  stream.readExactly(bytes.get(), size);
  ros::Header header;
  std::string error;
  if (!header.parse(bytes, size, error)) {
    throw ConnectionLost("the answer is none of a ROS service: " + error);
  }
  return header;
}

ros::Header exchangeHeaders(TcpStream& stream, const std::string& name, const std::string& md5)
{
  const ros::M_string fields = {
      {"service", name}, {"md5sum", md5}, {"callerid", ros::this_node::getName()}};
  boost::shared_array<std::uint8_t> bytes;
  std::uint32_t size = 0;
  ros::Header::write(fields, bytes, size);
  stream.write(&size, sizeof(size));
  stream.write(bytes.get(), size);
  return readHeader(stream);
}

/// Which of the types the service has; nothing where it is another one.
std::optional<std::size_t> typeOf(const ros::Header& header, const std::vector<ServiceType>& types)
{
  std::string md5;
  header.getValue("md5sum", md5);
  const auto found = std::find_if(types.begin(), types.end(),
                                  [&](const ServiceType& type) { return type.md5 == md5; });
  if (found == types.end()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - types.begin());
}

ServiceAnswer exchange(TcpStream& stream, const ros::SerializedMessage& request,
                       const std::function<void(std::size_t, std::size_t)>& progress)
{
  stream.write(request.buf.get(), request.num_bytes);
  std::uint8_t good = 0;
  std::uint32_t size = 0;
  stream.readExactly(&good, sizeof(good));
  stream.readExactly(&size, sizeof(size));
  if (good == 0 && size > MOST_TEXT_BYTES) {
    throw ConnectionLost("the answer is none of a ROS service");
  }
  // Not set to zero: memory is only taken as bytes arrive.
  const boost::shared_array<std::uint8_t> bytes(new std::uint8_t[std::size_t(size) + 1]);
  stream.readExactly(bytes.get(), size, [&](std::size_t done) { progress(done, size); });
  ServiceAnswer answer;
  if (good == 0) {
    answer.refusal.assign(reinterpret_cast<const char*>(bytes.get()), size);
    if (answer.refusal.empty()) {
      answer.refusal = "it gives no reason";
    }
  } else {
    answer.response = ros::SerializedMessage(bytes, size);
    answer.response.message_start = bytes.get();
  }
  return answer;
}

}  // namespace

std::optional<ServiceAddress> lookUpService(const std::string& name,
                                            const Cancellation& cancellation)
{
  auto found = callMaster("lookupService", {name}, cancellation);
  if (!found || found->getType() != XmlRpc::XmlRpcValue::TypeString) {
    return std::nullopt;
  }
  const std::string uri = *found;
  const std::string protocol = "rosrpc://";
  ServiceAddress address;
  if (uri.compare(0, protocol.size(), protocol) != 0 ||
      !ros::network::splitURI(uri, address.host, address.port)) {
    throw ConnectionLost("the ROS master names no usable address for " + name);
  }
  return address;
}

ServiceAnswer callService(const std::string& name, const ServiceAddress& address,
                          const std::vector<ServiceType>& types,
                          const ros::SerializedMessage& request, const Cancellation& cancellation,
                          const std::function<void(std::size_t, std::size_t)>& progress)
{
  // Any type first, since the answer names it; servers that do not know that are asked for each.
  std::vector<std::string> sums = {"*"};
  for (const ServiceType& type : types) {
    sums.push_back(type.md5);
  }
  std::string reason;
  for (const std::string& md5 : sums) {
    TcpStream stream(address.host, address.port, cancellation);
    const ros::Header header = exchangeHeaders(stream, name, md5);
    if (header.getValue("error", reason)) {
      continue;
    }
    if (const auto type = typeOf(header, types)) {
      ServiceAnswer answer = exchange(stream, request, progress);
      answer.type = *type;
      return answer;
    }
    std::string given;
    header.getValue("type", given);
    throw WrongService("it is of the type " + (given.empty() ? "'unknown'" : given) +
                       " and not of " + types.front().name + " as of release 1.1");
  }
  throw WrongService(reason);
}

}  // namespace rviz_mesh_plugin
