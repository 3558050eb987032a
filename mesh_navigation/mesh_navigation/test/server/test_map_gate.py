"""Goals wait for the map, or hear why there is none; a map that is loaded anew ends the old one."""

import threading
from types import SimpleNamespace

import pytest

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome, GetPathOutcome, NotReady, RecoveryOutcome
from mesh_navigation.server.map_gate import REPLACED, MapGate


class SlowLoad:
    """Loads when told to; each time another map."""

    def __init__(self, *errors):
        self.errors = list(errors)
        self.begun, self.go = threading.Semaphore(0), threading.Semaphore(0)

    def __call__(self):
        self.begun.release()
        assert self.go.acquire(timeout=60)
        error = self.errors.pop(0) if self.errors else None
        if error:
            raise error
        return SimpleNamespace(map=FakeMap())


class FakeMap:
    """What is wrong with it."""

    lasting_fault = gap = ""

    @property
    def fault(self):
        return self.gap or self.lasting_fault


def failure_of(gate, cancellation=None):
    with pytest.raises(NotReady) as caught:
        gate.wait(cancellation or Cancellation())
    return caught.value.kind, caught.value.message


def later(function, *args):
    threading.Timer(0.03, function, args=args).start()


def started(load, **fields):
    gate = MapGate(load, **fields)
    gate.reload()
    return gate


def test_goal_waits_for_the_map():
    load = SlowLoad()
    gate = started(load)
    later(load.go.release)
    ready = gate.wait(Cancellation())
    assert gate.wait(Cancellation()) is ready and gate.is_current(ready)


def test_a_map_that_is_not_whole():
    load = SlowLoad()
    gate = started(load)
    load.go.release()
    ready = gate.wait(Cancellation())
    assert gate.fault(ready) == ""
    ready.map.lasting_fault = "layer steps: it hangs"
    assert failure_of(gate) == ("MAP_ERROR", "layer steps: it hangs")
    assert gate.fault(ready) == "layer steps: it hangs"
    with pytest.raises(NotReady, match="layer steps: it hangs"):
        gate.now()
    assert gate.wait(Cancellation(), whole=False) is gate.now(whole=False) is ready
    ready.map.lasting_fault = ""
    assert gate.now() is ready


def test_a_map_with_a_gap_is_waited_for():
    load = SlowLoad()
    gate = started(load)
    load.go.release()
    ready = gate.wait_for_data(Cancellation(), 60.0, "patience")
    ready.map.gap = "layer obstacles: no cloud"
    with pytest.raises(NotReady, match="^layer obstacles: no cloud$"):
        gate.now()
    assert gate.wait(Cancellation()) is ready  # it is loaded
    assert gate.fault(ready) == ""  # a drive waits
    with pytest.raises(NotReady, match="layer obstacles: no cloud; waited for 0.1 s .patience."):
        gate.wait_for_data(Cancellation(), 0.1, "patience")
    canceled = Cancellation()
    later(canceled.cancel, "enough")
    with pytest.raises(NotReady, match="stopped while waiting: layer obstacles: no cloud; enough"):
        gate.wait_for_data(canceled, 0.0, "patience")
    later(setattr, ready.map, "gap", "")
    assert gate.wait_for_data(Cancellation(), 0.0, "patience") is ready
    ready.map.gap = "layer obstacles: no cloud"
    later(setattr, ready.map, "lasting_fault", "layer steps: it hangs")
    with pytest.raises(NotReady, match="^layer steps: it hangs"):
        gate.wait_for_data(Cancellation(), 0.0, "patience")


def test_goal_that_must_not_wait():
    load = SlowLoad()
    gate = started(load, wait=False)
    kind, message = failure_of(gate)
    assert kind == "NOT_INITIALIZED"
    assert "still being loaded, for 0 s" in message and "wait_for_map" in message
    later(load.go.release)
    ready = gate.wait(Cancellation(), patient=True)
    assert gate.wait(Cancellation()) is ready


def test_map_that_cannot_be_loaded():
    load = SlowLoad(ValueError("garden.h5: no such file"))
    gate = started(load)
    later(load.go.release)
    assert failure_of(gate) == ("MAP_ERROR", "there is no map: garden.h5: no such file")


def test_goal_that_comes_before_the_start():
    load = SlowLoad()
    gate, hasty = MapGate(load), MapGate(load, wait=False)
    assert failure_of(hasty)[0] == "NOT_INITIALIZED"
    load.go.release()
    later(gate.reload)
    assert gate.is_current(gate.wait(Cancellation()))


def test_cancel_while_waiting():
    load, cancellation = SlowLoad(), Cancellation()
    gate = started(load)
    later(cancellation.cancel, "for a test")
    kind, message = failure_of(gate, cancellation)
    load.go.release()
    assert (kind, message) == ("CANCELED", "stopped while waiting for the map: for a test")


def test_kinds_are_names_of_outcomes():
    for outcomes in (GetPathOutcome, ExePathOutcome):
        assert {"CANCELED", "NOT_INITIALIZED", "MAP_ERROR"} <= set(outcomes.__members__)
    assert {"CANCELED", "NOT_INITIALIZED"} <= set(RecoveryOutcome.__members__)


def test_reload():
    load = SlowLoad()
    gate = started(load)
    load.go.release()
    first = gate.wait(Cancellation())
    replaced = gate.replaced(first)
    assert not replaced.canceled
    gate.reload()
    assert replaced.canceled and replaced.reason == REPLACED
    assert not gate.is_current(first) and gate.replaced(first).canceled
    later(load.go.release)
    second = gate.wait(Cancellation())
    assert second is not first and gate.is_current(second) and not gate.is_current(first)
    assert not gate.replaced(second).canceled and gate.replaced(first).canceled


def test_reload_while_loading_counts_the_last_one_alone():
    load = SlowLoad(ValueError("old file"))
    gate = started(load)
    assert load.begun.acquire(timeout=60)
    for _ in range(3):
        gate.reload()
    load.go.release()
    assert load.begun.acquire(timeout=60)  # once more, for all three
    later(load.go.release)
    gate.wait(Cancellation())
    assert not load.begun.acquire(blocking=False)


def test_reload_that_fails_and_one_that_repairs():
    load = SlowLoad(None, ValueError("gone"))
    gate = started(load)
    load.go.release()
    gate.wait(Cancellation())
    gate.reload()
    load.go.release()
    assert failure_of(gate) == ("MAP_ERROR", "there is no map: gone")
    gate.reload()
    load.go.release()
    assert gate.is_current(gate.wait(Cancellation()))


def test_the_map_of_now_is_never_waited_for():
    load = SlowLoad(None, ValueError("gone"))
    gate = started(load)
    with pytest.raises(NotReady, match=r"still being loaded, for \d+ s now$") as caught:
        gate.now()
    assert caught.value.kind == "NOT_INITIALIZED"
    load.go.release()
    assert gate.wait(Cancellation()) is gate.now()
    gate.reload()
    with pytest.raises(NotReady, match="still being loaded"):
        gate.now()
    load.go.release()
    assert failure_of(gate) == ("MAP_ERROR", "there is no map: gone")
    with pytest.raises(NotReady, match="there is no map: gone"):
        gate.now()


def test_a_plugin_that_exits_ends_the_loading_only():
    load = SlowLoad(SystemExit("enough"))
    gate = started(load)
    load.go.release()
    cancellation = Cancellation()
    threading.Timer(10.0, cancellation.cancel).start()
    assert failure_of(gate, cancellation) == ("MAP_ERROR", "there is no map: enough")
