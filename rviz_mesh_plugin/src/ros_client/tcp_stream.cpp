#include "ros_client/tcp_stream.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace rviz_mesh_plugin {
namespace {

constexpr int CONNECT_MILLISECONDS = 5000;

void setOption(int socket, int level, int name, int value)
{
  // Without it the connection works, too.
  setsockopt(socket, level, name, &value, sizeof(value));
}

}  // namespace

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
      if (connectTo(one)) {
        return;
      }
    }
  } catch (...) {
    if (socket_ >= 0) {
      close(socket_);
    }
    throw;
  }
  throw ConnectionLost("nobody accepts connections at " + peer_);
}

TcpStream::~TcpStream()
{
  close(socket_);
}

bool TcpStream::connectTo(const void* address_info)
{
  const addrinfo& address = *static_cast<const addrinfo*>(address_info);
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

}  // namespace rviz_mesh_plugin
