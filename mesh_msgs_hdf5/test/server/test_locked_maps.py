"""Maps that another program has open to write when the server wants to read or save them."""
import contextlib
import fcntl
import os
import threading
from unittest.mock import Mock

import genpy
import numpy as np
import pytest
import rospy
from holding import held_open
from mesh_msgs.testing import wait_until
from server_samples import everything

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server import map_opening_ros, map_store_ros, map_topics_ros
from mesh_msgs_hdf5.server.map_opening_ros import MapOpening
from mesh_msgs_hdf5.server.map_progress_ros import MapProgress
from mesh_msgs_hdf5.server.map_registry import MapRegistry
from mesh_msgs_hdf5.server.map_reload_ros import MapReload
from mesh_msgs_hdf5.server.map_store_ros import MapStore
from mesh_msgs_hdf5.server.map_topics_ros import MapServerTopics
from mesh_msgs_hdf5.server.server_options import MapRequest, ServerOptions


class _Heard:
    """In the place of whatever publishes."""

    said = []

    def __init__(self, *_args, **_options):
        pass

    def publish(self, *message):
        self.said += message

    def changed(self, *_map):
        pass

    forget = remove = changed

    def keys(self):
        return []


@pytest.fixture
def logged(monkeypatch):
    """(level, line) of the log; no node is needed."""
    lines = []
    for level in ("loginfo", "logwarn", "logerr"):
        monkeypatch.setattr(
            rospy, level, lambda text, *args, kind=level: lines.append((kind, text % args))
        )
    monkeypatch.setattr(rospy, "Publisher", _Heard)
    monkeypatch.setattr(map_topics_ros, "LatchedTopics", _Heard)
    monkeypatch.setattr(rospy.Time, "now", lambda: genpy.Time(1))
    monkeypatch.setattr(map_opening_ros, "_AGAIN", 0.05)
    monkeypatch.setattr(_Heard, "said", [])
    return lines


@pytest.fixture
def paths(tmp_path):
    for seed in (1, 2):
        MapFile.write(tmp_path / ("%d.h5" % seed), everything(seed))
    return [str(tmp_path / ("%d.h5" % seed)) for seed in (1, 2)]


def opening(maps, paths):
    options = ServerOptions([MapRequest(path) for path in paths])
    return MapOpening(maps, options, MapProgress(), {})


def warnings(logged):
    return [line for kind, line in logged if kind != "loginfo"]


def close(maps):
    for served in maps:
        served.labels.close()


def test_the_only_map_is_waited_for_and_that_is_said_once(paths, logged):
    maps = MapRegistry()
    with held_open(paths[0]):
        waiting = threading.Thread(target=opening(maps, paths[:1]).open_first)
        waiting.start()
        while len(_Heard.said) < 4:  # it has been tried twice, at least
            waiting.join(0.05)
        assert waiting.is_alive() and not len(maps)
    waiting.join()
    assert maps.uuids() == [everything(1).uuid]
    (line,) = warnings(logged)
    assert "another program has it open" in line and "close the program" in line
    told = [message.data for message in _Heard.said]
    assert any("1.h5, but another program has it open" in text for text in told)
    close(maps)


def test_the_other_maps_are_served_meanwhile(paths, logged, monkeypatch):
    maps = MapRegistry()
    opened = opening(maps, paths)
    with held_open(paths[0]):
        opened.open_first()
        assert maps.uuids() == [everything(2).uuid]
        monkeypatch.setattr(opened, "_next", 0.0)
        assert opened.open_waiting() == []
    monkeypatch.setattr(opened, "_next", 0.0)
    (served,) = opened.open_waiting()
    assert served.uuid == everything(1).uuid and len(maps) == 2 and opened.open_waiting() == []
    assert len(warnings(logged)) == 1
    close(maps)


def test_what_is_damaged_is_not_waited_for(paths, logged):
    with open(paths[0], "r+b") as file:
        file.truncate(os.path.getsize(paths[0]) // 2)
    with pytest.raises(MapFileError) as refused:
        opening(MapRegistry(), paths[:1]).open_first()
    assert refused.value.code == "truncated"


def test_what_was_received_is_saved_when_that_program_has_closed_the_file(
    paths, logged, monkeypatch
):
    monkeypatch.setattr(rospy, "Subscriber", lambda *_args, **_options: Mock())
    monkeypatch.setattr(rospy, "Service", lambda *_args: Mock())
    monkeypatch.setattr(map_store_ros, "_TRY_AGAIN", 0.05)
    maps = MapRegistry()
    opening(maps, paths[:1]).open_first()
    (served,) = maps
    costs = np.full(12, 0.25, np.float32)
    with held_open(paths[0]):
        store = MapStore(maps, Mock(), Mock(), Mock(), 0.0, lambda: None)
        served.overlay.change(Edit(vertex_costs={"new": costs}))
        store._expect_more()
        assert wait_until(lambda: store.unsaved)
        assert not served.is_saved
    assert wait_until(lambda: served.is_saved and not store.unsaved)
    assert len(warnings(logged)) == 1 and "has it open" in warnings(logged)[0]
    store.close()
    assert np.array_equal(MapFile(paths[0]).vertex_costs("new"), costs)


@contextlib.contextmanager
def locked(path):
    """By a program that changes nothing any more, so that the file's time stamps stay."""
    with open(path, "rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.mark.parametrize("hold", [held_open, locked])
def test_a_change_is_served_when_that_program_has_closed_the_file(paths, logged, hold):
    maps = MapRegistry()
    opening(maps, paths[:1]).open_first()
    topics, progress = MapServerTopics(_Heard()), MapProgress()
    reload = MapReload(maps, topics, progress, {}, False)
    costs = np.full(12, 0.25, np.float32)
    MapFile(paths[0]).write_layers({"new": (costs, {})})
    with hold(paths[0]):
        for _ in range(4):
            reload.look()
        assert len(warnings(logged)) == 1 and "has it open" in warnings(logged)[0]
        assert not any("failed: " in message.data for message in _Heard.said)
    for _ in range(2):  # nobody writes it between two looks
        reload.look()
    assert any("changed by another program" in line and "new" in line for _, line in logged)
    assert len(warnings(logged)) == 1
    close(maps)
