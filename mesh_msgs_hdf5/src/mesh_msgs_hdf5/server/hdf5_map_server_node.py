"""Node hdf5_map_server: serves meshes with all that is known of them, and stores what it gets.

The map file may be its first argument: rosrun mesh_msgs_hdf5 hdf5_map_server FILE.
"""
import contextlib
import sys
from typing import Callable, Iterator

import rospy

from mesh_msgs.diagnostics_ros import Diagnostics, Status
from mesh_msgs.text import one_line
from mesh_msgs_hdf5.ros.label_forwarding_ros import SAVE_SERVICE, LabelForwarder, owner_info
from mesh_msgs_hdf5.ros.label_services_ros import Found, LabelServices
from mesh_msgs_hdf5.ros.loading_signals import ended_by_signals
from mesh_msgs_hdf5.ros.run_node_ros import run_node
from mesh_msgs_hdf5.server.map_opening_ros import MapOpening
from mesh_msgs_hdf5.server.map_progress_ros import MapProgress
from mesh_msgs_hdf5.server.map_registry import MapRegistry, UnknownMap
from mesh_msgs_hdf5.server.map_reload_ros import MapReload
from mesh_msgs_hdf5.server.map_services_ros import MapServerServices
from mesh_msgs_hdf5.server.map_store_ros import MapStore
from mesh_msgs_hdf5.server.map_topics_ros import MapServerTopics
from mesh_msgs_hdf5.server.origin_frame_ros import OriginFrames
from mesh_msgs_hdf5.server.served_map import STORES_ALL
from mesh_msgs_hdf5.server.server_options import ServerOptions, parse


class MapServer:
    """The maps with their topics and services."""

    def __init__(
        self, maps: MapRegistry, options: ServerOptions, progress: MapProgress, opening: MapOpening
    ) -> None:
        """opening: has opened the maps; others may come later."""
        self._opening, self._progress = opening, progress
        forwarder = LabelForwarder()
        self._services = MapServerServices(maps)
        labels = LabelServices("", _labels_of(maps), forwarder, UnknownMap)
        self._topics = MapServerTopics(labels, OriginFrames(options.origin_frame))
        for served in maps:
            self._topics.publish_map(served)
            progress.serves(served)
            progress.say_notes(served)
        progress.ready(maps)
        self._reload = MapReload(maps, self._topics, progress, _owner_info(), options.read_only)
        self._store = MapStore(
            maps, self._topics, labels, forwarder, options.save_delay, self._look
        )
        self._diagnostics = Diagnostics("maps", self._status)

    def _status(self) -> Status:
        return self._progress.status(self._store.unsaved, self._store.results.last_refusal)

    def _look(self) -> None:
        for served in self._opening.open_waiting():
            self._reload.watch(served)
            self._topics.publish_map(served)
            self._progress.serves(served)
            rospy.loginfo("%s", one_line(served.describe()))
        self._reload.look()

    def close(self) -> bool:
        """Save what was received; False if something is lost."""
        self._diagnostics.shutdown()
        return self._store.close()


def _labels_of(maps: MapRegistry) -> Callable[[str], Found]:
    def find(uuid: str) -> Found:
        served = maps.find(uuid)
        return served.uuid, served.labels

    return find


def _owner_info():
    return {
        **owner_info("cluster_label", "delete_label", "set_label_color"),
        SAVE_SERVICE: rospy.resolve_name("save_map"),
        STORES_ALL: True,
    }


@contextlib.contextmanager
def _running() -> Iterator[None]:
    options = parse(rospy.get_param("~", {}), rospy.myargv(sys.argv)[1:])
    progress = MapProgress()
    with ended_by_signals():
        maps = MapRegistry()
        opening = MapOpening(maps, options, progress, _owner_info())
        opening.open_first()
    server = MapServer(maps, options, progress, opening)
    try:
        for text in progress.describe():
            rospy.loginfo("%s", text)
        yield
    finally:
        if not server.close():
            raise SystemExit(1)


def main(name: str = "hdf5_map_server") -> int:
    """Run the node; returns the exit code."""
    return run_node(name, _running, __doc__)
