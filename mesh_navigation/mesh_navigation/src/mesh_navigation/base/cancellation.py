"""A request to stop that cannot get lost, whenever and from whichever thread it comes."""

import threading
from contextlib import ExitStack, contextmanager
from typing import Callable, Iterator, List, Optional


class Cancellation:
    """One per job: once canceled it stays so; a cancel before the job's first step counts too.

    All methods may be called from any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._event = threading.Event()
        self._callbacks: List[Callable[[], None]] = []
        self._reason = ""

    def cancel(self, reason: str = "canceled") -> bool:
        """Cancel; the first reason stays. Returns whether this call was the first."""
        with self._lock:
            if self._event.is_set():
                return False
            self._reason = reason
            self._event.set()
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback()
        return True

    @property
    def canceled(self) -> bool:
        """Whether a cancel was requested."""
        return self._event.is_set()

    @property
    def reason(self) -> str:
        """Why, as the first to cancel said; empty before."""
        return self._reason

    def wait(self, timeout: Optional[float] = None) -> bool:
        """Sleep up to ``timeout`` seconds; returns True as soon as canceled."""
        return self._event.wait(timeout)

    @contextmanager
    def calling(self, callback: Callable[[], None]) -> Iterator[None]:
        """Within this context a cancel calls ``callback``, at once if it came before.

        The callback runs in the thread that cancels: it must not block.
        """
        with self._lock:
            waiting = not self._event.is_set()
            if waiting:
                self._callbacks.append(callback)
        if not waiting:
            callback()
        try:
            yield
        finally:
            with self._lock:
                if callback in self._callbacks:
                    self._callbacks.remove(callback)


@contextmanager
def any_of(*cancellations: Cancellation) -> Iterator[Cancellation]:
    """Within this context, one that is canceled with the first of these, for its reason."""
    found = Cancellation()
    with ExitStack() as stack:
        for each in cancellations:
            stack.enter_context(each.calling(lambda each=each: found.cancel(each.reason)))
        yield found
