#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

/// No connection, or no more.
class ConnectionLost : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// A TCP connection that every wait of can be cancelled. All members throw ConnectionLost and
/// Cancelled.
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
  bool connectTo(const void* address_info);
  std::size_t readSome(void* data, std::size_t size, int milliseconds);

  const Cancellation& cancellation_;
  std::string peer_;
  int socket_ = -1;
};

}  // namespace rviz_mesh_plugin
