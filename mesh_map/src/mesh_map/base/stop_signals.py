"""Long work that stops when it is told to, and keeps what it has."""

import signal
import threading
import time
from typing import Any, Dict, Optional

from mesh_map.base.cancel import CancelFlag

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_SAME = 0.5  # s: Ctrl+C of a terminal may come twice, also from the process above


class StopSignals:
    """Within it, SIGINT and SIGTERM ask to stop; a second one, half a second later or more, ends
    the work: KeyboardInterrupt, and `cancel` is set. Elsewhere than in the main thread it does
    nothing.

    Attributes:
        number: of the signal that has come; 0 for none.
        cancel: for what takes long in native code.
    """

    def __init__(self) -> None:
        self.number = 0
        self.cancel = CancelFlag()
        self._time: Optional[float] = None
        self._before: Dict[int, Any] = {}

    def __enter__(self) -> "StopSignals":
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self._take) for number in _SIGNALS}
        return self

    def __exit__(self, *_: Any) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def is_stopped(self) -> bool:
        """Whether a signal has come."""
        return self.number != 0

    @property
    def exit_code(self) -> int:
        """128 + signal, as shells have it."""
        return 128 + self.number

    def _take(self, number: int, _frame: Any) -> None:
        now = time.monotonic()
        if self._time is None:
            self.number, self._time = number, now
        elif now - self._time > _SAME:
            self.cancel.set()
            raise KeyboardInterrupt
