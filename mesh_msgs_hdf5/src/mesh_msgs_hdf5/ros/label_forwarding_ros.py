"""Sends label edits to the process that owns the labels of a map.

The owner has left in the journal where it can be reached (owner_info). Only the owner ever stores
anything, and it never forwards, so that nothing goes round in a circle.
"""
import os
import socket
import threading
import time
from typing import Any, Dict, Mapping

import numpy as np
import rosgraph
import rospy
from mesh_msgs import array_services, arrays
from mesh_msgs.srv import SetLabelColor
from std_msgs.msg import ColorRGBA
from std_srvs.srv import Trigger

from mesh_msgs_hdf5.labels.journal_reading import owner_text
from mesh_msgs_hdf5.labels.label_edits import LabelEdits
from mesh_msgs_hdf5.model.errors import MapFileError

# in what an owner says of itself: it folds its edits into the file when it is asked there
SAVE_SERVICE = "save_service"

_CONNECT, _STORE = 5.0, 5.0  # seconds
_POLL = 0.02


def owner_info(cluster_topic: str, delete_service: str, color_service: str) -> Dict[str, Any]:
    """What other processes are told about this node if it owns labels; names as for rospy."""
    return {
        "node": rospy.get_name(),
        "pid": os.getpid(),
        "host": socket.gethostname(),
        "master": rosgraph.get_master_uri(),
        "run_id": str(rospy.get_param("/run_id", "")),
        "cluster_topic": rospy.resolve_name(cluster_topic),
        "delete_service": rospy.resolve_name(delete_service),
        "color_service": rospy.resolve_name(color_service),
    }


class LabelForwarder:
    """Publishers to the owners of labels, made when they are needed. Safe for threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._publishers: Dict[str, rospy.Publisher] = {}

    def store(self, labels: LabelEdits, message: Any, received_on: str) -> bool:
        """Have the owner of these labels store a MeshFaceClusterStamped; True when it has.

        received_on: the topic that the message came on; an owner that listens there has it already,
        and False is returned at once: it says itself when it has stored it.
        Raises MapFileError (owned) if there is no owner that can be reached, or it does not store
        it.
        """
        owner = self._reachable(labels)
        topic = self._name(labels, owner, "cluster_topic")
        if topic == rospy.resolve_name(received_on):
            return False  # the next label of that text may be stored already
        sent = arrays.MeshFaceClusterStamped.from_message(message)
        sent.uuid = labels.uuid
        self._publish(labels, owner, topic, sent)
        self._wait_until_stored(labels, owner, message)
        return True

    def delete(self, labels: LabelEdits, text: str) -> arrays.MeshFaceCluster:
        """Have the owner delete a label; returns what was deleted. Raises MapFileError (owned)."""
        what = "delete label %s" % text
        answer = self._call(labels, "delete_service", array_services.DeleteLabel, what, text)
        return answer.cluster

    def set_color(self, labels: LabelEdits, text: str, color: ColorRGBA) -> None:
        """Have the owner give a label a color. Raises MapFileError (owned)."""
        what = "color label %s" % text
        self._call(labels, "color_service", SetLabelColor, what, text, color)

    def save(self, labels: LabelEdits) -> str:
        """Have the owner put its edits into the file; what it says. "" where it does so by itself.

        Raises MapFileError (owned).
        """
        owner = self._reachable(labels)
        if SAVE_SERVICE not in owner:
            return ""
        name = self._name(labels, owner, SAVE_SERVICE)
        try:
            rospy.wait_for_service(name, _CONNECT)
            answer = rospy.ServiceProxy(name, Trigger)()
        except (rospy.ServiceException, rospy.ROSException) as error:
            raise self._refused(labels, owner, "did not save them: %s" % error)
        if not answer.success:
            raise self._refused(labels, owner, "did not save them: %s" % answer.message)
        return answer.message

    def _call(self, labels, key, kind, what, *arguments):
        owner = self._reachable(labels)
        name = self._name(labels, owner, key)
        try:
            rospy.wait_for_service(name, _CONNECT)
            return rospy.ServiceProxy(name, kind)(labels.uuid, *arguments)
        except (rospy.ServiceException, rospy.ROSException) as error:
            raise self._refused(labels, owner, "did not %s: %s" % (what, error))

    def _reachable(self, labels):
        owner = labels.owner
        if owner is None:
            raise labels.refusal or MapFileError(
                "owned", labels.path, "its labels have just lost their owner", "try again"
            )
        if owner.get("node") == rospy.get_name():
            raise self._refused(labels, owner, "is of the same name: start one of them only")
        here = str(rospy.get_param("/run_id", "")), rosgraph.get_master_uri()
        there = str(owner.get("run_id", "")), owner.get("master")
        if not (here[0] and here[0] == there[0]) and here[1] != there[1]:
            raise self._refused(labels, owner, "is not on this roscore: label there, or end it")
        return owner

    def _name(self, labels, owner, key):
        name = owner.get(key)
        if not isinstance(name, str) or not rosgraph.names.is_legal_name(name) or name[:1] != "/":
            raise self._refused(labels, owner, "takes no label edits: end it, and try again")
        return name

    def _publish(self, labels, owner, topic, message):
        with self._lock:
            if topic not in self._publishers:
                self._publishers[topic] = rospy.Publisher(
                    topic, arrays.MeshFaceClusterStamped, queue_size=0  # unlimited: none is dropped
                )
            publisher = self._publishers[topic]
        deadline = time.monotonic() + _CONNECT
        # a message that is published before the owner has connected would be lost
        while owner["node"] not in {peer.endpoint_id for peer in publisher.impl.connections}:
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise self._refused(labels, owner, "does not listen on %s" % topic)
            time.sleep(_POLL)
        publisher.publish(message)

    def _wait_until_stored(self, labels, owner, message):
        faces = np.unique(np.asarray(message.cluster.face_indices, np.uint32))
        text = message.cluster.label
        deadline = time.monotonic() + _STORE
        while not self._has(labels, text, faces, message.override):
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise self._refused(labels, owner, "has not stored label %s: see its log" % text)
            time.sleep(_POLL)

    @staticmethod
    def _has(labels, text, faces, override):
        try:
            found = labels.get(text).faces
        except MapFileError:
            return not faces.size  # which makes no label
        if override:
            return np.array_equal(np.sort(found), faces)
        return bool(np.isin(faces, found).all())

    @staticmethod
    def _refused(labels: LabelEdits, owner: Mapping[str, Any], what: str) -> MapFileError:
        return MapFileError(
            "owned",
            labels.path,
            "its labels are edited by %s, which %s" % (owner_text(owner), what),
        )
