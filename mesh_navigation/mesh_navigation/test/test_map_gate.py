"""Goals wait for the map, or hear why there is none."""

import threading

import pytest

from mesh_navigation.cancellation import Cancellation
from mesh_navigation.map_gate import MapGate
from mesh_navigation.outcomes import GetPathOutcome
from mesh_navigation.planner import PlanFailure

MAP = object()


class SlowLoad:
    """Loads when told to."""

    def __init__(self, error=None):
        self.go, self.error = threading.Event(), error

    def __call__(self):
        self.go.wait(60)
        if self.error:
            raise self.error
        return MAP


def failure_of(gate, cancellation=None):
    with pytest.raises(PlanFailure) as caught:
        gate.wait_for_map(cancellation or Cancellation())
    return caught.value


def test_goal_waits_for_the_map():
    load = SlowLoad()
    gate = MapGate(load)
    gate.start()
    threading.Timer(0.05, load.go.set).start()
    assert gate.wait_for_map(Cancellation()) is MAP
    assert gate.wait_for_map(Cancellation()) is MAP


def test_goal_that_must_not_wait():
    load = SlowLoad()
    gate = MapGate(load, wait=False)
    gate.start()
    failure = failure_of(gate)
    load.go.set()
    assert failure.outcome == GetPathOutcome.NOT_INITIALIZED
    assert "still being loaded, for 0 s" in failure.message and "wait_for_map" in failure.message


def test_map_that_cannot_be_loaded():
    load = SlowLoad(ValueError("garden.h5: no such file"))
    gate = MapGate(load)
    gate.start()
    threading.Timer(0.02, load.go.set).start()
    failure = failure_of(gate)
    assert failure.outcome == GetPathOutcome.MAP_ERROR
    assert failure.message == "there is no map: garden.h5: no such file"


def test_cancel_while_waiting():
    load, cancellation = SlowLoad(), Cancellation()
    gate = MapGate(load)
    gate.start()
    threading.Timer(0.02, cancellation.cancel, args=("for a test",)).start()
    failure = failure_of(gate, cancellation)
    load.go.set()
    assert failure.outcome == GetPathOutcome.CANCELED
    assert failure.message == "planning stopped: for a test"
