"""Drives that take over from each other, seen as one."""

from typing import Any, Callable, List, Optional

from mesh_navigation.cancellation import Cancellation
from mesh_navigation.move_base_end import stopped
from mesh_navigation.sub_goals import Progress, SubActions, SubEnd, SubGoal, SubState


class Relay(SubGoal):
    """A drive along a path, and along newer ones, each of which is a goal of its own.

    What ends is the newest. But somebody who cancels the drive just when the next one is sent means
    the robot: then the newest is canceled as well.
    """

    def __init__(
        self, actions: SubActions, path: Any, on_progress: Callable[[Progress], None]
    ) -> None:
        """
        Args:
            actions: sends the goals.
            path: the first one.
            on_progress: as in `SubActions.drive`.
        """
        self._actions = actions
        self._on_progress = on_progress
        self._older: List[SubGoal] = []
        self._newest = actions.drive(path, on_progress)

    def follow(self, path: Any) -> None:
        """Go on along a newer path."""
        self._older.append(self._newest)
        self._newest = self._actions.drive(path, self._on_progress)

    def cancel(self, reason: str) -> None:
        self._newest.cancel(reason)

    def wait(self, cancellation: Cancellation, timeout: Optional[float]) -> Optional[SubEnd]:
        end = self._newest.wait(cancellation, timeout)
        if end is not None and end.succeeded:
            return end
        canceled = self._canceled_before()
        if canceled is None:
            return end
        end = stopped(self._newest, canceled.message)
        return canceled._replace(drive=end.drive if end else None)

    def _canceled_before(self) -> Optional[SubEnd]:
        ended = [(goal, goal.wait(Cancellation(), 0.0)) for goal in self._older]
        self._older = [goal for goal, end in ended if end is None]
        ends = [end for _, end in ended if end is not None and end.state is SubState.CANCELED]
        return ends[0] if ends else None
