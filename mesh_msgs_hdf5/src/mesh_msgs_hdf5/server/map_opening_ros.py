"""Opens the maps that a server was asked for, one after the other or later."""
import time
from typing import Any, Dict, List, Optional

import rospy

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server.map_loading import load, owner_notes
from mesh_msgs_hdf5.server.map_progress_ros import MapProgress
from mesh_msgs_hdf5.server.map_registry import MapRegistry
from mesh_msgs_hdf5.server.served_map import ServedMap
from mesh_msgs_hdf5.server.server_options import ServerOptions

_AGAIN = 1.0  # seconds until a file that another program has open is tried once more


class MapOpening:
    """Opens maps; those that another program has open to write are tried again until they can be
    read, which is said once of each. Any other error is final: one log line.
    """

    def __init__(
        self,
        maps: MapRegistry,
        options: ServerOptions,
        progress: MapProgress,
        owner_info: Dict[str, Any],
    ) -> None:
        """maps: gets what is opened. owner_info: as in map_loading.load()."""
        self._maps = maps
        self._waiting = list(options.maps)
        self._several = len(options.maps) > 1
        self._options = owner_info, options.read_only
        self._progress = progress
        self._said: List[str] = []
        self._next = 0.0
        self._starting = True
        self._first: Optional[MapFileError] = None

    def open_first(self) -> None:
        """Open all that can be read now; waits while none can but may be later.

        Raises MapFileError if there is none: that of the first.
        """
        self.open_waiting()
        while self._waiting and not len(self._maps):
            time.sleep(max(0.0, self._next - time.monotonic()))
            self.open_waiting()
        self._starting = False
        if not len(self._maps) and self._first is not None:
            raise self._first

    def open_waiting(self) -> List[ServedMap]:
        """Those of the maps that were waited for which are served from now on."""
        now = time.monotonic()
        if not self._waiting or now < self._next:
            return []
        opened: List[ServedMap] = []
        waiting, self._waiting = self._waiting, []
        for request in waiting:
            try:
                opened += self._open(request)
            except MapFileError as error:
                if error.code == "locked":
                    self._waiting.append(request)
                    self._say_once(request.path, error)
                    continue
                self._first = self._first or error
                if self._several:
                    rospy.logerr("not served: %s", error)
        self._next = time.monotonic() + _AGAIN
        return opened

    def _say_once(self, path, error):
        if path not in self._said:
            self._said.append(path)
            rospy.logwarn("%s; it is served as soon as that is done", error)
        if self._starting:
            self._progress.reading(path, error.message)

    def _open(self, request):
        if self._starting:
            self._progress.reading(request.path)
        found, notes = load(request, rospy.Time.now(), *self._options)
        for note in notes + owner_notes(found, self._options[1]):
            rospy.loginfo("%s", one_line(note))
        self._progress.loaded(request.path, notes)
        opened = []
        for served in found:
            try:
                self._maps.add(served)
                opened.append(served)
            except ValueError as error:
                rospy.logerr("%s", error)
                served.labels.close()
        return opened
