#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <QObject>

#include <geometry_msgs/PoseStamped.h>

#include "navigation/navigation_server.h"
#include "navigation/server_directory.h"

class QTimer;

namespace rviz_mesh_plugin {

/// Tells in the status bar what becomes of a goal that a tool has published: somebody (goal_bridge)
/// makes an action goal of it, and the navigation server that gets that says the rest. GUI thread
/// only; nobody is waited for.
class GoalFollower : public QObject
{
 public:
  using Say = std::function<void(const std::string&)>;

  /// @param say shows a text; other tools write over it
  /// @param may_say whether the status bar belongs to nobody else, so that progress can be told
  GoalFollower(Say say, std::function<bool()> may_say);
  ~GoalFollower() override;

  /// Looks for servers from now on, so that they are known when a goal is published. The status bar
  /// is the tool's own until release(): only outcomes are told meanwhile.
  void prepare();
  void release() { released_ = true; }

  /// From now on this goal is followed, and the one before no longer.
  /// @param topic that it was published on
  void follow(const geometry_msgs::PoseStamped& goal, const std::string& topic);

 private:
  using Time = ServerWatch::Time;

  struct Followed
  {
    geometry_msgs::PoseStamped goal;
    std::string topic;
    Time since;
    std::set<std::string> older;               ///< ids of the goals that were there before
    const NavigationServer* server = nullptr;  ///< null: none has it yet
    std::string id;
    bool doubted = false;  ///< whether it was said that none has it
  };

  void work();
  void followServers(Time now);
  void find(Time now);
  void tell(Time now);
  void doubt(bool any_speaks, Time now);
  void tellOutcome(const std::string& text, Time now);

  Say say_;
  std::function<bool()> may_say_;
  ServerDirectory directory_;
  std::map<std::string, std::unique_ptr<NavigationServer>> servers_;
  std::optional<Followed> followed_;
  bool released_ = false;
  Time used_;  ///< the last time that somebody wanted it
  std::string said_;
  Time said_at_;
  std::string outcome_;  ///< to be said once more, since other tools write over it
  Time outcome_at_;
  QTimer* timer_;
};

}  // namespace rviz_mesh_plugin
