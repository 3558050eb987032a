"""Node label_manager: stores labeled clusters of faces, and answers what is labeled."""
import contextlib
import time
from typing import Any, Iterator, List, Optional, Set

import rospy
from mesh_msgs import arrays, validation
from mesh_msgs.diagnostics_ros import ERROR, OK, WARN, Diagnostics, Status
from mesh_msgs.srv import GetUUIDs
from std_srvs.srv import Trigger, TriggerResponse

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.label_manager.label_manager_options import LabelOptions, parse
from mesh_msgs_hdf5.label_manager.label_maps import LabelMaps
from mesh_msgs_hdf5.labels.journal_reading import OwnedError
from mesh_msgs_hdf5.labels.label_edits import LabelEdits
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.ros.label_forwarding_ros import LabelForwarder, owner_info
from mesh_msgs_hdf5.ros.label_services_ros import Found, LabelServices, answering
from mesh_msgs_hdf5.ros.loading_signals import ended_by_signals
from mesh_msgs_hdf5.ros.run_node_ros import run_node
from mesh_msgs_hdf5.ros.sent_names import sent_name_fault
from mesh_msgs_hdf5.ros.store_results_ros import EVERY_MESSAGE, StoreResults

_OWN, _SHARED = "~cluster_label", "cluster_label"
_POLL = 0.5  # seconds between two looks whether somebody wants the colors of labels
_LOCKED_AGAIN = 1.0  # seconds until a file that another program has open is tried once more
_QUIET = 10  # seconds between two equal error lines


class LabelManager:
    """Topics and services over the labels of some maps.

    A label of a map that another process owns is sent to that one.
    """

    def __init__(self, maps: LabelMaps, import_folder: str) -> None:
        """import_folder: where ~import_labels looks for the files of label_manager 1.x."""
        self._maps = maps
        self._import_folder = import_folder
        self._forwarder = LabelForwarder()
        self._log_notes()
        self._colored: Set[str] = set()
        self._services = [
            rospy.Service("~" + name, Trigger, answering(handler))
            for name, handler in (("save_map", self._save), ("import_labels", self._import))
        ]
        self._labels = LabelServices("~", self._found, self._forwarder)
        self._results = StoreResults("~store/result")
        self._timer = rospy.Timer(rospy.Duration(_POLL), lambda _event: self._publish_colors())
        self._subscribers = [
            rospy.Subscriber(
                name, arrays.MeshFaceClusterStamped, self._receive, name, queue_size=EVERY_MESSAGE
            )
            # where the names are remapped to one topic, it is subscribed to once
            for name in {rospy.resolve_name(name): name for name in (_SHARED, _OWN)}.values()
        ]
        self._unsaved: List[str] = []  # of the last attempt to save
        self._diagnostics = Diagnostics("labels", self._status)

    def close(self) -> None:
        """Receive nothing more, and put all edits into the map files."""
        self._diagnostics.shutdown()
        self._timer.shutdown()
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._save()
        self._maps.close()

    def _status(self) -> Status:
        """For /diagnostics."""
        if self._unsaved:
            return Status(ERROR, "labels stay in the journal: %s" % "; ".join(self._unsaved))
        if self._results.last_refusal:
            return Status(WARN, self._results.last_refusal)
        return Status(OK, "maps with labels: %d" % len(list(self._maps.uuids())))

    def _receive(self, message: Any, topic: str) -> None:
        sent = topic, message.cluster.label, message.header.stamp
        try:
            if topic == _SHARED and self._is_served_elsewhere(message.uuid):
                return
            for name in (message.uuid, message.cluster.label):
                fault = sent_name_fault(name)
                if fault:
                    raise MapFileError("label", self._maps.folder, fault)
            labels = self._maps.find_or_make(message.uuid)
            self._log_notes()
            is_done = self._store(labels, message, topic)
        except MapFileError as error:
            rospy.logerr_throttle_identical(_QUIET, "label not stored: %s" % error)
            self._results.refused(message.uuid, *sent, str(error))
            return
        self._labels.stored(labels.uuid, labels, message.cluster)
        if is_done:
            self._results.stored(labels.uuid, *sent)

    def _store(self, labels: LabelEdits, message: Any, topic: str) -> bool:
        """Whether it is known to be on the disk."""
        received = message.cluster
        findings = validation.mesh_face_cluster(received, labels.face_count)
        if findings:
            raise MapFileError(findings[0].rule, labels.path, str(findings[0]))
        try:
            labels.set(received.label, received.face_indices, override=bool(message.override))
        except OwnedError:
            return self._forwarder.store(labels, message, topic)
        return True

    def _is_served_elsewhere(self, uuid: str) -> bool:
        """True for a label, on the topic of hdf5_map_server, that the server here stores."""
        if self._maps.is_known(uuid):
            return False
        try:
            served = rospy.ServiceProxy("get_uuids", GetUUIDs)().uuids
        except (rospy.ServiceException, rospy.ROSException):
            return False  # there is no server
        return uuid in served or uuid in ("", "mesh")

    def _found(self, uuid: str) -> Found:
        labels = self._maps.find(uuid)
        return labels.uuid, labels

    def _publish_colors(self) -> None:
        """Of meshes that were not published yet, and what has changed."""
        for uuid in self._maps.uuids():
            if uuid not in self._colored:
                with contextlib.suppress(MapFileError):  # moved to another map meanwhile
                    self._labels.changed(uuid, self._maps.find(uuid))
                    self._colored.add(uuid)
        self._labels.publish_wanted()
        self._log_notes()  # what is bad in a file is known once it has been read

    def _save(self, _request=None):
        done, failed = self._maps.save()
        self._unsaved = list(failed)
        for line in done:
            rospy.loginfo("%s", line)
        for line in failed:
            rospy.logerr("labels stay in the journal: %s", line)
        return TriggerResponse(
            success=not failed, message="; ".join(failed or done) or "no changes"
        )

    def _import(self, _request):
        try:
            done = self._maps.import_folder(self._import_folder)
        except MapFileError as error:
            return TriggerResponse(success=False, message=str(error))
        for line in done:
            rospy.loginfo("%s", line)
        good = not any(line.startswith("not ") for line in done)
        return TriggerResponse(success=good, message="; ".join(done))

    def _log_notes(self) -> None:
        for note in self._maps.taken_notes():
            rospy.loginfo("%s", one_line(note))


def load_maps(options: LabelOptions) -> LabelMaps:
    """The labels of all maps that are named, imported ones among them. Raises MapFileError."""
    maps = LabelMaps(options.folder, owner_info(_OWN, "~delete_label", "~set_label_color"))
    try:
        for path in options.maps:
            try:
                options.check(path)
                store = _added(maps, path, options.part)
            except MapFileError as error:
                if len(options.maps) == 1:
                    raise
                rospy.logerr("not loaded: %s", error)
                continue
            rospy.loginfo("%s", one_line(describe(store)))
        maps.move_to_the_only_map()
        if not options.maps:
            rospy.loginfo("no ~map_file is named: labels are kept in %s", maps.folder)
        if options.import_at_start:
            for line in maps.import_folder(options.import_folder):
                rospy.loginfo("%s", one_line(line))
    except BaseException:
        maps.close()
        raise
    return maps


def _added(maps: LabelMaps, path: str, part: Optional[str]) -> LabelEdits:
    """The labels of a map, which is waited for while another program has it open to write."""
    said = False
    while True:
        try:
            return maps.add(path, part)
        except MapFileError as error:
            if error.code != "locked":
                raise
            if not said:
                rospy.logwarn("%s; it is loaded as soon as that is done", error)
                said = True
        time.sleep(_LOCKED_AGAIN)


def describe(store: LabelEdits) -> str:
    """Whose labels are there, in one line."""
    line = "labels of %s: %d, uuid %s" % (store.path, len(store.names()), store.uuid)
    return line if store.is_owner else "%s; %s" % (line, store.refusal)


@contextlib.contextmanager
def _running() -> Iterator[None]:
    options = parse(rospy.get_param("~", {}))
    with ended_by_signals():
        maps = load_maps(options)
    manager = LabelManager(maps, options.import_folder)
    try:
        yield
    finally:
        manager.close()


def main() -> int:
    """Run the node; returns the exit code."""
    return run_node("label_manager", _running, __doc__)
