#pragma once

#include <stdexcept>
#include <vector>

#include "rviz_mesh_plugin/validation.h"

namespace rviz_mesh_plugin {

/// A message that cannot be shown; what() is one sentence for the status line.
class RejectedMessage : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// @throw RejectedMessage unless @a findings is empty
inline void refuse(const std::vector<Finding>& findings)
{
  if (!findings.empty()) {
    throw RejectedMessage(summarize(findings));
  }
}

}  // namespace rviz_mesh_plugin
