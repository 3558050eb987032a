"""Which drives run side by side, and what becomes of them when another one begins."""

import itertools
import threading
from contextlib import contextmanager
from typing import Dict, Iterator, Tuple

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.execution.server_parameters import PREEMPT, REFUSE


class Drives:
    """The drives of all slots. From any thread."""

    def __init__(self, concurrent: str) -> None:
        """``concurrent``: the parameter concurrent_drives."""
        self._concurrent = concurrent
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._running: Dict[int, Tuple[int, Cancellation]] = {}

    @contextmanager
    def running(self, slot: int, cancellation: Cancellation) -> Iterator[None]:
        """Within this context there is a drive.

        Args:
            slot: its slot.
            cancellation: that of its goal.
        Raises:
            NotReady: FAILURE, there is another one.
        """
        with self._lock:
            others = list(self._running.values())
            if others and self._concurrent == REFUSE:
                raise NotReady(
                    "FAILURE",
                    f"the robot is driven by a goal in slot {others[-1][0]}, and "
                    f"concurrent_drives is '{REFUSE}': wait for its end, or cancel it",
                )
            number = next(self._numbers)
            self._running[number] = slot, cancellation
        try:
            if self._concurrent == PREEMPT:
                for _, other in others:
                    other.cancel(
                        f"a newer goal drives in slot {slot}, and concurrent_drives is '{PREEMPT}'"
                    )
            yield
        finally:
            with self._lock:
                del self._running[number]
