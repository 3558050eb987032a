"""A file that is replaced while the server starts, which takes its time on a busy machine."""
import genpy
import pytest
import rospy
from server_samples import everything

from mesh_msgs_hdf5.map_file import MapFile
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


def test_it_is_told_and_loaded_anew(tmp_path, logged):
    path = tmp_path / "a.h5"
    MapFile.write(path, everything(1))
    maps = MapRegistry()
    (served,), _ = load(MapRequest(str(path)), genpy.Time(1), {}, False)
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
    for served in maps:
        served.labels.close()


def test_one_that_stays_is_not_loaded_anew(tmp_path, logged):
    path = tmp_path / "a.h5"
    MapFile.write(path, everything(1))
    maps = MapRegistry()
    (served,), _ = load(MapRequest(str(path)), genpy.Time(1), {}, False)
    maps.add(served)
    topics = MapServerTopics(_Heard())
    reload = MapReload(maps, topics, MapProgress(), {}, False)
    for _ in range(3):
        reload.look()
    assert list(maps) == [served] and not logged
    served.labels.close()
