#!/usr/bin/python3
"""The real RViz, with mouse and keyboard: all buttons, lists and fields of the panel of navigation,
and what servers get of it."""
import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import (
    MoveBaseActionFeedback,
    MoveBaseActionGoal,
    MoveBaseActionResult,
    MoveBaseGoal,
    MoveBaseResult,
)
from std_srvs.srv import Empty, EmptyResponse

from mesh_tools_test.demo.processes import process, wait_until
from mesh_tools_test.screen.labelling import LabellingCase
from mesh_tools_test.screen.widgets import Widgets

NAVIGATION = "rviz_mesh_plugin--MeshNavigationPanel"
CHOICES = {"server": "Node of", "planner": "Planner of", "controller": "Controller of"}
NAVIGATION_WIDGETS = Widgets(
    {
        **{
            f"{name}: list": f'{NAVIGATION} > QComboBox[toolTip^="{tip}"]::drop-down'
            for name, tip in CHOICES.items()
        },
        **{
            f"{name}: field": f'{NAVIGATION} > QComboBox[toolTip^="{tip}"]'
            for name, tip in CHOICES.items()
        },
        **{
            text: f'{NAVIGATION} > QPushButton[text="{text}"]:enabled'
            for text in ("Cancel", "Clear Layers")
        },
    }
)


def plugins(kind):
    """Names of planners or controllers, as servers have them as a parameter."""
    return [{"name": f"{kind[:-1]}_{number}", "type": "fake"} for number in (1, 2, 3)]


class FakeServer:
    """The topics of a server of Move Base Flex, and what comes to it."""

    def __init__(self, name):
        self.name, self.goals, self.canceled, self.cleared = name, [], [], 0
        self._defaults, self._statuses = [], {}
        rospy.set_param(name, {kind: plugins(kind) for kind in ("planners", "controllers")})
        self._feedback = rospy.Publisher(
            f"{name}/move_base/feedback", MoveBaseActionFeedback, queue_size=5
        )
        self._results = rospy.Publisher(
            f"{name}/move_base/result", MoveBaseActionResult, queue_size=5
        )
        self._status = rospy.Publisher(f"{name}/move_base/status", GoalStatusArray, queue_size=5)
        self._goal = rospy.Subscriber(f"{name}/move_base/goal", MoveBaseActionGoal, self._on_goal)
        rospy.Subscriber(f"{name}/move_base/cancel", GoalID, self._on_cancel)
        rospy.Subscriber(f"{name}/goal_defaults", MoveBaseGoal, self._defaults.append)
        rospy.Service(f"{name}/clear_mesh", Empty, self._on_clear)
        rospy.Timer(rospy.Duration(0.1), self._tell)

    def is_followed(self):
        """Whether a client is connected to all of it."""
        publishers = (self._feedback, self._results, self._status)
        return self._goal.get_num_connections() and all(
            publisher.get_num_connections() for publisher in publishers
        )

    def told(self):
        """Planner and controller of goals that are clicked, as they were told last."""
        last = self._defaults[-1] if self._defaults else MoveBaseGoal()
        return last.planner, last.controller

    def _on_goal(self, goal):
        self.goals.append(goal)
        self._statuses[goal.goal_id.id] = GoalStatus(goal.goal_id, GoalStatus.ACTIVE, "")

    def _on_cancel(self, goal_id):
        """Without an id and a stamp: of all goals."""
        self.canceled.append(goal_id)
        for status in list(self._statuses.values()):
            if status.status == GoalStatus.ACTIVE and goal_id.id in ("", status.goal_id.id):
                status.status = GoalStatus.PREEMPTED
                result = MoveBaseActionResult(status=status)
                result.result.outcome, result.result.message = MoveBaseResult.CANCELED, "canceled"
                self._results.publish(result)

    def _on_clear(self, _request):
        self.cleared += 1
        return EmptyResponse()

    def _tell(self, _event):
        self._status.publish(GoalStatusArray(status_list=list(self._statuses.values())))


class RvizNavigationPanel(LabellingCase):
    """Panel *Mesh Navigation*, with two servers, and the node that sends on what is clicked."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("rviz_navigation_panel")

    def test_every_button(self):
        """By what the servers get of it."""
        one, two = FakeServer("/robot_1"), FakeServer("/robot_2")
        command = ["rosrun", "mesh_navigation", "goal_bridge", f"_server:={two.name}"]
        clicked = rospy.Publisher("/goal", PoseStamped, queue_size=1)
        self.stack.callback(clicked.unregister)
        with process("goal_bridge", command, self.folder / "logs") as bridge, self.rviz(
            "navigation", "    []", panel="MeshNavigation", widgets=NAVIGATION_WIDGETS
        ) as screen:
            wait_until(
                lambda: clicked.get_num_connections() and two.is_followed(),
                60,
                "what sends goals on",
                [screen.child, bridge],
            )

            def wait(condition, what):
                wait_until(condition, 60, what, [screen.child, bridge])

            # Of two servers none is chosen by itself; the second one is chosen in the list.
            screen.find("server: list")
            self.assertFalse(screen.is_there("Cancel"))
            screen.choose("server: list", 1)
            screen.find("Clear Layers")  # the server's names are known, too
            screen.choose("planner: list", 1)
            wait(lambda: two.told() == ("planner_2", ""), "the planner")
            screen.choose("controller: list", 2)
            wait(lambda: two.told() == ("planner_2", "controller_3"), "the controller")
            screen.fill("planner: field", "planner_1")
            screen.do("key", "Return")
            wait(lambda: two.told() == ("planner_1", "controller_3"), "the planner as typed")

            goal = PoseStamped()
            goal.header.frame_id, goal.pose.orientation.w = "map", 1.0
            clicked.publish(goal)
            wait(lambda: two.goals, "the goal")
            asked = two.goals[0].goal
            self.assertEqual((asked.planner, asked.controller), ("planner_1", "controller_3"))
            screen.click("Cancel")
            wait(lambda: two.canceled, "a cancel")
            screen.click("Clear Layers")
            wait(lambda: two.cleared, "a call of clear_mesh")

            # Another server: it is told the choice at once, and gets what the buttons do.
            screen.fill("server: field", one.name)
            screen.do("key", "Return")
            wait(lambda: one.told() == ("planner_1", "controller_3"), "the choice")
            screen.click("Cancel")
            wait(lambda: one.canceled, "a cancel")
            screen.click("Clear Layers")
            wait(lambda: one.cleared, "a call of clear_mesh")
            screen.fill("controller: field", "")
            screen.do("key", "Return")
            wait(lambda: one.told() == ("planner_1", ""), "no controller")
            self.assertEqual((len(two.goals), len(two.canceled), two.cleared), (1, 1, 1))
            self.assertEqual(one.goals, [])


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "rviz_navigation_panel", RvizNavigationPanel)
