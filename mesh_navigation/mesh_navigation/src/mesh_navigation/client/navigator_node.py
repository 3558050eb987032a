"""Navigation for one's own programs: goals out, results back."""

from typing import Any, Callable, Optional, Sequence

import rosgraph
import rospy
from mbf_msgs.msg import ExePathGoal, GetPathGoal, MoveBaseGoal, RecoveryGoal
from nav_msgs.msg import Path
from rosgraph.names import is_legal_name

from mesh_navigation.base.clock import Deadline
from mesh_navigation.client.action_caller_ros import OnFeedback
from mesh_navigation.client.goal_poses import goal_pose, has_heading, heading_of_arrival
from mesh_navigation.client.goals_ros import ACTIONS, Goals
from mesh_navigation.client.navigation_result import NavigationError, NavigationResult

# Concurrency slots of get_path for what is only asked: move_base plans on slot 0.
QUESTIONS, HEADINGS = 1, 255


class MeshNavigator:
    """A client of a Move Base Flex server. All methods may be called from any thread.

    Methods that send a goal return when it has ended; one that fails is no exception but a result.
    Ctrl+C, or the end of this node, cancels what has not ended.

        navigator = MeshNavigator()
        result = navigator.go_to(3.0, 1.0, 0.2)
        print(result.name, result.message)
    """

    def __init__(
        self, name: str = "move_base_flex", tell: Callable[[str], Any] = rospy.loginfo
    ) -> None:
        """Makes this process a node if it is none yet.

        Args:
            name: of the server's node.
            tell: gets a sentence when something takes a while, such as the server's start.

        Raises:
            NavigationError: there is no roscore.
            ValueError: no node can have this name.
        """
        if not rospy.core.is_initialized():
            if not rosgraph.is_master_online():
                raise NavigationError(f"there is no roscore at {rosgraph.get_master_uri()}")
            rospy.init_node("mesh_navigator", anonymous=True, disable_signals=True)
        if not is_legal_name(name):
            raise ValueError(f"{name!r} is no name of a node")
        self.name = rospy.resolve_name(name)
        self._tell = tell
        self._goals = Goals(self.name, tell)

    @property
    def map_frame(self) -> str:
        """The map's frame, as far as the server's parameters say."""
        return rospy.get_param(f"{self.name}/mesh_map/global_frame", "") or "map"

    def go_to(
        self,
        *goal: Any,
        yaw: Optional[float] = None,
        frame_id: str = "",
        planner: str = "",
        controller: str = "",
        recovery_behaviors: Sequence[str] = (),
        on_feedback: Optional[OnFeedback] = None,
        timeout: Optional[float] = None,
    ) -> NavigationResult:
        """Go to a pose (the action move_base).

        Args:
            goal: x, y, z (m), or x, y, z, yaw, or a PoseStamped, or a Pose.
            yaw: the heading there (rad); without it, that with which the path arrives.
            frame_id: of positions; the map's by default.
            planner: its name; the server's first by default.
            controller: the same.
            recovery_behaviors: names; all of the server's by default.
            on_feedback: called with each mbf_msgs/MoveBaseFeedback, in another thread.
            timeout: cancel the goal after so many seconds (wall time); also how long to wait for
                the server.

        Raises:
            NavigationError: there is no server within the timeout, or it has ended.
            ValueError: this is no goal.
        """
        deadline = Deadline(timeout)
        frame_id = frame_id or self.map_frame
        pose = goal_pose(*goal, yaw=yaw, frame_id=frame_id)
        with self._goals.job() as job:
            if not has_heading(*goal, yaw=yaw):
                question = GetPathGoal(target_pose=pose, planner=planner)
                question.concurrency_slot = HEADINGS
                plan = self._goals.run(job, "get_path", question, deadline)
                arrival = heading_of_arrival(plan.details.path)
                if plan.succeeded and arrival is not None:
                    pose = goal_pose(*goal, yaw=arrival, frame_id=frame_id)
                else:  # move_base says why, or a recovery behavior helps
                    self._tell(f"the heading of arrival is not known: {plan.message}")
            message = MoveBaseGoal(pose, controller, planner, list(recovery_behaviors))
            return self._goals.run(job, "move_base", message, deadline, on_feedback)

    def get_path(
        self,
        *goal: Any,
        yaw: Optional[float] = None,
        start: Any = None,
        frame_id: str = "",
        planner: str = "",
        tolerance: float = 0.0,
        slot: int = QUESTIONS,
        timeout: Optional[float] = None,
    ) -> NavigationResult:
        """Plan a path; the nav_msgs/Path is ``result.details.path``.

        Args:
            start: as a goal; the robot's pose by default.
            tolerance: as far from the goal may the path end, if it cannot be reached (m).
            slot: plans of one slot replace each other. move_base uses 0.

        The others are those of `go_to`.
        """
        frame_id = frame_id or self.map_frame
        message = GetPathGoal(planner=planner, tolerance=tolerance, concurrency_slot=slot)
        message.target_pose = goal_pose(*goal, yaw=yaw, frame_id=frame_id)
        if start is not None:
            message.use_start_pose = True
            message.start_pose = goal_pose(start, frame_id=frame_id)
        return self._run("get_path", message, timeout)

    def follow_path(
        self,
        path: Path,
        controller: str = "",
        dist_tolerance: Optional[float] = None,
        angle_tolerance: Optional[float] = None,
        slot: int = 0,
        on_feedback: Optional[OnFeedback] = None,
        timeout: Optional[float] = None,
    ) -> NavigationResult:
        """Drive along a path (the action exe_path).

        Args:
            dist_tolerance: how near to its end is there (m); the server's by default.
            angle_tolerance: the same of the heading (rad); both or none.

        The others are those of `go_to` and `get_path`.
        """
        message = ExePathGoal(path=path, controller=controller, concurrency_slot=slot)
        if (dist_tolerance is None) != (angle_tolerance is None):
            raise ValueError("dist_tolerance and angle_tolerance: give both, or none of them")
        if dist_tolerance is not None:
            message.tolerance_from_action = True
            message.dist_tolerance, message.angle_tolerance = dist_tolerance, angle_tolerance
        return self._run("exe_path", message, timeout, on_feedback)

    def recover(
        self, behavior: str = "", slot: int = 0, timeout: Optional[float] = None
    ) -> NavigationResult:
        """Run a recovery behavior, the server's first by default."""
        return self._run("recovery", RecoveryGoal(behavior, slot), timeout)

    def cancel(self) -> None:
        """Cancel all goals of this navigator; their methods return with the outcome CANCELED."""
        self._goals.cancel("the client canceled the goal")

    def wait_until_ready(self, *actions: str, timeout: Optional[float] = None) -> None:
        """Wait for the server, and say so after a moment. Goals do so by themselves.

        Args:
            actions: get_path, exe_path, recovery, move_base, all of them by default.
            timeout: s, wall time.

        Raises:
            NavigationError: there is none in time.
            ValueError: there is no such action.
        """
        for action in actions:
            if action not in ACTIONS:
                raise ValueError(f"{action!r} is none of {', '.join(ACTIONS)}")
        deadline = Deadline(timeout)
        for action in actions or ACTIONS:
            self._goals.wait_for_server(action, deadline)

    def _run(
        self,
        action: str,
        goal: Any,
        timeout: Optional[float],
        on_feedback: Optional[OnFeedback] = None,
    ) -> NavigationResult:
        deadline = Deadline(timeout)
        with self._goals.job() as job:
            return self._goals.run(job, action, goal, deadline, on_feedback)
