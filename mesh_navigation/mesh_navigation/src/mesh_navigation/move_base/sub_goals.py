"""The goals that going to a goal consists of: plans, drives, recovery behaviors. No ROS in here."""

import abc
import enum
from typing import Any, Callable, NamedTuple, Optional

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import is_success
from mesh_navigation.base.pose import Pose


class SubState(enum.Enum):
    """How an action server answered."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    REJECTED = "rejected"
    CANCELED = "canceled"
    REPLACED = "replaced"
    """Canceled in favor of a newer goal of the same slot."""


class SubEnd(NamedTuple):
    """What came of a sub-goal."""

    state: SubState
    outcome: int
    """A value of the outcomes of its action."""
    message: str
    path: Any = None
    """Of a plan that succeeded."""
    drive: Any = None
    """Of a drive: where it ended."""

    @property
    def succeeded(self) -> bool:
        """Whether it did what was wanted."""
        return self.state is SubState.SUCCEEDED and is_success(self.outcome)


class Progress(NamedTuple):
    """The robot, as a drive reports it in each cycle."""

    pose: Pose
    dist_to_goal: float
    """m."""
    outcome: int
    """Of this cycle: a value of `ExePathOutcome`."""


class SubGoal(abc.ABC):
    """One goal that was sent."""

    @abc.abstractmethod
    def cancel(self, reason: str) -> None:
        """Ask for its end; returns at once."""

    @abc.abstractmethod
    def wait(self, cancellation: Cancellation, timeout: Optional[float]) -> Optional[SubEnd]:
        """Its end; None if there is none within ``timeout`` (s, of the computer's clock; None: no
        limit), or as soon as ``cancellation``, which is not the goal's, is canceled."""


class SubActions(abc.ABC):
    """Sends sub-goals. Every method returns at once."""

    @abc.abstractmethod
    def plan(self) -> SubGoal:
        """A plan from where the robot is to the goal."""

    @abc.abstractmethod
    def drive(self, path: Any, on_progress: Callable[[Progress], None]) -> SubGoal:
        """Follow a path; what is followed already goes on with the new path without a stop.

        Args:
            path: of a plan that succeeded.
            on_progress: called in each cycle, from another thread.
        """

    @abc.abstractmethod
    def recover(self, behavior: str) -> SubGoal:
        """Run one recovery behavior."""
