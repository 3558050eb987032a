"""Counting the cycles that come too late, to say so from time to time."""

from typing import Optional

PAUSE = 60.0  # s, from one sentence to the next at least


class LateCycles:
    """Of one drive."""

    def __init__(self) -> None:
        self.count = self.late = 0
        self._slowest = 0.0
        self._said: Optional[float] = None
        self._told = 0

    def note(self, seconds: float, late: bool, now: float) -> str:
        """Count a cycle; returns a sentence if one is due, else empty.

        Args:
            seconds: that the cycle took.
            late: whether it was too late.
            now: time (s) of a clock that only goes on.
        """
        self.count += 1
        self.late += late
        self._slowest = max(self._slowest, seconds)
        if self._said is None:
            self._said = now
        if now - self._said < PAUSE:
            return ""
        self._said = now
        return self.last_words()

    def last_words(self) -> str:
        """The sentence about the cycles since the last one; empty if none was late."""
        if self.late == self._told:
            return ""
        self._told = self.late
        return (
            f"{self.late} of {self.count} control cycles ended late, the longest took "
            f"{1e3 * self._slowest:.0f} ms (if that is less than a cycle, they began late: the "
            "computer has other things to do)"
        )
