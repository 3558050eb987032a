"""Time for what waits in cycles: of the system, of ROS, or of a simulation."""

import abc
import time

from mesh_navigation.cancellation import Cancellation


class Clock(abc.ABC):
    """May be used from any thread."""

    @abc.abstractmethod
    def now(self) -> float:
        """The time (s)."""

    @abc.abstractmethod
    def wait_until(self, moment: float, cancellation: Cancellation) -> None:
        """Sleep until then; returns as soon as the cancellation is canceled, or time jumps back."""


class SystemClock(Clock):
    """That of the computer, which only goes on."""

    def now(self) -> float:
        return time.monotonic()

    def wait_until(self, moment: float, cancellation: Cancellation) -> None:
        cancellation.wait(max(0.0, moment - time.monotonic()))
