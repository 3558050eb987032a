"""Notices that labels of the map have changed, such as a forbidden area drawn in RViz."""

import logging
import threading
from typing import Any

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.ros.ros_adapter import RosAdapter

_LOG = logging.getLogger("mesh_map")


class LabelWatcher(RosAdapter):
    """Evaluates the layer again soon after labels of its map file, or their journal, have changed.

    It looks at the time stamps of the two files, so it does not matter who edits labels; where
    nothing has changed, nothing is read. Uses no topics, and does not need ROS.
    """

    PERIOD = 1.0  # seconds between two looks

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="labels", daemon=True)
        self._thread.start()

    def shutdown(self) -> None:
        """Ends the thread; does not wait for an evaluation that is under way."""
        self._closed.set()

    def _run(self) -> None:
        complaint = ""
        seen = self.layer.labels_version
        while not self._closed.wait(self.PERIOD):
            try:
                found = self.mesh_map.contents.labels_version()
                if found == seen:
                    continue
                _LOG.info("layer %s: the map file or its labels have changed", self.layer.name)
                seen = found
                self.refresh()
                complaint = ""
            except Exception as error:  # of the file, or of layers that depend on this one
                kind = "" if isinstance(error, MapFileError) else type(error).__name__ + ": "
                text = kind + one_line(error)
                if text != complaint:
                    _LOG.error("layer %s cannot follow the labels: %s", self.layer.name, text)
                complaint = text
