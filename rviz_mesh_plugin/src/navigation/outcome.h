#pragma once

#include <cstdint>
#include <string>

namespace rviz_mesh_plugin {

/// How a goal of a navigation server ended.
struct Outcome
{
  bool succeeded = false;
  std::string name;     ///< "GOAL_BLOCKED (15)"
  std::string message;  ///< the server's own, on one line; may be empty

  std::string text() const { return message.empty() ? name : name + ": " + message; }
};

/// Of a number in a result of Move Base Flex: the name of its constant in mbf_msgs with the number,
/// as "INVALID_GOAL (53)"; for numbers that have none, whose they are.
std::string nameOfOutcome(std::uint32_t outcome);

/// @param status of actionlib (constants of actionlib_msgs/GoalStatus): it counts where it and the
/// outcome contradict each other, since servers of actionlib answer some goals by themselves
/// @param status_text says more where the message is empty
Outcome outcomeOf(std::uint8_t status, const std::string& status_text, std::uint32_t outcome,
                  const std::string& message);

}  // namespace rviz_mesh_plugin
