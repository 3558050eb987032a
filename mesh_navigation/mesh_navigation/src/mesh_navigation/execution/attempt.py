"""What a plugin does for a goal: in a thread of its own, and checked before anyone relies on it."""

import threading
from typing import Any, Callable, List

import numpy as np

from mesh_navigation.base.cancellation import Cancellation

# How long a plugin may take to stop once told to, before the answer goes out without it (s).
GRACE = 0.5


class Attempt:
    """Work in a thread of its own, which may never end: nobody has to wait for it."""

    def __init__(self, name: str, work: Callable[[Cancellation], Any]) -> None:
        """
        Args:
            name: of the thread.
            work: raises nothing; it stops when the `Cancellation` it gets says so.
        """
        self.cancellation = Cancellation()
        self.wake = threading.Event()
        """Set when it has ended; others may set it to have it looked at."""
        self.results: List[Any] = []
        """What the work has returned; empty as long as it has not."""
        self._name, self._work = name, work
        self._done = threading.Event()

    def start(self) -> None:
        """Begin."""
        threading.Thread(target=self._run, name=self._name, daemon=True).start()

    def _run(self) -> None:
        self.results.append(self._work(self.cancellation))
        self._done.set()
        self.wake.set()

    def stop(self, reason: str, who: str) -> str:
        """Tell it to stop; if it does not in time, the end of a sentence about who is late."""
        self.cancellation.cancel(reason)
        return "" if self._done.wait(GRACE) else f"; the {who} did not stop within {GRACE} s"


def fault_of_answer(returned: Any, expected: type) -> str:
    """What makes that no answer of a plugin, empty if nothing does.

    Args:
        returned: what the plugin did.
        expected: a class with an outcome.
    """
    if not isinstance(returned, expected):
        return f"it returned a {type(returned).__name__} instead of a {expected.__name__}"
    outcome = returned.outcome  # type: ignore[attr-defined]
    if not isinstance(outcome, (int, np.integer)) or not 0 <= outcome < 256:
        return f"its outcome is {outcome!r}, not a number from 0 to 255"
    return ""
