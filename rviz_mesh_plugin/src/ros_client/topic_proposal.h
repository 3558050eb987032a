#pragma once

#include <optional>
#include <string>

#include "ros_client/topic_list.h"

namespace rviz_mesh_plugin {

/// Looks for the topics that belong to a mesh: those in the namespace of its own.
class TopicProposal
{
 public:
  struct Topics
  {
    std::string costs;   ///< empty: there are none
    std::string colors;  ///< empty: there are none
  };

  /// What has been asked for before is forgotten.
  void ask(const std::string& geometry_topic);

  /// Once, when the master has answered.
  std::optional<Topics> take();

 private:
  std::string parent_;
  TopicList list_;
};

}  // namespace rviz_mesh_plugin
