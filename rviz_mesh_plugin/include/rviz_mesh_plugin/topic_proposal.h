#pragma once

#include <memory>
#include <optional>
#include <string>

namespace rviz_mesh_plugin {

class EndingThread;

/// Looks for the topics that belong to a mesh: those in the namespace of its own. The master is
/// asked on a thread of its own, which nobody waits for.
class TopicProposal
{
 public:
  TopicProposal();
  ~TopicProposal();

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
  struct Answer;
  std::shared_ptr<Answer> answer_;
  std::unique_ptr<EndingThread> thread_;
};

}  // namespace rviz_mesh_plugin
