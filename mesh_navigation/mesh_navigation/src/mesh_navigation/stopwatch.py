"""How much time of a clock has passed, also if the clock is set back."""

from mesh_navigation.clock import Clock


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
