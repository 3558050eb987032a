#include "ros_client/service_call.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>

#include <ros/exceptions.h>
#include <ros/header.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <boost/shared_array.hpp>

namespace rviz_mesh_plugin {
namespace {

constexpr int CONNECT_MILLISECONDS = 5000;
constexpr std::uint32_t MOST_HEADER_BYTES = 1 << 20;
constexpr std::uint32_t MOST_TEXT_BYTES = 1 << 20;
constexpr std::size_t MOST_MASTER_BYTES = 1 << 24;
constexpr int MASTER_MILLISECONDS = 10000;

/// A TCP connection that every wait of can be canceled. All members throw ConnectionLost and
/// Canceled.
class TcpStream
{
 public:
  /// Takes at most some seconds, but for the resolution of the name, which the system decides.
  TcpStream(const std::string& host, std::uint32_t port, const Cancellation& cancellation);
  ~TcpStream();
  TcpStream(const TcpStream&) = delete;
  TcpStream& operator=(const TcpStream&) = delete;

  void write(const void* data, std::size_t size);

  /// Waits for as long as the peer lives.
  /// @param progress told how many bytes there are so far
  void readExactly(void* data, std::size_t size,
                   const std::function<void(std::size_t)>& progress = nullptr);

  /// All until the peer closes. @throw ConnectionLost where that is more than @a most bytes, or
  /// takes longer than @a milliseconds without any
  std::string readToEnd(std::size_t most, int milliseconds);

 private:
  bool connectTo(const addrinfo& address);
  std::size_t readSome(void* data, std::size_t size, int milliseconds);

  const Cancellation& cancellation_;
  std::string peer_;
  int socket_ = -1;
  bool refused_ = true;  ///< by each address that was tried
};

void setOption(int socket, int level, int name, int value)
{
  // Without it the connection works, too.
  setsockopt(socket, level, name, &value, sizeof(value));
}

TcpStream::TcpStream(const std::string& host, std::uint32_t port, const Cancellation& cancellation)
    : cancellation_(cancellation), peer_(host + ":" + std::to_string(port))
{
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int failure = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (failure != 0) {
    throw ConnectionLost("the host name '" + host + "' cannot be resolved (" +
                         gai_strerror(failure) + "); set ROS_IP or ROS_HOSTNAME there");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
  try {
    for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
      if (connectTo(*one)) {
        return;
      }
    }
  } catch (...) {
    if (socket_ >= 0) {
      close(socket_);
    }
    throw;
  }
  const std::string reason = "nobody accepts connections at " + peer_;
  if (refused_) {
    throw ConnectionRefused(reason);
  }
  throw ConnectionLost(reason);
}

TcpStream::~TcpStream()
{
  close(socket_);
}

bool TcpStream::connectTo(const addrinfo& address)
{
  socket_ = socket(address.ai_family, address.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                   address.ai_protocol);
  if (socket_ < 0) {
    return false;
  }
  int error = 0;
  if (connect(socket_, address.ai_addr, address.ai_addrlen) != 0) {
    error = errno;
    if (error == EINPROGRESS) {
      error = ETIMEDOUT;
      if (cancellation_.wait(socket_, POLLOUT, CONNECT_MILLISECONDS)) {
        socklen_t size = sizeof(error);
        getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size);
      }
    }
  }
  if (error != 0) {
    refused_ = refused_ && error == ECONNREFUSED;
    close(socket_);
    socket_ = -1;
    return false;
  }
  setOption(socket_, IPPROTO_TCP, TCP_NODELAY, 1);
  // A host that has been switched off is noticed within half a minute.
  setOption(socket_, SOL_SOCKET, SO_KEEPALIVE, 1);
  setOption(socket_, IPPROTO_TCP, TCP_KEEPIDLE, 10);
  setOption(socket_, IPPROTO_TCP, TCP_KEEPINTVL, 5);
  setOption(socket_, IPPROTO_TCP, TCP_KEEPCNT, 3);
  return true;
}

void TcpStream::write(const void* data, std::size_t size)
{
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    cancellation_.wait(socket_, POLLOUT, -1);
    const ssize_t sent = send(socket_, next, size, MSG_NOSIGNAL);
    if (sent > 0) {
      next += sent;
      size -= static_cast<std::size_t>(sent);
    } else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
      throw ConnectionLost("the connection to " + peer_ + " broke: " + std::strerror(errno));
    }
  }
}

std::size_t TcpStream::readSome(void* data, std::size_t size, int milliseconds)
{
  while (true) {
    if (!cancellation_.wait(socket_, POLLIN, milliseconds)) {
      throw ConnectionLost(peer_ + " does not answer");
    }
    const ssize_t got = recv(socket_, data, size, 0);
    if (got >= 0) {
      return static_cast<std::size_t>(got);
    }
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
      throw ConnectionLost("the connection to " + peer_ + " broke: " + std::strerror(errno));
    }
  }
}

void TcpStream::readExactly(void* data, std::size_t size,
                            const std::function<void(std::size_t)>& progress)
{
  std::size_t done = 0;
  while (done < size) {
    const std::size_t got = readSome(static_cast<char*>(data) + done, size - done, -1);
    if (got == 0) {
      throw ConnectionLost(peer_ + " closed the connection in the middle of its answer");
    }
    done += got;
    if (progress) {
      progress(done);
    }
  }
}

std::string TcpStream::readToEnd(std::size_t most, int milliseconds)
{
  std::string all;
  char part[4096];
  while (const std::size_t got = readSome(part, sizeof(part), milliseconds)) {
    all.append(part, got);
    if (all.size() > most) {
      throw ConnectionLost(peer_ + " answers with more than " + std::to_string(most) + " bytes");
    }
  }
  return all;
}

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

ServiceCall::Answer exchange(TcpStream& stream, const ros::SerializedMessage& request,
                             const ServiceCall::Progress& progress)
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
  ServiceCall::Answer answer;
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

/// The namespace that a topic lies in and the one above it; none where its name is none. Further
/// up are those that others share, who may serve another map.
std::vector<std::string> namespacesAround(const std::string& topic)
{
  constexpr std::size_t LEVELS = 2;
  std::vector<std::string> namespaces;
  std::string name;
  try {
    name = ros::names::resolve(topic);
  } catch (const ros::InvalidNameException&) {  // said where the topic is subscribed to
  }
  while (!name.empty() && namespaces.size() < LEVELS) {
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
  } else if (!names.geometry_topic.empty()) {
    for (const std::string& space : namespacesAround(names.geometry_topic)) {
      add(space + "/" + name);
    }
  } else {
    add(name);
  }
  return candidates;
}

std::optional<ServiceCall::Answer> ServiceCall::call(const std::string& name,
                                                     const std::vector<Type>& types,
                                                     const ros::SerializedMessage& request,
                                                     const Progress& progress) const
{
  auto found = callMaster("lookupService", {name});
  if (!found || found->getType() != XmlRpc::XmlRpcValue::TypeString) {
    return std::nullopt;
  }
  const std::string uri = *found;
  const std::string protocol = "rosrpc://";
  std::string host;
  std::uint32_t port = 0;
  if (uri.compare(0, protocol.size(), protocol) != 0 || !ros::network::splitURI(uri, host, port)) {
    throw ConnectionLost("the ROS master names no usable address for " + name);
  }
  const Progress tell = progress ? progress : [](std::size_t, std::size_t) {};
  tell(0, 0);
  // Any type first, since the answer names it; servers that do not know that are asked for each.
  std::vector<std::string> sums = {"*"};
  for (const Type& type : types) {
    sums.push_back(type.md5);
  }
  std::string reason;
  for (const std::string& md5 : sums) {
    TcpStream stream(host, port, cancellation_);
    const ros::Header header = exchangeHeaders(stream, name, md5);
    if (header.getValue("error", reason)) {
      continue;
    }
    std::string given;
    header.getValue("md5sum", given);
    const auto type = std::find(sums.begin() + 1, sums.end(), given);
    if (type != sums.end()) {
      Answer answer = exchange(stream, request, tell);
      answer.type = static_cast<std::size_t>(type - sums.begin() - 1);
      return answer;
    }
    given.clear();
    header.getValue("type", given);
    throw WrongService("it is of the type " + (given.empty() ? "'unknown'" : given) +
                       " and not of " + types.front().name + " as of release 1.1");
  }
  throw WrongService(reason);
}

std::optional<XmlRpc::XmlRpcValue> ServiceCall::callMaster(
    const std::string& method, const std::vector<std::string>& arguments) const
{
  std::string answer;
  try {
    TcpStream stream(ros::master::getHost(), ros::master::getPort(), cancellation_);
    const std::string request = requestOf(method, arguments);
    stream.write(request.data(), request.size());
    answer = stream.readToEnd(MOST_MASTER_BYTES, MASTER_MILLISECONDS);
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
