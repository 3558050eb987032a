"""Publishes the origins of maps as static transforms, where that is asked for."""
import time
from typing import Dict, Tuple

import rosgraph
import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.server.origin_frame import FrameTree
from mesh_msgs_hdf5.server.served_map import ServedMap

_TOPIC = "/tf_static"
_WAIT, _LATCHED = 3.0, 0.3  # seconds: for other publishers, and for what they have latched


class OriginFrames:
    """From the frame of each map to one frame of its reference system, such as utm.

    A map whose frame has a parent already gets none, with a line in the log.
    """

    def __init__(self, frame: str = "") -> None:
        """frame: the parent; "" publishes nothing."""
        self._frame = frame
        self._tree = FrameTree()
        # frame of a map -> (path of the map, what is published)
        self._published: Dict[str, Tuple[str, TransformStamped]] = {}
        if frame:
            self._publisher = rospy.Publisher(_TOPIC, TFMessage, latch=True, queue_size=10)
            self._subscriber = rospy.Subscriber(_TOPIC, TFMessage, self._on_transforms)
            self._wait_for_others()

    def publish(self, served: ServedMap) -> None:
        """The origin of a map, or in the log why it is not published."""
        if not self._frame:
            return
        overlay = served.overlay
        with overlay.lock:
            origin, crs = tuple(overlay.source.origin), overlay.source.crs
        child = overlay.frame_id
        why = self._tree.refusal(self._frame, child, rospy.get_name())
        path, before = self._published.get(child, (served.path, None))
        if not why and before is not None and path != served.path and _place(before) != origin:
            why = "frame %s is at the origin of %s" % (child, path)
        if why:
            text = "%s: its origin is not published in frame %s: %s"
            rospy.logerr("%s", one_line(text % (served.name, self._frame, why)))
            return
        self._published[child] = path, _transform(self._frame, child, origin)
        self._publisher.publish(TFMessage([found for _, found in self._published.values()]))
        text = "%s: frame %s is at %s, %s, %s of frame %s (%s)"
        where = crs or "the map names no coordinate reference system"
        rospy.loginfo("%s", one_line(text % (served.name, child, *origin, self._frame, where)))

    def _wait_for_others(self) -> None:
        """Until the publishers that there are have told what they have latched."""
        end = time.monotonic() + _WAIT
        while time.monotonic() < end and not rospy.is_shutdown():
            publishers, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
            nodes = dict(publishers).get(self._subscriber.resolved_name, [])
            if self._subscriber.get_num_connections() >= len(nodes):
                break
            time.sleep(0.05)
        time.sleep(_LATCHED)

    def _on_transforms(self, message: TFMessage) -> None:
        node = message._connection_header.get("callerid", "")
        for found in message.transforms:
            child, parent = found.child_frame_id, found.header.frame_id
            self._tree.add(child, parent, node)
            if node != rospy.get_name() and child.lstrip("/") in self._published:
                text = "%s publishes %s as another parent of frame %s: one of both has to go"
                rospy.logerr_once("%s", one_line(text % (node, parent, child)))


def _transform(parent: str, child: str, place: Tuple[float, ...]) -> TransformStamped:
    transform = TransformStamped()
    transform.header.stamp = rospy.Time.now()
    transform.header.frame_id, transform.child_frame_id = parent, child
    to = transform.transform.translation
    to.x, to.y, to.z = place
    transform.transform.rotation.w = 1.0
    return transform


def _place(transform: TransformStamped) -> Tuple[float, ...]:
    place = transform.transform.translation
    return place.x, place.y, place.z
