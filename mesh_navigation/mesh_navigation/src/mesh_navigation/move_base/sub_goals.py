"""The goals that going to a goal consists of: plans, drives, recovery behaviors, sent to the action
servers of the same process. Messages, but no rospy."""

import threading
from typing import Any, Callable, NamedTuple, Optional

from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import ExePathGoal, ExePathResult, GetPathGoal, GetPathResult, RecoveryGoal

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.base.outcomes import REPLACED, TAKEN_OVER, MoveBaseOutcome, is_success
from mesh_navigation.base.pose import Pose

OWNER = "move_base"
"""How the ids of the goals begin, so that users see whose they are."""
# For a sub-goal to end after its cancel (s): its server answers after half a second whatever its
# plugin does, so this passes only where something is very wrong.
PATIENCE = 5.0

Feedback = Callable[[Any], None]


class PlanAnswer(GetPathResult):
    """The answer to a plan, with what the message has no place for: within this process alone."""

    lasting: bool = False
    """Whether a failure stays so whatever sensors see, see `PlanResult`."""


class GoalEnd(NamedTuple):
    """What came of a sub-goal, or of all of them: of going to the goal."""

    outcome: int
    """A value of the outcomes of its action; of the whole, one of `MoveBaseOutcome` too."""
    message: str
    """One sentence for people."""
    state: int = GoalStatus.ABORTED
    """The last one, of actionlib_msgs/GoalStatus."""
    path: Any = None
    """Of a plan."""
    drive: Any = None
    """Where the drive ended that was the last sub-goal; None if that was none."""
    lasting: bool = False
    """Of a plan that failed: whether that stays so, whatever sensors see."""

    @classmethod
    def of(cls, state: int, result: Any) -> "GoalEnd":
        """What an action server answered."""
        path = result.path if isinstance(result, GetPathResult) else None
        drive = result if isinstance(result, ExePathResult) else None
        lasting = isinstance(result, PlanAnswer) and result.lasting
        return cls(int(result.outcome), result.message, state, path, drive, lasting)

    @property
    def succeeded(self) -> bool:
        """Whether it did what was wanted."""
        return self.state == GoalStatus.SUCCEEDED and is_success(self.outcome)

    @property
    def canceled(self) -> bool:
        """Whether somebody ended it, or a newer goal."""
        return self.state in (GoalStatus.PREEMPTED, GoalStatus.RECALLED)

    @property
    def replaced(self) -> bool:
        """Whether it was canceled in favor of a newer goal of the same slot."""
        return self.canceled and (TAKEN_OVER in self.message or REPLACED in self.message)


class SubGoal:
    """One goal that was sent, from the side of who sent it. From any thread."""

    def __init__(
        self, goal_id: str, cancel: Callable[[str], None], on_feedback: Optional[Feedback] = None
    ) -> None:
        """
        Args:
            goal_id: under which others see it.
            cancel: asks for its end, and returns at once; gets the reason.
            on_feedback: gets each feedback, in the thread of the goal: it must not block.
        """
        self.goal_id = goal_id
        self.on_feedback = on_feedback
        self._cancel = cancel
        self._changed = threading.Condition()
        self._end: Optional[GoalEnd] = None

    def cancel(self, reason: str) -> None:
        """Ask for its end, which comes as always; returns at once."""
        self._cancel(reason)

    def finish(self, state: int, result: Any) -> None:
        """The answer: a state of actionlib_msgs/GoalStatus and the result."""
        with self._changed:
            self._end = GoalEnd.of(state, result)
            self._changed.notify_all()

    def wait(
        self, cancellation: Optional[Cancellation] = None, timeout: Optional[float] = None
    ) -> Optional[GoalEnd]:
        """Its end; None if there is none within ``timeout`` (s, of the computer's clock; None: no
        limit), or as soon as ``cancellation``, which is not the goal's, is canceled."""
        cancellation = cancellation or Cancellation()
        with cancellation.calling(self._notify), self._changed:
            self._changed.wait_for(lambda: self._end is not None or cancellation.canceled, timeout)
            return self._end

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def stop(self, reason: str) -> Optional[GoalEnd]:
        """Cancel it; its end, None if it does not come."""
        self.cancel(reason)
        return self.wait(timeout=PATIENCE)


class DriveProgress(NamedTuple):
    """The robot, as a drive reports it in each cycle."""

    pose: Pose
    dist_to_goal: float
    """m."""
    outcome: int
    """Of this cycle: a value of `ExePathOutcome`."""


class SubActions:
    """Sends the sub-goals of one goal. Every method returns at once."""

    def __init__(
        self,
        get_path: Any,
        exe_path: Any,
        recovery: Any,
        target: PoseStamped,
        planner: str,
        controller: str,
        on_feedback: Feedback,
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
        """A plan from where the robot is to the goal."""
        return self._get_path.send(self._plan, owner=OWNER)

    def drive(self, path: Any, on_progress: Callable[[Optional[DriveProgress]], None]) -> SubGoal:
        """Follow a path; what is followed already goes on with the new path without a stop.

        Args:
            path: of a plan that succeeded.
            on_progress: called in each cycle, from another thread; None: the robot's pose is not
                known.
        """

        def on_feedback(feedback: Any) -> None:
            self._on_feedback(feedback)
            progress = None
            if feedback.current_pose.header.frame_id:
                pose = pose_from_message(feedback.current_pose.pose)
                progress = DriveProgress(pose, feedback.dist_to_goal, int(feedback.outcome))
            on_progress(progress)

        goal = ExePathGoal(path=path, controller=self._controller)
        return self._exe_path.send(goal, on_feedback, OWNER)

    def recover(self, behavior: str) -> SubGoal:
        """Run one recovery behavior."""
        return self._recovery.send(RecoveryGoal(behavior=behavior), owner=OWNER)


class MoveBaseOver(Exception):
    """Raised where going to the goal ends without success."""

    def __init__(self, end: GoalEnd) -> None:
        super().__init__(end.message)
        self.end = end


def ended(goal: SubGoal, what: str, cancellation: Cancellation) -> GoalEnd:
    """Wait until a sub-goal has succeeded or failed.

    Args:
        goal: the sub-goal.
        what: what it is called in messages.
        cancellation: of the whole; cancels the sub-goal.

    Raises:
        MoveBaseOver: canceled, by ours or by somebody else, or rejected.
    """
    return checked(goal.wait(cancellation), goal, what, cancellation)


def checked(end: Any, goal: SubGoal, what: str, cancellation: Cancellation) -> GoalEnd:
    """The end of a sub-goal that was waited for, None where a cancel ended the waiting.

    Raises:
        MoveBaseOver: as `ended`.
    """
    if cancellation.canceled:
        end = goal.stop(cancellation.reason)
        message = f"canceled during {what}: {cancellation.reason}"
        if end is None:
            message += f"; {what} has not ended within {PATIENCE:g} s"
        raise MoveBaseOver(GoalEnd(MoveBaseOutcome.CANCELED, message, drive=end and end.drive))
    if end.canceled:
        # Someone wants the robot to stop: going on would be disobedience.
        message = f"{what} was canceled, not by move_base: {end.message}"
        raise MoveBaseOver(GoalEnd(MoveBaseOutcome.CANCELED, message, drive=end.drive))
    if end.state == GoalStatus.REJECTED:
        raise MoveBaseOver(end)
    return end
