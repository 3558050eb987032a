"""Loads a map anew when another program has put another mesh in the place of its file."""
from typing import Any, Dict, List

import rospy

from mesh_msgs_hdf5.errors import MapFileError, one_line
from mesh_msgs_hdf5.server.map_loading import load, uuid_now
from mesh_msgs_hdf5.server.map_registry import MapRegistry
from mesh_msgs_hdf5.server.map_topics_ros import MapTopics
from mesh_msgs_hdf5.server.served_map import ServedMap
from mesh_msgs_hdf5.writing.save import stamp

_REPLACED = "another program has replaced the mesh"


class MapReload:
    """Looks at the files of all maps, and loads what has another geometry now.

    Not where changes of the old mesh wait to be saved: they are kept until the file is back or the
    node ends. A file of the same geometry needs nothing: each request reads it as it is.
    """

    def __init__(
        self, maps: MapRegistry, topics: MapTopics, owner_info: Dict[str, Any], read_only: bool
    ) -> None:
        """owner_info, read_only: as in map_loading.load()."""
        self._maps = maps
        self._topics = topics
        self._options = owner_info, read_only
        self._known = self._stamps()
        self._before = self._known

    def look(self) -> None:
        """To be called now and then, in one thread."""
        now = self._stamps()
        for served in self._maps:
            path = served.path
            # the same at two looks: nobody is writing it
            if now[path] != self._known.get(path) and now[path] == self._before.get(path):
                self._look_at(served)
        settled = {path for path in now if now[path] == self._before.get(path)}
        self._known = {path: (now if path in settled else self._known).get(path) for path in now}
        self._before = now

    def _stamps(self):
        return {served.path: stamp(served.path) for served in self._maps}

    def _look_at(self, served: ServedMap) -> None:
        try:
            if uuid_now(served.request) == served.uuid and not served.is_ended:
                return
            if served.labels.dirty or not served.is_saved:
                rospy.logerr(
                    "%s: %s, but what was stored in the old one is not saved: the new one is served"
                    " when the node is started again; to save it, put the old file back",
                    *(served.name, _REPLACED),
                )
                return
            self._reload(served)
        except (MapFileError, ValueError, MemoryError) as error:
            text = str(error) or "%s: there is not enough memory" % served.name
            rospy.logerr("the new file is not served: %s", one_line(text))

    def _reload(self, served: ServedMap) -> None:
        served.end("nothing is stored: " + _REPLACED)
        served.labels.close()
        found, notes = load(served.request, rospy.Time.now(), *self._options)
        self._log(notes)
        try:
            self._maps.replace(served, found[0])
        except ValueError:
            found[0].labels.close()
            raise
        self._topics.forget_map(served)
        self._topics.publish_map(found[0])
        rospy.loginfo("%s: now %s", _REPLACED, one_line(found[0].describe()))

    @staticmethod
    def _log(notes: List[str]) -> None:
        for note in notes:
            rospy.loginfo("%s", one_line(note))
