"""Goals that a server does not get at first."""

import pytest

from mesh_navigation.client import action_caller_ros
from mesh_navigation.client.action_caller_ros import AGAIN, UNKNOWN, ActionCall


class FakeCaller:
    """Notes what is sent."""

    name = "/fake"
    heard = 0.0

    def __init__(self):
        self.sent = []

    def publish_goal(self, key, goal):
        self.sent.append((key, goal))


@pytest.fixture
def clock(monkeypatch):
    """A time that tests set; statuses come every 0.2 s."""
    now = [100.0]
    monkeypatch.setattr(action_caller_ros.time, "monotonic", lambda: now[0])

    def statuses(call, seconds, known):
        for _ in range(round(seconds / 0.2)):
            now[0] += 0.2
            call.on_status(known)

    return statuses


def sent_call():
    call = ActionCall(FakeCaller(), "key", None)
    call.send("goal")
    return call


def test_a_goal_that_is_not_known_is_sent_again_until_it_is(clock):
    call = sent_call()
    clock(call, AGAIN - 0.2, ["another"])
    assert len(call.caller.sent) == 1
    clock(call, 2.0 * AGAIN, ["another"])
    count = len(call.caller.sent)
    assert count > 1 and set(call.caller.sent) == {("key", "goal")}
    clock(call, 0.2, ["key"])
    clock(call, UNKNOWN - 1.0, [])  # it has ended, or the server was started anew
    assert len(call.caller.sent) == count


def test_a_goal_that_the_server_has_is_sent_once(clock):
    call = sent_call()
    clock(call, 0.6, [])
    clock(call, 20.0, ["key"])
    assert len(call.caller.sent) == 1


def test_nothing_is_sent_after_the_end(clock):
    call = sent_call()
    call.on_result(3, "result")
    clock(call, 5.0, [])
    assert len(call.caller.sent) == 1
