"""Warnings that are not said too often."""

import logging
import threading
import types

import pytest
from mesh_map.ros import complaints
from mesh_map.ros.complaints import ThrottledWarnings


@pytest.fixture
def clock(monkeypatch):
    """A list of one number: the time."""
    now = [100.0]
    # not that of the process, in which other threads wait
    monkeypatch.setattr(complaints, "time", types.SimpleNamespace(monotonic=lambda: now[0]))
    return now


def test_one_warning_of_a_kind_in_ten_seconds(clock, caplog):
    said = ThrottledWarnings("obstacles")
    for seconds in range(25):
        clock[0] = 100.0 + seconds
        said.add("clouds cannot be used", "no frame %d\nat all" % seconds)
        if seconds == 3:
            said.add("something else", "why")
    assert [record.getMessage() for record in caplog.records] == [
        "layer obstacles: clouds cannot be used (1): no frame 0 at all",
        "layer obstacles: something else (1): why",
        "layer obstacles: clouds cannot be used (10): no frame 10 at all",
        "layer obstacles: clouds cannot be used (10): no frame 20 at all",
    ]
    assert {record.levelno for record in caplog.records} == {logging.WARNING}


def test_threads_that_complain_at_once(clock, caplog):
    said = ThrottledWarnings("o")

    def complain():
        for _ in range(200):
            said.add("kind", "reason")

    threads = [threading.Thread(target=complain) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    clock[0] += 10.0
    said.add("kind", "reason")
    assert [record.args[2] for record in caplog.records] == [1, 800]
