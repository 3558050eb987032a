"""Sends the goals that are clicked in RViz to move_base."""

import threading
from typing import Any, List, Optional, Sequence, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import MoveBaseGoal

from mesh_map.base.parameter import Parameter, misspelled, read_parameters
from mesh_msgs.diagnostics_ros import OK, WARN, Diagnostics, Status
from mesh_msgs.init_node import init_node, spin, until_shutdown

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Deadline
from mesh_navigation.client.action_caller_ros import ActionCall
from mesh_navigation.client.goals_ros import Goals
from mesh_navigation.client.navigation_result import NavigationError

PARAMETERS = (
    Parameter("server", "move_base_flex", description="node of the navigation server"),
    Parameter("goal_topic", "/goal", description="where goals come from"),
    Parameter("planner", "", description="name of a planner; empty: the server's first"),
    Parameter("controller", "", description="name of a controller; empty: the server's first"),
)


class GoalBridge:
    """Each goal on the topic is sent to move_base; a newer one replaces the one before.

    A goal that comes while there is no server is dropped: a robot that sets off when its server is
    started, because somebody clicked long ago, is a danger.
    """

    def __init__(self) -> None:
        given = rospy.get_param("~", {}) or {}
        self._values, complaints = read_parameters(PARAMETERS, given)
        known = ["recovery_behaviors", *(parameter.name for parameter in PARAMETERS)]
        for complaint in complaints + misspelled(given, known):
            rospy.logwarn("parameter ~%s", complaint)
        self._behaviors = _names(rospy.get_param("~recovery_behaviors", []))
        server = rospy.resolve_name(self._values["server"])
        self._name = f"{server}/move_base"
        self._goals = Goals(server)
        self._goals.has_server("move_base")  # begins to connect
        self._lock = threading.Lock()
        self._newest: Optional[PoseStamped] = None
        self._defaults = MoveBaseGoal()
        rospy.Subscriber(f"{server}/goal_defaults", MoveBaseGoal, self._on_defaults, queue_size=1)
        topic = self._values["goal_topic"]
        subscriber = rospy.Subscriber(topic, PoseStamped, self._on_goal, queue_size=10)
        rospy.loginfo(
            "%s: waiting for the action server %s, then for goals on %s",
            rospy.get_name(),
            self._name,
            subscriber.resolved_name,
        )
        self._diagnostics = Diagnostics("goals", self._status)

    def _status(self) -> Status:
        """For /diagnostics."""
        if not self._goals.has_server("move_base"):
            return Status(WARN, f"there is no action server {self._name}")
        return Status(OK, f"goals are sent to {self._name}")

    def _on_defaults(self, defaults: MoveBaseGoal) -> None:
        """Who clicks has chosen plugins, by their names; of empty ones the parameters count."""
        self._defaults = defaults
        planner, controller, _ = self._plugins()
        rospy.loginfo(
            "%s: from now on planner %s and controller %s",
            rospy.get_name(),
            planner or "(the server's first)",
            controller or "(the server's first)",
        )

    def _plugins(self) -> Tuple[str, str, List[str]]:
        """Planner, controller and recovery behaviors of the next goal."""
        chosen, values = self._defaults, self._values
        return (
            chosen.planner or values["planner"],
            chosen.controller or values["controller"],
            list(chosen.recovery_behaviors) or self._behaviors,
        )

    def _on_goal(self, goal: PoseStamped) -> None:
        if not self._goals.has_server("move_base"):
            why = f"there is no action server {self._name} yet; click again later"
            rospy.logwarn("goal %s is dropped: %s", _text(goal), why)
            return
        planner, controller, behaviors = self._plugins()
        message = MoveBaseGoal(goal, controller, planner, behaviors)
        try:
            with self._lock:  # the server takes the last one that comes for the newest
                self._newest = goal
                call = self._goals.begin("move_base", message)
        except rospy.ROSException:  # this node is shut down
            return
        rospy.loginfo("goal %s: sent to %s", _text(goal), self._name)
        threading.Thread(target=self._finish, args=(goal, call), daemon=True).start()

    def _finish(self, goal: PoseStamped, call: ActionCall) -> None:
        try:
            result = self._goals.finish(call, Deadline(None), Cancellation())
        except NavigationError as error:
            rospy.logerr("goal %s: %s", _text(goal), error)
        except rospy.ROSInterruptException:
            pass  # the end of this node cancels the goal
        else:
            if result.succeeded:
                rospy.loginfo("goal %s: %s", _text(goal), result)
            elif self._newest is not goal:
                rospy.loginfo("goal %s: replaced by a newer one", _text(goal))
            else:
                rospy.logwarn("goal %s: %s", _text(goal), result)


def _names(behaviors: Any) -> List[str]:
    if isinstance(behaviors, list) and all(isinstance(name, str) for name in behaviors):
        return behaviors
    text = "parameter ~recovery_behaviors is %r, it has to be a list of names: all are used"
    rospy.logwarn(text, behaviors)
    return []


def _text(goal: PoseStamped) -> str:
    position = goal.pose.position
    place = f"({position.x:.2f}, {position.y:.2f}, {position.z:.2f})"
    return f"{place} in '{goal.header.frame_id}'"


def main(arguments: Optional[Sequence[str]] = None) -> None:
    """Run the node until it is shut down."""
    init_node("goal_bridge", argv=arguments, about=__doc__, package="mesh_navigation")
    with until_shutdown():
        GoalBridge()
    spin()
