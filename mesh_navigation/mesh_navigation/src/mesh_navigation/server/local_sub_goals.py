"""The sub-goals of move_base, sent to the servers of the same process. Messages, but no rospy."""

from typing import Any, Callable, Optional

from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import ExePathGoal, GetPathGoal, RecoveryGoal

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.move_base.sub_goals import Progress, SubActions, SubEnd, SubGoal, SubState
from mesh_navigation.server.local_goal import LocalGoal
from mesh_navigation.server.slots import REPLACED, TAKEN_OVER

OWNER = "move_base"
"""How the ids of the goals begin, so that users see whose they are."""
_STATES = {
    GoalStatus.SUCCEEDED: SubState.SUCCEEDED,
    GoalStatus.REJECTED: SubState.REJECTED,
    GoalStatus.PREEMPTED: SubState.CANCELED,
    GoalStatus.RECALLED: SubState.CANCELED,
}


class LocalSubGoal(SubGoal):
    """A goal of a server of this process."""

    def __init__(self, goal: LocalGoal, kind: str = "") -> None:
        self._goal = goal
        self._kind = kind

    def cancel(self, reason: str) -> None:
        self._goal.cancel(reason)

    def wait(self, cancellation: Cancellation, timeout: Optional[float]) -> Optional[SubEnd]:
        answer = self._goal.wait(cancellation, timeout)
        if answer is None:
            return None
        state, result = answer
        return SubEnd(
            _state(state, result.message),
            int(result.outcome),
            result.message,
            path=result.path if self._kind == "plan" else None,
            drive=result if self._kind == "drive" else None,
        )


def _state(state: int, message: str) -> SubState:
    found = _STATES.get(state, SubState.ABORTED)
    replaced = TAKEN_OVER in message or REPLACED in message
    return SubState.REPLACED if found is SubState.CANCELED and replaced else found


class LocalSubActions(SubActions):
    """Sends the sub-goals of one goal."""

    def __init__(
        self,
        get_path: Any,
        exe_path: Any,
        recovery: Any,
        target: PoseStamped,
        planner: str,
        controller: str,
        on_feedback: Callable[[Any], None],
    ) -> None:
        """
        Args:
            get_path, exe_path, recovery: the servers (`SlotActionServer`).
            target: the goal.
            planner, controller: their names.
            on_feedback: gets each feedback of exe_path.
        """
        self._get_path, self._exe_path, self._recovery = get_path, exe_path, recovery
        self._plan = GetPathGoal(use_start_pose=False, target_pose=target, planner=planner)
        self._controller = controller
        self._on_feedback = on_feedback

    def plan(self) -> SubGoal:
        goal = self._get_path.send(self._plan, owner=OWNER)
        return LocalSubGoal(goal, "plan")

    def drive(self, path: Any, on_progress: Callable[[Progress], None]) -> SubGoal:
        def on_feedback(feedback: Any) -> None:
            self._on_feedback(feedback)
            if feedback.current_pose.header.frame_id:  # else the robot's pose is not known
                pose = pose_from_message(feedback.current_pose)
                on_progress(Progress(pose, feedback.dist_to_goal, int(feedback.outcome)))

        goal = ExePathGoal(path=path, controller=self._controller)
        return LocalSubGoal(self._exe_path.send(goal, on_feedback, OWNER), "drive")

    def recover(self, behavior: str) -> SubGoal:
        goal = self._recovery.send(RecoveryGoal(behavior=behavior), owner=OWNER)
        return LocalSubGoal(goal)
