"""Simulated time that keeps a ratio to the computer's."""


class Pacing:
    """Says how long to sleep. A simulation that fell behind is not rushed to catch up."""

    MAX_DELAY = 0.5  # s that may be caught up

    def __init__(self, factor: float, wall: float) -> None:
        """
        Args:
            factor: simulated s in each s; 0: as many as possible.
            wall: the computer's time (s).
        """
        if not factor >= 0:
            raise ValueError(f"the real time factor is {factor}, but has to be >= 0")
        self._factor = factor
        self._due = wall

    def pause(self, step: float, wall: float) -> float:
        """How long to sleep (s) after a step of the simulation (s) that ended at this time."""
        if self._factor == 0:
            return 0.0
        self._due = max(self._due + step / self._factor, wall - self.MAX_DELAY)
        return max(0.0, self._due - wall)
