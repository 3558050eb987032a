"""For whom simulated time waits, and for how long."""

import threading
from typing import Dict, List

from mesh_navigation.base.cancellation import Cancellation

PATIENCE = 5.0  # s of the computer's time, for each


class TimeLimits:
    """How far time may go on, as those who live by it say."""

    def __init__(self, patience: float = PATIENCE) -> None:
        self._patience = patience
        self._changed = threading.Condition()
        self._limits: Dict[str, float] = {}

    def tell(self, name: str, limit: float) -> None:
        """From any thread: somebody lets time go on up to there (s); 0: as far as it likes."""
        with self._changed:
            self._limits[name] = limit or float("inf")
            self._changed.notify_all()

    def wait(self, moment: float, cancellation: Cancellation) -> List[str]:
        """Until all let time go on to this moment (s), or a cancel.

        Returns:
            Who did not for as long as the patience lasts; they count again when they say something.
        """
        with cancellation.calling(self._wake), self._changed:
            self._changed.wait_for(
                lambda: cancellation.canceled or not self._late(moment), self._patience
            )
            late = [] if cancellation.canceled else self._late(moment)
            for name in late:
                del self._limits[name]
            return late

    def _late(self, moment: float) -> List[str]:
        return [name for name, limit in self._limits.items() if limit < moment]

    def _wake(self) -> None:
        with self._changed:
            self._changed.notify_all()
