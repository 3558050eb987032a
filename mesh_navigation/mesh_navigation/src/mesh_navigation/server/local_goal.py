"""Goals that a server sends to itself: what came of one, for who waits for it."""

import threading
from typing import Any, Callable, Optional, Tuple

from mesh_navigation.base.cancellation import Cancellation

Feedback = Callable[[Any], None]


class LocalGoal:
    """One goal, from the side of who sent it. All methods may be called from any thread."""

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
        self._answer: Optional[Tuple[int, Any]] = None

    def cancel(self, reason: str) -> None:
        """Ask for its end; the answer comes as always."""
        self._cancel(reason)

    def finish(self, state: int, result: Any) -> None:
        """The answer: a state of actionlib_msgs/GoalStatus and the result."""
        with self._changed:
            self._answer = state, result
            self._changed.notify_all()

    def wait(
        self, cancellation: Optional[Cancellation] = None, timeout: Optional[float] = None
    ) -> Optional[Tuple[int, Any]]:
        """Wait for the answer: the goal's last state and its result.

        Args:
            cancellation: ends the waiting, not the goal.
            timeout: longest time (s, of the system's clock); None: no limit.

        Returns:
            None if there is no answer yet.
        """
        cancellation = cancellation or Cancellation()
        with cancellation.calling(self._notify), self._changed:
            self._changed.wait_for(
                lambda: self._answer is not None or cancellation.canceled, timeout
            )
            return self._answer

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()
