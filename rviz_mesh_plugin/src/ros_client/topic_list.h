#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

namespace rviz_mesh_plugin {

class Cancellation;
class EndingThread;

/// Asks the ROS master for all topics that are published, on a thread of its own, which nobody
/// waits for.
class TopicList
{
 public:
  using Types = std::map<std::string, std::string>;  ///< by the name of the topic

  TopicList();
  ~TopicList();
  TopicList(const TopicList&) = delete;
  TopicList& operator=(const TopicList&) = delete;

  /// What has been asked for before is given up.
  void ask();
  /// Whether the master has been asked and has neither answered nor failed.
  bool asking() const;
  /// Once, when the master has answered.
  std::optional<Types> take();

 private:
  struct Question;
  void giveUp();

  std::shared_ptr<Question> question_;
  std::unique_ptr<EndingThread> thread_;
};

}  // namespace rviz_mesh_plugin
