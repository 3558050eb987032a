"""The colors of labels over ROS: two services and a latched topic."""
import threading
from typing import Any, Callable, Dict, List, Optional, Tuple

import rospy
from mesh_msgs.msg import MeshLabelColors
from mesh_msgs.ros import LatchedTopics
from mesh_msgs.srv import (
    GetLabelColors,
    GetLabelColorsResponse,
    SetLabelColor,
    SetLabelColorResponse,
)
from std_msgs.msg import ColorRGBA

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Color, Label
from mesh_msgs_hdf5.ros.label_forwarding_ros import LabelForwarder

# (UUID of the geometry, its labels: LabelStore or what has its interface)
Found = Tuple[str, Any]


class LabelColorServices:
    """get_label_colors, set_label_color, and label_colors: for each mesh all labels with a color.

    The topic is filled when somebody subscribes to it: labels are not read before.
    """

    def __init__(
        self,
        prefix: str,
        find: Callable[[str], Found],
        answering: Callable[[Callable[[Any], Any]], Callable[[Any], Any]],
        forwarder: LabelForwarder,
    ) -> None:
        """prefix: of the names. find: the labels of a UUID; its errors are for answering.

        answering: makes a handler of a service of a function that raises MapFileError.
        """
        self._find = find
        self._forwarder = forwarder
        self._lock = threading.Lock()
        self._publishing = threading.Lock()
        self._stale: Dict[str, Any] = {}
        self._topic = LatchedTopics(prefix + "label_colors", MeshLabelColors)
        self._services: List[rospy.Service] = [
            rospy.Service(prefix + "get_label_colors", GetLabelColors, answering(self._get)),
            rospy.Service(prefix + "set_label_color", SetLabelColor, answering(self._set)),
        ]

    def changed(self, uuid: str, labels: Any) -> None:
        """There are other labels, or other colors, than before."""
        with self._lock:
            self._stale[uuid] = labels

    def forget(self, uuid: str) -> None:
        """Nothing of this mesh is sent to later subscribers."""
        with self._publishing:
            with self._lock:
                self._stale.pop(uuid, None)
            if (uuid, None) in self._topic.keys():
                self._topic.remove((uuid, None))

    def publish_wanted(self) -> None:
        """What has changed, if somebody listens; what cannot be read is a log line."""
        if not self._topic.get_num_connections():
            return
        with self._publishing:  # of two changes at the same time, the last one is kept
            with self._lock:
                stale, self._stale = self._stale, {}
            for uuid, labels in stale.items():
                try:
                    names, colors = label_colors(labels.all())
                except (MapFileError, MemoryError) as error:
                    rospy.logerr("the colors of labels are not published: %s", one_line(str(error)))
                    continue
                message = MeshLabelColors(uuid=uuid, labels=names, colors=colors)
                self._topic.publish((uuid, None), message)

    def _get(self, request: Any) -> GetLabelColorsResponse:
        names, colors = label_colors(self._find(request.uuid)[1].all())
        return GetLabelColorsResponse(labels=names, colors=colors)

    def _set(self, request: Any) -> SetLabelColorResponse:
        uuid, labels = self._find(request.uuid)
        color = color_of(labels.path, request.label, request.color)
        try:
            labels.set_color(request.label, color)
        except MapFileError as error:
            if error.code != "owned":
                raise
            self._forwarder.set_color(labels, request.label, request.color)
        self.changed(uuid, labels)
        self.publish_wanted()
        return SetLabelColorResponse()


def label_colors(labels: Dict[str, Label]) -> Tuple[List[str], List[ColorRGBA]]:
    """The labels that have a color of their own, in their order."""
    found = {text: label.color for text, label in labels.items() if label.color is not None}
    colors = [ColorRGBA(*(part / 255.0 for part in color), 1.0) for color in found.values()]
    return list(found), colors


def color_of(path: str, text: str, color: ColorRGBA) -> Optional[Color]:
    """The bytes of a color; None for one of alpha 0. Raises MapFileError (value)."""
    parts = (color.r, color.g, color.b)
    if not all(0.0 <= part <= 1.0 for part in parts + (color.a,)):
        raise MapFileError(
            "value",
            path,
            "the color of label %s is %s, alpha %g" % (one_line(text)[:80], parts, color.a),
            "each channel is from 0 to 1",
        )
    red, green, blue = (int(round(255.0 * part)) for part in parts)
    return (red, green, blue) if color.a else None
