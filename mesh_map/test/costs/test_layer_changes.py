"""Differences of results, and those who are told of them."""

import math
import threading
import time

import numpy as np
from mesh_map.costs import layer_changes
from mesh_map.costs.layer import checked
from mesh_map.costs.layer_changes import LayerChange, Listeners, ResultDifference, different, union

NAN = math.nan


def test_nan_is_like_nan_whatever_its_bits():
    other_nan = np.array([0x7FC00001, 0xFFC00000], np.uint32).view(np.float32)
    one = np.array([NAN, NAN, 0, 1, np.inf, 5], np.float32)
    other = np.array([0, 0, NAN, 1, np.inf, 5.0000005], np.float32)
    other[:2] = other_nan
    assert different(one, other).tolist() == [2, 5]
    assert different(one, one).tolist() == different(one, one.copy()).tolist() == []
    zeros = np.zeros(2, np.float32)
    assert different(zeros, -zeros).tolist() == [0, 1]  # bitwise


def test_vectors_that_come_and_go():
    vectors = np.zeros((3, 3), np.float32)
    vectors[1, 2] = 1
    assert different(None, vectors).tolist() == [1]
    assert different(vectors, None).tolist() == [1]
    assert different(None, None).tolist() == []
    for column in range(3):
        moved = vectors.copy()
        moved[2, column] = 1
        assert different(vectors, moved).tolist() == [2]


def test_unions():
    parts = [np.array([7, 90], np.uint32), np.zeros(0, np.int64), np.array([3, 7, 50])]
    for count in (91, 100000):  # many and few of them
        for chosen in (parts, parts[:1], parts[:2], parts[1:2], []):
            found = union(chosen, count)
            assert found.dtype == np.uint32
            assert found.tolist() == sorted(set(np.concatenate([np.zeros(0), *chosen])))


def test_readers_see_more_than_what_is_shown():
    before = checked(([0, 1, 2, 3], [0], np.zeros((4, 3))), 4)
    vectors = np.zeros((4, 3))
    vectors[3] = 1
    after = checked(([0, 5, 2, 3], [2], vectors), 4)
    difference = ResultDifference.between(before, after)
    assert difference.read.tolist() == [0, 1, 2, 3] and difference.shown.tolist() == [1, 3]
    assert difference.read.dtype == difference.shown.dtype == np.uint32
    new = ResultDifference.between(None, after)
    assert new.read.tolist() == new.shown.tolist() == [0, 1, 2, 3]
    assert [len(part) for part in ResultDifference.between(after, after)] == [0, 0]


def change(number):
    return [LayerChange(str(number), np.zeros(1, np.uint32), np.zeros(1, np.float32))]


def test_each_is_told_once_and_in_order(caplog, monkeypatch):
    monkeypatch.setattr(layer_changes, "_PATIENCE", 20)
    listeners, heard, start = Listeners(), [], time.monotonic()

    def fails(changes):
        raise KeyError("deaf")

    def spoils(changes):
        changes.clear()

    def listen(changes):
        heard.append(changes[0].name)
        if changes[0].name == "1":  # a change by a listener is told after this one
            listeners.put(change(3))
            listeners.tell()
            heard.append("end of 1")

    for listener in (fails, spoils, listen):
        listeners.add(listener)
    listeners.put(change(1))
    listeners.put([])
    listeners.put(change(2))
    listeners.tell()
    assert heard == ["1", "end of 1", "2", "3"]
    assert time.monotonic() - start < 20  # it has not waited for itself
    assert caplog.messages == ["a listener failed with KeyError: 'deaf'"] * 3
    listeners.remove(listen)
    listeners.put(change(4))
    listeners.tell()
    assert len(heard) == 4


def test_no_change_is_lost_between_threads():
    listeners, heard, lock = Listeners(), [], threading.Lock()
    listeners.add(lambda changes: heard.append(int(changes[0].name)))
    numbers = iter(range(4000))

    def work():
        for _ in range(1000):
            with lock:
                listeners.put(change(next(numbers)))
            listeners.tell()

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert heard == list(range(4000))


def test_a_change_at_the_last_moment_is_told_too(monkeypatch):
    """One that comes when the other thread has seen that none is left, and is not done yet."""
    monkeypatch.setattr(layer_changes, "_PATIENCE", 0.01)
    listeners, heard = Listeners(), []
    listeners.add(lambda changes: heard.append(changes[0].name))
    lock = threading.Lock()

    class LateLock:
        acquire = lock.acquire

        def release(self):
            if len(heard) == 1:
                listeners.put(change(2))
                listeners.tell()  # as another thread: it cannot, and leaves it to this one
            lock.release()

    listeners._telling = LateLock()
    listeners.put(change(1))
    listeners.tell()
    assert heard == ["1", "2"]


def tells(listeners, number):
    """A thread that has made a change, and tells of it."""
    listeners.put(change(number))
    thread = threading.Thread(target=listeners.tell)
    thread.start()
    return thread


def test_who_changes_waits_for_slow_listeners():
    """Else changes, each with costs of all vertices, would pile up."""
    listeners, heard, go_on = Listeners(), [], threading.Event()
    listeners.add(lambda changes: (heard.append(changes[0].name), go_on.wait(20)))
    first = tells(listeners, 1)
    while not heard:
        first.join(0.01)
    second = tells(listeners, 2)
    second.join(0.2)
    assert second.is_alive()
    go_on.set()
    for thread in (first, second):
        thread.join(20)
        assert not thread.is_alive()
    assert heard == ["1", "2"]


def test_a_listener_that_waits_for_another_change_is_no_deadlock(monkeypatch):
    monkeypatch.setattr(layer_changes, "_PATIENCE", 0.05)
    listeners, heard = Listeners(), []

    def listen(changes):
        heard.append(changes[0].name)
        if changes[0].name == "1":
            other = tells(listeners, 2)
            other.join(20)
            assert not other.is_alive()

    listeners.add(listen)
    tells(listeners, 1).join(20)
    assert heard == ["1", "2"]
