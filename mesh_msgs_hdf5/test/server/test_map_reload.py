"""A file that is replaced while the server starts, which takes its time on a busy machine."""
import threading

import genpy
import numpy as np
import pytest
import rospy
from server_samples import everything

from mesh_msgs_hdf5.files.save import stamp
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.server import map_topics_ros
from mesh_msgs_hdf5.server.map_loading import load
from mesh_msgs_hdf5.server.map_progress_ros import MapProgress
from mesh_msgs_hdf5.server.map_registry import MapRegistry
from mesh_msgs_hdf5.server.map_reload_ros import MapReload
from mesh_msgs_hdf5.server.map_topics_ros import MapServerTopics
from mesh_msgs_hdf5.server.server_options import MapRequest


class _Heard:
    """In the place of whatever publishes."""

    def __init__(self, *_args, **_options):
        self.published = []

    def publish(self, *message):
        self.published.append(message)

    def changed(self, *_map):
        pass

    forget = remove = changed

    def keys(self):
        return []


@pytest.fixture
def logged(monkeypatch):
    """Lines of errors; no node is needed."""
    lines = []
    monkeypatch.setattr(rospy, "logerr", lambda text, *args: lines.append(text % args))
    monkeypatch.setattr(rospy, "Publisher", _Heard)
    monkeypatch.setattr(map_topics_ros, "LatchedTopics", _Heard)
    monkeypatch.setattr(rospy.Time, "now", lambda: genpy.Time(1))
    return lines


@pytest.fixture
def served(tmp_path, logged):
    """A map that has been loaded from a.h5."""
    path = tmp_path / "a.h5"
    MapFile.write(path, everything(1))
    (found,), _ = load(MapRequest(str(path)), genpy.Time(1), {}, False)
    yield found
    found.labels.close()


def test_it_is_told_and_loaded_anew(served, tmp_path, logged):
    path, maps = tmp_path / "a.h5", MapRegistry()
    maps.add(served)
    MapFile.write(path, everything(2))
    topics, progress = MapServerTopics(_Heard()), MapProgress()
    topics.publish_map(served)
    progress.serves(served)
    progress.ready(maps)
    assert len(logged) == 1 and "another program has replaced the mesh" in logged[0]
    assert progress.describe() == ["serving %s" % path]

    reload = MapReload(maps, topics, progress, {}, False)
    assert maps.uuids() == [everything(1).uuid]
    for _ in range(2):  # Nobody writes it between two looks.
        reload.look()
    assert maps.uuids() == [everything(2).uuid]
    (text,) = progress.describe()
    assert everything(2).uuid in text and "serving" in text
    for loaded in maps:
        loaded.labels.close()


def test_what_the_server_saves_is_no_change_of_others(served, tmp_path, logged):
    """However long it takes from the new file to the end of saving."""
    path, maps = tmp_path / "a.h5", MapRegistry()
    maps.add(served)
    published = _Heard()
    published.publish_map = published.publish
    reload = MapReload(maps, published, MapProgress(), {}, False)
    looked = threading.Semaphore(0)

    def look():
        for _ in range(4):
            looked.release()
            reload.look()

    looks = threading.Thread(target=look)
    with served._saving:
        MapFile(path).write_layers({"mine": (np.ones(12, np.float32), None)})
        looks.start()
        for _ in range(2):  # The second one sees that the file is another one.
            looked.acquire()
        looks.join(0.5)
        assert looks.is_alive()
        served.saved_stamp = stamp(path)
    looks.join(60)
    assert not looks.is_alive() and not published.published
    MapFile(path).write_layers({"theirs": (np.ones(12, np.float32), None)})
    for _ in range(2):
        reload.look()
    assert len(published.published) == 1 and list(maps) == [served] and not logged


def test_costs_that_nobody_has_said_the_meaning_of_publish_no_other_meanings(served):
    topics = MapServerTopics(_Heard())
    topics.publish_map(served)
    info = topics._topics["layer_info"].published
    costs = np.ones(len(everything(1).vertices), np.float32)
    removed = []
    topics._topics["layer_info"].remove = removed.append
    for _ in range(3):
        served.overlay.change(Edit(vertex_costs={"height_diff": costs}))
        topics.publish_change(served, "vertex_costs", "height_diff")
    assert len(topics._topics["vertex_costs"].published) >= 3
    assert not info and not removed


def test_a_file_that_is_gone_takes_nothing_from_subscribers(served, tmp_path, logged):
    topics = MapServerTopics(_Heard())
    topics.publish_map(served)
    forgotten = []
    topics.forget_map = forgotten.append
    (tmp_path / "a.h5").rename(tmp_path / "away.h5")
    topics.publish_map(served)
    assert not forgotten and "no such file" in logged[-1]


def test_one_that_stays_is_not_loaded_anew(served, logged):
    maps = MapRegistry()
    maps.add(served)
    topics = MapServerTopics(_Heard())
    reload = MapReload(maps, topics, MapProgress(), {}, False)
    for _ in range(3):
        reload.look()
    assert list(maps) == [served] and not logged
