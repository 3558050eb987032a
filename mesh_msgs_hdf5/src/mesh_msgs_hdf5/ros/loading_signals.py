"""How signals end a node that is still loading its maps."""
import contextlib
import signal
from typing import Iterator


@contextlib.contextmanager
def ended_by_signals() -> Iterator[None]:
    """Within it SIGINT and SIGTERM end the work at once by a KeyboardInterrupt.

    rospy's own handlers only note the end, which long work does not look at.
    """
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, signal.default_int_handler) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before):
            signal.signal(number, handler)
