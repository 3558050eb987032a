"""A cancel is never lost, whenever it comes."""

import threading

import pytest

from mesh_navigation.base.cancellation import Cancellation, any_of


def test_first_reason_stays():
    cancellation = Cancellation()
    assert not cancellation.canceled and cancellation.reason == ""
    assert cancellation.cancel("one")
    assert not cancellation.cancel("two")
    assert cancellation.canceled and cancellation.reason == "one"


def test_callback_within_the_context_only():
    calls = []
    cancellation = Cancellation()
    with cancellation.calling(lambda: calls.append("early")):
        pass
    with cancellation.calling(lambda: calls.append("inside")):
        cancellation.cancel()
        cancellation.cancel()
    assert calls == ["inside"]


def test_cancel_before_the_context_calls_at_once():
    calls = []
    cancellation = Cancellation()
    cancellation.cancel()
    with cancellation.calling(lambda: calls.append(1)):
        assert calls == [1]
    assert calls == [1]


def test_wait_ends_with_the_cancel():
    cancellation = Cancellation()
    assert not cancellation.wait(0.0)
    threading.Timer(0.02, cancellation.cancel).start()
    assert cancellation.wait(60.0)


def test_race_of_cancel_and_context():
    for _ in range(300):
        cancellation = Cancellation()
        calls = []
        thread = threading.Thread(target=cancellation.cancel)
        thread.start()
        with cancellation.calling(lambda: calls.append(1)):
            cancellation.wait(60.0)
            thread.join()
        assert calls == [1]


@pytest.mark.parametrize("index", [0, 1])
@pytest.mark.parametrize("early", [True, False])
def test_any_of_several(index, early):
    several = Cancellation(), Cancellation()
    if early:
        several[index].cancel("before")
    with any_of(*several) as either:
        assert either.canceled == early
        several[index].cancel("within")
        several[1 - index].cancel("later")
        assert either.reason == ("before" if early else "within")
    with any_of(Cancellation()) as none:
        pass
    assert not none.canceled
