#pragma once

#include <cstddef>
#include <string>

namespace rviz_mesh_plugin {

/// How it went with the messages of one topic.
struct Reception
{
  std::size_t accepted = 0;
  std::size_t refused = 0;
  std::string refusal;       ///< why the newest message was refused; empty if it was accepted
  std::string last_refusal;  ///< why the last one was that was refused

  void accept()
  {
    ++accepted;
    refusal.clear();
  }
  void refuse(const std::string& reason)
  {
    ++refused;
    refusal = last_refusal = reason;
  }
  std::size_t received() const { return accepted + refused; }
};

}  // namespace rviz_mesh_plugin
