"""Loads a map anew when another program has changed its file."""
from typing import Any, Dict, Set

import rospy

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.files.save import stamp
from mesh_msgs_hdf5.formats.any_mesh import Members, MeshMembers
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server.map_loading import load, owner_notes, source_now
from mesh_msgs_hdf5.server.map_progress_ros import MapProgress
from mesh_msgs_hdf5.server.map_registry import MapRegistry
from mesh_msgs_hdf5.server.map_topics_ros import MapServerTopics
from mesh_msgs_hdf5.server.served_map import ServedMap

_REPLACED = "another program has replaced the mesh"


class MapReload:
    """Looks at the files of all maps, and loads what has another geometry now.

    Not where changes of the old mesh wait to be saved: they are kept until the file is back or the
    node ends. Of a file of the same geometry everything is published once more.
    """

    def __init__(
        self,
        maps: MapRegistry,
        topics: MapServerTopics,
        progress: MapProgress,
        owner_info: Dict[str, Any],
        read_only: bool,
    ) -> None:
        """owner_info, read_only: as in map_loading.load()."""
        self._maps = maps
        self._topics = topics
        self._progress = progress
        self._options = owner_info, read_only
        # A file that was replaced since it was loaded is loaded anew.
        self._known = {served.path: served.loaded_stamp for served in maps}
        self._before = self._known
        self._locked: Set[str] = set()  # that another program has open to write, which was said

    def watch(self, served: ServedMap) -> None:
        """Look at one more map, which has just been loaded."""
        self._known = {**self._known, served.path: served.loaded_stamp}

    def look(self) -> None:
        """To be called now and then, in one thread."""
        now = self._stamps()
        for served in self._maps:
            path = served.path
            # the same at two looks: nobody is writing it
            if now[path] != self._known.get(path) and now[path] == self._before.get(path):
                if served.is_changed(now[path]):
                    self._look_at(served, now[path])
        settled = {path for path in now if now[path] == self._before.get(path)} - self._locked
        self._known = {path: (now if path in settled else self._known).get(path) for path in now}
        self._before = now
        for served in self._maps:
            self._progress.say_notes(served)  # much is read only when it is asked for
        self._progress.ready(self._maps)

    def _stamps(self):
        return {served.path: stamp(served.path) for served in self._maps}

    def _look_at(self, served: ServedMap, found: Any) -> None:
        try:
            source = source_now(served.request)
            self._locked.discard(served.path)
            if source.uuid == served.uuid and not served.is_ended:
                self._publish_again(served, source)
                served.loaded_stamp = found
                return
            if served.labels.dirty or not served.is_saved:
                text = "%s: %s, but what was stored in the old one is not saved: put the old file"
                text += " back, then it is saved; when the node is started again, the new one is"
                text += " served, and what waits, labels apart, is lost"
                text %= served.name, _REPLACED
                rospy.logerr("%s", one_line(text))
                self._progress.failed(served.path, text)
                return
            self._reload(served)
        except (MapFileError, ValueError, MemoryError) as error:
            if isinstance(error, MapFileError) and error.code == "locked":
                self._wait_for(served, error)
                return
            self._locked.discard(served.path)
            text = str(error) or "%s: there is not enough memory" % served.name
            rospy.logerr("the new file is not served: %s", one_line(text))
            self._progress.failed(served.path, text)

    def _wait_for(self, served: ServedMap, error: MapFileError) -> None:
        if served.path not in self._locked:
            self._locked.add(served.path)
            rospy.logwarn("%s; what is new in it is served as soon as that is done", error)

    def _publish_again(self, served: ServedMap, source: Members) -> None:
        self._progress.failed(served.path, "")
        overlay = served.overlay
        if overlay.path != served.path:
            return  # it is served from the map file beside it
        if isinstance(source, MeshMembers):
            with overlay.lock:
                overlay.source = source
        overlay.follow_source()
        self._topics.publish_map(served)
        self._progress.serves(served)
        text = "%s has been changed by another program: now %s"
        rospy.loginfo("%s", one_line(text % (served.name, served.describe())))

    def _reload(self, served: ServedMap) -> None:
        served.end("nothing is stored: " + _REPLACED)
        served.labels.close()
        self._progress.reading(served.path)
        found, notes = load(served.request, rospy.Time.now(), *self._options)
        for note in notes + owner_notes(found, self._options[1]):
            rospy.loginfo("%s", one_line(note))
        self._progress.loaded(served.path, notes)
        try:
            self._maps.replace(served, found[0])
        except ValueError:
            found[0].labels.close()
            raise
        self._topics.forget_map(served)
        self._topics.publish_map(found[0])
        self._progress.serves(found[0])
        rospy.loginfo("%s: now %s", _REPLACED, one_line(found[0].describe()))
