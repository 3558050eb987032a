#pragma once

#include <map>
#include <string>
#include <vector>

#include <actionlib_msgs/GoalID.h>
#include <actionlib_msgs/GoalStatusArray.h>
#include <mbf_msgs/ExePathActionFeedback.h>
#include <mbf_msgs/ExePathActionGoal.h>
#include <mbf_msgs/ExePathActionResult.h>
#include <mbf_msgs/GetPathActionGoal.h>
#include <mbf_msgs/GetPathActionResult.h>
#include <mbf_msgs/MoveBaseActionFeedback.h>
#include <mbf_msgs/MoveBaseActionGoal.h>
#include <mbf_msgs/MoveBaseActionResult.h>
#include <mbf_msgs/RecoveryActionGoal.h>
#include <ros/node_handle.h>

/// The topics of a server of Move Base Flex, whose goals go as a test says.
class FakeNavigationServer
{
 public:
  using Status = actionlib_msgs::GoalStatus;

  explicit FakeNavigationServer(const std::string& name) : name_(name)
  {
    for (const char* action : {"move_base", "exe_path", "get_path", "recovery"}) {
      statuses_[action] =
          node_.advertise<actionlib_msgs::GoalStatusArray>(topic(action, "status"), 5);
      cancels_.push_back(node_.subscribe<actionlib_msgs::GoalID>(
          topic(action, "cancel"), 5,
          [this, action](const actionlib_msgs::GoalID::ConstPtr&) { canceled.push_back(action); }));
    }
    results_ = node_.advertise<mbf_msgs::MoveBaseActionResult>(topic("move_base", "result"), 5);
    plans_ = node_.advertise<mbf_msgs::GetPathActionResult>(topic("get_path", "result"), 5);
    feedback_ =
        node_.advertise<mbf_msgs::MoveBaseActionFeedback>(topic("move_base", "feedback"), 5);
    goals_ = node_.advertise<mbf_msgs::MoveBaseActionGoal>(topic("move_base", "goal"), 5);
    paths_ = node_.advertise<mbf_msgs::ExePathActionGoal>(topic("exe_path", "goal"), 5);
    recoveries_ = node_.advertise<mbf_msgs::RecoveryActionGoal>(topic("recovery", "goal"), 5);
    timer_ = node_.createWallTimer(ros::WallDuration(0.1), [this](const ros::WallTimerEvent&) {
      if (alive) {
        tell();
      }
    });
  }

  ~FakeNavigationServer() { node_.deleteParam(name_); }

  std::string topic(const std::string& action, const std::string& name) const
  {
    return name_ + "/" + action + "/" + name;
  }
  const std::string& name() const { return name_; }

  /// Whether somebody listens to everything.
  bool isWatched() const
  {
    return results_.getNumSubscribers() > 0 && goals_.getNumSubscribers() > 0 &&
           plans_.getNumSubscribers() > 0 && feedback_.getNumSubscribers() > 0 &&
           paths_.getNumSubscribers() > 0 && recoveries_.getNumSubscribers() > 0;
  }

  static actionlib_msgs::GoalID id(const std::string& name)
  {
    static int stamp = 1000;
    actionlib_msgs::GoalID made;
    made.id = name;
    made.stamp = ros::Time(++stamp, 0);
    return made;
  }

  /// A goal of a client, as it goes over the topic to the server.
  actionlib_msgs::GoalID sendGoal(const std::string& name, double x,
                                  const geometry_msgs::PoseStamped* target = nullptr)
  {
    mbf_msgs::MoveBaseActionGoal message;
    message.goal_id = id(name);
    message.goal.target_pose.header.frame_id = "map";
    message.goal.target_pose.pose.position.x = x;
    message.goal.target_pose.pose.orientation.w = 1.0;
    if (target) {
      message.goal.target_pose = *target;
    }
    goals_.publish(message);
    set("move_base", message.goal_id, Status::ACTIVE);
    return message.goal_id;
  }

  void set(const std::string& action, const actionlib_msgs::GoalID& goal, int status)
  {
    Status& told = goals[action][goal.id];
    told.goal_id = goal;
    told.status = static_cast<std::uint8_t>(status);
    tell();
  }
  void forget(const std::string& action)
  {
    goals[action].clear();
    tell();
  }

  void end(const actionlib_msgs::GoalID& goal, int status, unsigned outcome,
           const std::string& text)
  {
    mbf_msgs::MoveBaseActionResult message;
    message.status.goal_id = goal;
    message.status.status = static_cast<std::uint8_t>(status);
    message.result.outcome = outcome;
    message.result.message = text;
    set("move_base", goal, status);
    results_.publish(message);
  }

  void failPlan(unsigned outcome, const std::string& text)
  {
    mbf_msgs::GetPathActionResult message;
    message.status.status = Status::ABORTED;
    message.result.outcome = outcome;
    message.result.message = text;
    plans_.publish(message);
  }

  void recover(const std::string& behavior)
  {
    mbf_msgs::RecoveryActionGoal message;
    message.goal_id = id("recovery");
    message.goal.behavior = behavior;
    recoveries_.publish(message);
    set("recovery", message.goal_id, Status::ACTIVE);
  }

  /// Drives along x.
  void drive(double from, double to)
  {
    mbf_msgs::ExePathActionGoal message;
    message.goal_id = id("drive");
    message.goal.path.header.frame_id = "map";
    for (const double x : {from, to}) {
      geometry_msgs::PoseStamped pose;
      pose.pose.position.x = x;
      message.goal.path.poses.push_back(pose);
    }
    paths_.publish(message);
    set("exe_path", message.goal_id, Status::ACTIVE);
  }

  void at(const actionlib_msgs::GoalID& goal, double x)
  {
    mbf_msgs::MoveBaseActionFeedback message;
    message.status.goal_id = goal;
    message.feedback.dist_to_goal = 1.0f;
    message.feedback.current_pose.header.frame_id = "map";
    message.feedback.current_pose.pose.position.x = x;
    feedback_.publish(message);
  }

  bool alive = true;
  std::map<std::string, std::map<std::string, Status>> goals;  ///< by action and id
  std::vector<std::string> canceled;                           ///< actions

 private:
  void tell()
  {
    for (const auto& action : statuses_) {
      actionlib_msgs::GoalStatusArray message;
      for (const auto& goal : goals[action.first]) {
        message.status_list.push_back(goal.second);
      }
      action.second.publish(message);
    }
  }

  const std::string name_;
  ros::NodeHandle node_;
  std::map<std::string, ros::Publisher> statuses_;
  std::vector<ros::Subscriber> cancels_;
  ros::Publisher results_, plans_, feedback_, goals_, paths_, recoveries_;
  ros::WallTimer timer_;
};
