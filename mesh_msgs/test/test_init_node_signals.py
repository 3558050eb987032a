"""Signals end the node from another thread than the one they interrupt."""

import signal
import threading

import pytest
import rospy

from mesh_msgs import init_node


def test_shutdown_is_not_run_in_the_interrupted_thread(monkeypatch):
    """It would wait for ever for a lock that the interrupted call to roscore holds."""
    lock, ended = threading.Lock(), threading.Event()

    def signal_shutdown(reason):
        with lock:
            ended.reason = reason
            ended.set()

    monkeypatch.setattr(rospy, "signal_shutdown", signal_shutdown)
    before = signal.signal(signal.SIGUSR1, lambda number, _: init_node._shut_down(number))
    try:
        with lock:
            signal.raise_signal(signal.SIGUSR1)
            assert not ended.is_set()
        assert ended.wait(10)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert ended.reason == f"signal {int(signal.SIGUSR1)}"


def test_what_a_node_that_ends_takes_off_the_master_is_not_missed(monkeypatch):
    killed = []
    monkeypatch.setattr(init_node.os, "kill", lambda *call: killed.append(call))
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    init_node._end_forgotten("the master does not know it")
    assert not killed and not init_node._forgotten.is_set()


@pytest.mark.parametrize("error", [AttributeError("of a closed topic"), rospy.ROSException()])
def test_what_a_shutdown_breaks_is_no_error(monkeypatch, error):
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    with init_node.until_shutdown():
        raise error
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: False)
    with pytest.raises(type(error)), init_node.until_shutdown():
        raise error


def test_the_end_of_the_process_is_not_held_back_by_a_shutdown(monkeypatch):
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    with pytest.raises(SystemExit), init_node.until_shutdown():
        raise SystemExit(1)
