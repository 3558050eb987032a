"""A client as users have written it with SMACH (navigation_sm.py of pluto_robot): actionlib alone.

It waits for a goal on /goal, asks get_path for a path and exe_path to follow it, and waits again,
whatever became of it. SMACH itself is not needed to see what such a machine sees.
"""

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import ExePathAction, ExePathGoal, ExePathResult
from mbf_msgs.msg import GetPathAction, GetPathGoal, GetPathResult, RecoveryAction

FAILED = ("PAT_EXCEEDED", "BLOCKED_PATH", "FAILURE", "MISSED_PATH", "MISSED_GOAL", "NO_VALID_CMD")
FAILED += ("OSCILLATION", "ROBOT_STUCK")
ABORTED = ("COLLISION", "CANCELED", "INTERNAL_ERROR", "INVALID_PATH", "INVALID_PLUGIN")
ABORTED += ("NOT_INITIALIZED", "TF_ERROR", "OUT_OF_MAP", "MAP_ERROR", "STOPPED")


class NavigationMachine:
    """The states are methods; each returns the next one, and None ends the machine.

    ``history`` has an entry (state, outcome of the state) for each one that was left, ``data`` what
    the states hand on to each other.
    """

    def __init__(self, planner="wave_front_planner", controller="mesh_controller"):
        self._planner, self._controller = planner, controller
        self.history, self.data = [], {}
        self._goals = []
        self._clients = {
            name: actionlib.SimpleActionClient(f"move_base_flex/{name}", kind)
            for name, kind in (
                ("get_path", GetPathAction),
                ("exe_path", ExePathAction),
                ("recovery", RecoveryAction),
            )
        }
        self._subscriber = rospy.Subscriber("/goal", PoseStamped, self._goals.append)
        for client in self._clients.values():
            client.wait_for_server()

    def run(self, goals):
        """Go through the states until that many goals have come to an end."""
        state = self.wait_for_goal
        while state is not None and not rospy.is_shutdown():
            if state == self.wait_for_goal:
                goals -= 1
            state = None if goals < 0 else state()

    def wait_for_goal(self):
        """Until somebody clicks into the map."""
        while not self._goals:
            if rospy.is_shutdown():
                return None
            rospy.rostime.wallsleep(0.01)
        self.data = {"target_pose": self._goals.pop(0)}
        return self._leave("WAIT_FOR_GOAL", "received_goal", self.planning)

    def planning(self):
        """Ask for a path from where the robot is."""
        goal = GetPathGoal(
            use_start_pose=False,
            tolerance=0.2,
            target_pose=self.data["target_pose"],
            planner=self._planner,
        )
        status, result = self._ask("get_path", goal)
        self.data.update(
            outcome=result.outcome, message=result.message, path=result.path, cost=result.cost
        )
        if result.outcome == GetPathResult.SUCCESS and status == GoalStatus.SUCCEEDED:
            return self._leave("PLANNING", "succeeded", self.control)
        outcome = "preempted" if result.outcome == GetPathResult.CANCELED else "aborted"
        return self._leave("PLANNING", outcome, self.wait_for_goal)

    def control(self):
        """Follow that path."""
        goal = ExePathGoal(path=self.data["path"], controller=self._controller)
        status, result = self._ask("exe_path", goal)
        self.data.update(
            outcome=result.outcome,
            message=result.message,
            final_pose=result.final_pose,
            dist_to_goal=result.dist_to_goal,
            angle_to_goal=result.angle_to_goal,
        )
        if result.outcome == ExePathResult.SUCCESS and status == GoalStatus.SUCCEEDED:
            outcome = "succeeded"
        elif result.outcome in (getattr(ExePathResult, name) for name in FAILED):
            outcome = "failed"
        elif result.outcome in (getattr(ExePathResult, name) for name in ABORTED):
            outcome = "aborted"
        else:
            outcome = "unknown"
        return self._leave("CONTROL", outcome, self.wait_for_goal)

    def _ask(self, action, goal):
        client = self._clients[action]
        client.send_goal_and_wait(goal)
        return client.get_state(), client.get_result()

    def _leave(self, state, outcome, following):
        self.history.append((state, outcome))
        return following
