"""Time for what waits in cycles: of ROS, or of a simulation; and of the computer."""

import abc
import time
from typing import Optional

from mesh_navigation.base.cancellation import Cancellation


class Clock(abc.ABC):
    """May be used from any thread."""

    @abc.abstractmethod
    def now(self) -> float:
        """The time (s)."""

    @abc.abstractmethod
    def wait_until(self, moment: float, cancellation: Cancellation) -> None:
        """Sleep until then; returns as soon as the cancellation is canceled, or time jumps back."""


class Stopwatch:
    """Counts from its making on. For one thread."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._last = clock.now()
        self._seconds = 0.0

    def seconds(self) -> float:
        """Time that has passed (s); ask at least as often as the clock may be set back."""
        now = self._clock.now()
        self._seconds += max(0.0, now - self._last)
        self._last = now
        return self._seconds


class Deadline:
    """A moment by which something has to be done (wall time)."""

    def __init__(self, seconds: Optional[float]) -> None:
        """``seconds`` from now; None: never."""
        self.seconds = seconds
        self._begin = time.monotonic()

    @property
    def left(self) -> Optional[float]:
        """Seconds until then, 0 when it is over; None: there is no such moment."""
        if self.seconds is None:
            return None
        return max(0.0, self.seconds - (time.monotonic() - self._begin))
