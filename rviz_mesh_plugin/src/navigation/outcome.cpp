#include "navigation/outcome.h"

#include <array>

#include <actionlib_msgs/GoalStatus.h>
#include <mbf_msgs/ExePathResult.h>
#include <mbf_msgs/GetPathResult.h>
#include <mbf_msgs/MoveBaseResult.h>
#include <mbf_msgs/RecoveryResult.h>

#include "base/status_lines.h"

namespace rviz_mesh_plugin {
namespace {

struct Named
{
  std::uint32_t number;
  const char* name;
};

using Going = mbf_msgs::MoveBaseResult;
using Planning = mbf_msgs::GetPathResult;
using Driving = mbf_msgs::ExePathResult;
using Recovery = mbf_msgs::RecoveryResult;

const Named NAMES[] = {
    {Going::SUCCESS, "SUCCESS"},
    {Going::FAILURE, "FAILURE"},
    {Going::CANCELED, "CANCELED"},
    {Going::COLLISION, "COLLISION"},
    {Going::OSCILLATION, "OSCILLATION"},
    {Going::START_BLOCKED, "START_BLOCKED"},
    {Going::GOAL_BLOCKED, "GOAL_BLOCKED"},
    {Going::TF_ERROR, "TF_ERROR"},
    {Going::INTERNAL_ERROR, "INTERNAL_ERROR"},
    {Planning::FAILURE, "FAILURE"},
    {Planning::CANCELED, "CANCELED"},
    {Planning::INVALID_START, "INVALID_START"},
    {Planning::INVALID_GOAL, "INVALID_GOAL"},
    {Planning::NO_PATH_FOUND, "NO_PATH_FOUND"},
    {Planning::PAT_EXCEEDED, "PAT_EXCEEDED"},
    {Planning::EMPTY_PATH, "EMPTY_PATH"},
    {Planning::TF_ERROR, "TF_ERROR"},
    {Planning::NOT_INITIALIZED, "NOT_INITIALIZED"},
    {Planning::INVALID_PLUGIN, "INVALID_PLUGIN"},
    {Planning::INTERNAL_ERROR, "INTERNAL_ERROR"},
    {Planning::OUT_OF_MAP, "OUT_OF_MAP"},
    {Planning::MAP_ERROR, "MAP_ERROR"},
    {Planning::STOPPED, "STOPPED"},
    {Driving::FAILURE, "FAILURE"},
    {Driving::CANCELED, "CANCELED"},
    {Driving::NO_VALID_CMD, "NO_VALID_CMD"},
    {Driving::PAT_EXCEEDED, "PAT_EXCEEDED"},
    {Driving::COLLISION, "COLLISION"},
    {Driving::OSCILLATION, "OSCILLATION"},
    {Driving::ROBOT_STUCK, "ROBOT_STUCK"},
    {Driving::MISSED_GOAL, "MISSED_GOAL"},
    {Driving::MISSED_PATH, "MISSED_PATH"},
    {Driving::BLOCKED_PATH, "BLOCKED_PATH"},
    {Driving::INVALID_PATH, "INVALID_PATH"},
    {Driving::TF_ERROR, "TF_ERROR"},
    {Driving::NOT_INITIALIZED, "NOT_INITIALIZED"},
    {Driving::INVALID_PLUGIN, "INVALID_PLUGIN"},
    {Driving::INTERNAL_ERROR, "INTERNAL_ERROR"},
    {Driving::OUT_OF_MAP, "OUT_OF_MAP"},
    {Driving::MAP_ERROR, "MAP_ERROR"},
    {Driving::STOPPED, "STOPPED"},
    {Recovery::FAILURE, "FAILURE"},
    {Recovery::CANCELED, "CANCELED"},
    {Recovery::PAT_EXCEEDED, "PAT_EXCEEDED"},
    {Recovery::TF_ERROR, "TF_ERROR"},
    {Recovery::NOT_INITIALIZED, "NOT_INITIALIZED"},
    {Recovery::INVALID_PLUGIN, "INVALID_PLUGIN"},
    {Recovery::INTERNAL_ERROR, "INTERNAL_ERROR"},
    {Recovery::STOPPED, "STOPPED"},
    {Recovery::IMPASSABLE, "IMPASSABLE"},
};

/// Who gives numbers that have no constant.
const char* rangeOf(std::uint32_t outcome)
{
  if (outcome < Going::FAILURE) {
    return "SUCCESS";
  }
  if (outcome < Planning::FAILURE) {
    return "an outcome of move_base that has no name";
  }
  if (outcome < Driving::FAILURE) {
    return "a planner's own outcome";
  }
  if (outcome < Recovery::FAILURE) {
    return "a controller's own outcome";
  }
  return outcome < 200 ? "a recovery behavior's own outcome" : "an outcome that has no name";
}

const char* nameOfStatus(std::uint8_t status)
{
  using Status = actionlib_msgs::GoalStatus;
  switch (status) {
    case Status::SUCCEEDED:
      return "SUCCEEDED";
    case Status::REJECTED:
      return "REJECTED";
    case Status::PREEMPTED:
    case Status::RECALLED:
      return "CANCELED";
    case Status::LOST:
      return "LOST";
    default:
      return "ABORTED";
  }
}

}  // namespace

std::string nameOfOutcome(std::uint32_t outcome)
{
  const char* name = rangeOf(outcome);
  for (const Named& named : NAMES) {
    name = named.number == outcome ? named.name : name;
  }
  return joined(name, " (", outcome, ")");
}

Outcome outcomeOf(std::uint8_t status, const std::string& status_text, std::uint32_t outcome,
                  const std::string& message)
{
  constexpr std::size_t MOST = 2000;
  Outcome result;
  result.succeeded = status == actionlib_msgs::GoalStatus::SUCCEEDED;
  const bool agree = result.succeeded == (outcome < Going::FAILURE);
  result.name = agree ? nameOfOutcome(outcome) : nameOfStatus(status);
  result.message = shortened(message.empty() ? status_text : message, MOST);
  return result;
}

}  // namespace rviz_mesh_plugin
