"""What tests wait for, without ROS (on a running one: testing_ros)."""

import socket
import time
from typing import Any, Callable, Optional


def wait_until(
    condition: Callable[[], Any], what: Optional[str] = None, seconds: float = 60.0
) -> Any:
    """What the condition gives, as soon as it is true.

    Args:
        condition: asked every 10 ms, once more when the time is over.
        what: is waited for, for an error when the time is over; None to return the last value.
        seconds: far more than it takes.
    Raises:
        AssertionError: it has not become true; not without `what`.
    """
    end = time.monotonic() + seconds
    while True:
        is_over = time.monotonic() > end
        value = condition()
        if value or (is_over and what is None):
            return value
        if is_over:
            raise AssertionError("%s not within %g s" % (what, seconds))
        time.sleep(0.01)


def listens(port: int) -> bool:
    """Whether a server listens at this port of this machine (127.0.0.1), such as a roscore."""
    try:
        with socket.create_connection(("127.0.0.1", port)):
            return True
    except OSError:
        return False


def process_has_ended(pid: int) -> bool:
    """Whether there is no such process; one that nobody has waited for is none."""
    try:
        with open("/proc/%d/stat" % pid, encoding="ascii", errors="replace") as stat:
            return stat.read().rsplit(") ", 1)[1][0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


def expect_a_busy_machine() -> None:
    """Tests with hypothesis that follow do not fail for the time that they take, and may share
    fixtures between their examples."""
    from hypothesis import HealthCheck, settings

    busy = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
    settings.register_profile("busy", deadline=None, suppress_health_check=busy)
    settings.load_profile("busy")
