#pragma once

#include <stdexcept>
#include <string>

namespace mesh_map {

/// Throws std::invalid_argument with this message unless the condition holds.
inline void require(bool condition, const char* message)
{
  if (!condition) {
    throw std::invalid_argument(message);
  }
}

inline void require(bool condition, const std::string& message)
{
  require(condition, message.c_str());
}

}  // namespace mesh_map
