"""Node hdf5_map_server: serves meshes with all that is known of them, and stores what it gets."""
import sys
from typing import Optional

import rospy
from mesh_msgs.init_node import init_node

from mesh_msgs_hdf5.errors import MapFileError, one_line
from mesh_msgs_hdf5.labels.label_forwarding_ros import LabelForwarder, owner_info
from mesh_msgs_hdf5.server.loading_signals import ended_by_signals
from mesh_msgs_hdf5.server.map_loading import load
from mesh_msgs_hdf5.server.map_registry import MapRegistry
from mesh_msgs_hdf5.server.map_reload_ros import MapReload
from mesh_msgs_hdf5.server.map_services_ros import MapServices
from mesh_msgs_hdf5.server.map_store_ros import MapStore
from mesh_msgs_hdf5.server.map_topics_ros import MapTopics
from mesh_msgs_hdf5.server.served_map import STORES_ALL
from mesh_msgs_hdf5.server.server_options import ServerOptions, parse


class MapServer:
    """The maps with their topics and services."""

    def __init__(self, maps: MapRegistry, options: ServerOptions) -> None:
        forwarder = LabelForwarder()
        self._topics = MapTopics()
        self._services = MapServices(maps, forwarder)
        for served in maps:
            self._topics.publish_map(served)
        self._reload = MapReload(maps, self._topics, _owner_info(), options.read_only)
        self._store = MapStore(maps, self._topics, forwarder, options.save_delay, self._reload.look)

    def close(self) -> None:
        """Save what was received."""
        self._store.close()


def load_maps(options: ServerOptions) -> MapRegistry:
    """All maps that can be read; each other one is a log line.

    Raises MapFileError if there is none: that of the first.
    """
    maps = MapRegistry()
    info = _owner_info()
    first: Optional[MapFileError] = None
    for request in options.maps:
        try:
            found, notes = load(request, rospy.Time.now(), info, options.read_only)
        except MapFileError as error:
            first = first or error
            if len(options.maps) > 1:
                rospy.logerr("not served: %s", error)
            continue
        for note in notes:
            rospy.loginfo("%s", one_line(note))
        for served in found:
            try:
                maps.add(served)
            except ValueError as error:
                rospy.logerr("%s", error)
                served.labels.close()
    if not len(maps) and first is not None:
        raise first
    return maps


def _owner_info():
    return {**owner_info("cluster_label", "delete_label"), STORES_ALL: True}


def main(name: str = "hdf5_map_server") -> int:
    """Run the node; returns the exit code."""
    server = None
    try:
        init_node(name)
        options = parse(rospy.get_param("~", {}))
        with ended_by_signals():
            maps = load_maps(options)
        server = MapServer(maps, options)
        for served in maps:
            rospy.loginfo("%s", one_line(served.describe()))
        rospy.spin()
    except (MapFileError, ValueError) as error:
        sys.stderr.write("%s: error: %s\n" % (name, one_line(str(error))))
        return 1
    except KeyboardInterrupt:
        return 130  # as shells say it: ended by a signal before it served anything
    except rospy.ROSInterruptException:
        pass
    finally:
        if server is not None:  # in the main thread: at exit, Python starts no threads elsewhere
            server.close()
    return 0
