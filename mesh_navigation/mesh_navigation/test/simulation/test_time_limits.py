"""Simulated time waits for those who live by it, but not for ever."""

import threading

import pytest

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.simulation.time_limits import TimeLimits

NEVER = 60.0  # s


class Waiting:
    """Somebody who makes the time go on to 10 s, in a thread."""

    def __init__(self, limits):
        self.cancellation, self.late = Cancellation(), None
        self._limits = limits
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        self.late = self._limits.wait(10.0, self.cancellation)

    def assert_waits(self):
        self._thread.join(0.05)
        assert self.late is None

    def ended(self):
        """Whom it no longer waits for."""
        self._thread.join(NEVER)
        return self.late


@pytest.mark.parametrize("last", [10.0, 0.0])
def test_time_waits_for_the_last(last):
    limits = TimeLimits(patience=NEVER)
    assert Waiting(limits).ended() == []
    limits.tell("fast", 11.0)
    limits.tell("slow", 9.0)
    waiting = Waiting(limits)
    waiting.assert_waits()
    limits.tell("slow", 9.9)
    waiting.assert_waits()
    limits.tell("slow", last)
    assert waiting.ended() == []


def test_who_does_not_keep_up_is_waited_for_once_until_it_is_heard_again():
    limits = TimeLimits(patience=0.1)
    limits.tell("fast", 11.0)
    limits.tell("dead", 9.0)
    assert Waiting(limits).ended() == ["dead"]
    assert Waiting(limits).ended() == []
    limits.tell("dead", 9.5)
    assert Waiting(limits).ended() == ["dead"]


def test_a_cancel_ends_the_waiting():
    limits = TimeLimits(patience=NEVER)
    limits.tell("dead", 9.0)
    waiting = Waiting(limits)
    waiting.assert_waits()
    waiting.cancellation.cancel()
    assert waiting.ended() == []
