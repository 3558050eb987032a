"""What hdf5_map_server receives: topics, and the saving of what came on them."""
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Tuple

import rospy
from mesh_msgs import arrays
from mesh_msgs.msg import MeshFeatures, MeshTexture
from std_srvs.srv import Trigger, TriggerResponse

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.files.save import stamp as file_stamp
from mesh_msgs_hdf5.labels.journal_reading import OwnedError
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label
from mesh_msgs_hdf5.ros.label_forwarding_ros import LabelForwarder
from mesh_msgs_hdf5.ros.label_services_ros import LabelServices
from mesh_msgs_hdf5.ros.map_messages import cluster
from mesh_msgs_hdf5.ros.store_results_ros import EVERY_MESSAGE, StoreResults
from mesh_msgs_hdf5.server import received
from mesh_msgs_hdf5.server.map_registry import MapRegistry, UnknownMap
from mesh_msgs_hdf5.server.map_topics_ros import MapServerTopics
from mesh_msgs_hdf5.server.pending import Sent, sent_on
from mesh_msgs_hdf5.server.received import Refused
from mesh_msgs_hdf5.server.served_map import ServedMap

_LABELS = "cluster_label"
_POLL = 0.5  # seconds between two looks at what is to be done
_LATEST = 10  # with an endless stream of messages, it is saved after so many save_delays
_TRY_AGAIN = 1.0  # seconds until what another program has open is tried once more
_AGAIN = 60.0  # seconds until the same warning is logged once more
_SHOWN = 10
_WARNINGS = 1000  # different ones that are remembered
_TOPICS = (
    ("store/vertex_costs", arrays.MeshVertexCostsStamped, received.vertex_costs),
    (
        "store/vertex_costs_update",
        arrays.MeshVertexCostsSparseStamped,
        received.vertex_costs_update,
    ),
    ("store/face_costs", arrays.MeshFaceCostsStamped, received.face_costs),
    ("store/vertex_colors", arrays.MeshVertexColorsStamped, received.vertex_colors),
    ("store/materials", arrays.MeshMaterialsStamped, received.materials),
    ("store/texture", MeshTexture, received.texture),
    ("store/features", MeshFeatures, received.features),
)


class MapStore:
    """Receives, publishes and saves, and says of each message what became of it.

    What was received is saved when nothing more has come for save_delay seconds, by save_map and
    by close(). What cannot be saved is one log line and is tried again at the next of these, and
    when the file has changed.

    Attributes: results (says of messages what became of them), unsaved (of the last attempt to
    save, what it says of failures).
    """

    def __init__(
        self,
        maps: MapRegistry,
        topics: MapServerTopics,
        labels: LabelServices,
        forwarder: LabelForwarder,
        save_delay: float,
        look: Callable[[], None],
    ) -> None:
        """look: called about twice a second, in the thread that saves."""
        self._maps = maps
        self._topics = topics
        self._labels = labels
        self._forwarder = forwarder
        self._delay = save_delay
        self._look = look
        self._due: Optional[float] = None
        self._latest: Optional[float] = None
        self._wake = threading.Condition()
        self._warned: Dict[str, float] = {}
        self._closed = False
        self.unsaved: List[str] = []
        self._waits: Dict[str, Tuple[str, Any]] = {}  # UUID -> why, and the stamp of the file then
        self.results = StoreResults("store/result")
        self._subscribers: List[rospy.Subscriber] = [
            rospy.Subscriber(name, kind, self._receiver(name, read), queue_size=EVERY_MESSAGE)
            for name, kind, read in _TOPICS
        ]
        self._subscribers.append(
            rospy.Subscriber(
                _LABELS, arrays.MeshFaceClusterStamped, self._label, queue_size=EVERY_MESSAGE
            )
        )
        self._service = rospy.Service("save_map", Trigger, self._save_map)
        self._thread = threading.Thread(target=self._run, name="save", daemon=True)
        self._thread.start()

    def close(self) -> bool:
        """Save everything; nothing is received any more. False if something is lost, which is
        logged."""
        with self._wake:
            self._closed = True
            self._wake.notify_all()
        self._thread.join()
        for subscriber in self._subscribers:
            subscriber.unregister()
        for served in self._maps:  # a message that is being received is saved, or refused
            served.end("nothing is stored: the server is ending")
        self._save(fold_labels=True)
        for served in self._maps:
            served.labels.close()
        lost = [served for served in self._maps if served.pending.now()]
        for served in lost:
            self._tell_lost(served)
        return not lost

    def _tell_lost(self, served: ServedMap) -> None:
        names = [("%s %s" % sent[:2]).strip() for sent in served.pending.now()]
        shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
        why, _ = self._waits.get(served.uuid, ("not saved", None))
        text = "lost with the end of the node, not in %s: %d received change%s (%s): %s; %s"
        text %= (
            *(served.target, len(names), "" if len(names) == 1 else "s", shown),
            *(why, "mend that and send them once more"),
        )
        rospy.logerr("%s", one_line(text))

    def _receiver(self, name: str, read: Callable[[Any, Any], received.Received]) -> Any:
        def receive(message: Any) -> None:
            uuid = message.map_uuid if name == "store/features" else message.uuid
            sent = sent_on(name, message)
            try:
                served = self._maps.find(uuid)
                change = served.store(read, message, rospy.Time.now(), sent)
            except (Refused, UnknownMap, MapFileError, MemoryError) as error:
                self._refuse(uuid, sent, str(error) or "there is not enough memory")
                return
            for note in change.notes:
                self._warn("%s: %s" % (name, note))
            self._topics.publish_change(served, change.member, change.key)
            self._expect_more()

        return receive

    def _label(self, message: Any) -> None:
        sent = sent_on(_LABELS, message)
        try:
            served = self._maps.find(message.uuid)
            label = received.label(message, served.overlay)
            stored, is_done = self._set_label(served, message, label)
        except (Refused, UnknownMap, MapFileError) as error:
            self._refuse(message.uuid, sent, str(error))
            return
        self._labels.stored(served.uuid, served.labels, cluster(message.cluster.label, stored))
        if is_done:
            self.results.stored(served.uuid, *sent)

    def _set_label(self, served: ServedMap, message: Any, label: Label) -> Tuple[Label, bool]:
        """The label as it is now, and whether that is known to be on the disk; another process that
        owns the labels is sent the message."""
        text = message.cluster.label
        try:
            return served.labels.set(text, label.faces, override=bool(message.override)), True
        except OwnedError:
            is_done = self._forwarder.store(served.labels, message, _LABELS)
            known = text in served.labels.names()
            return (served.labels.get(text) if known else label), is_done

    def _refuse(self, uuid: str, sent: Sent, why: str) -> None:
        self.results.refused(uuid, *sent, why)
        self._warn("%s: refused: %s" % (sent.topic, why))

    def _warn(self, text: str) -> None:
        """Log a warning, but not the same one for every message of a stream."""
        now = time.monotonic()
        with self._wake:
            again = now < self._warned.get(text, now)
            if not again:
                if len(self._warned) >= _WARNINGS:
                    self._warned.clear()
                self._warned[text] = now + _AGAIN
        if not again:
            rospy.logwarn("%s", one_line(text))

    def _expect_more(self, at_least: float = 0.0) -> None:
        """Save soon, but not before so many seconds."""
        now, delay = time.monotonic(), max(self._delay, at_least)
        with self._wake:
            if self._latest is None:
                self._latest = now + _LATEST * delay
            self._due = min(now + delay, self._latest)
            self._wake.notify_all()

    def _run(self) -> None:
        while True:
            with self._wake:
                if self._closed:
                    return
                now = time.monotonic()
                due = self._due is not None and now >= self._due
                if due:
                    self._due = self._latest = None
                else:
                    wait = _POLL if self._due is None else min(_POLL, self._due - now)
                    self._wake.wait(wait)
            try:
                if due:
                    self._save()
                self._look()
                self._look_for_changes()
                self._topics.publish_wanted()
            except Exception as error:  # whatever it is, the next save must come
                if not rospy.is_shutdown():
                    rospy.logerr("saving or publishing failed: %r", error)

    def _look_for_changes(self) -> None:
        """Try again where the file that could not be changed is not the same any more."""
        for served in self._maps:
            _, stamp = self._waits.get(served.uuid, ("", None))
            if served.uuid in self._waits and file_stamp(served.target) != stamp:
                self._waits[served.uuid] = self._waits[served.uuid][0], file_stamp(served.target)
                self._expect_more(_TRY_AGAIN)

    def _save_map(self, _request: Any) -> TriggerResponse:
        done, failed = self._save(fold_labels=True)
        return TriggerResponse(success=not failed, message="; ".join(failed + done) or "no changes")

    def _save(self, fold_labels: bool = False) -> Tuple[List[str], List[str]]:
        """Save all maps; returns (what was saved, what was not) as sentences, which are logged."""
        saved, failed, locked = [], [], []
        for served in self._maps:
            for save in [served.save] + ([served.fold_labels] if fold_labels else []):
                started = time.monotonic()
                try:
                    done, waits = save()
                    if save == served.save:
                        self._waits.pop(served.uuid, None)
                    if waits:
                        failed.append("%s: %s" % (served.target, waits))
                        self._tell_waiting(served, waits, "materials")
                    if done:
                        seconds = time.monotonic() - started
                        saved.append("saved %s to %s in %.2f s" % (done, served.target, seconds))
                except MapFileError as error:
                    failed.append("not saved: %s" % error)
                    if save == served.save:  # labels are safe in the journal
                        self._tell_waiting(served, str(error))
                    if error.code == "locked" and not served.is_saved:
                        locked.append(failed[-1])
                except MemoryError:
                    failed.append("not saved: %s: there is not enough memory" % served.target)
                    if save == served.save:
                        self._tell_waiting(served, "there is not enough memory")
            for sent in served.pending.take_stored():
                self.results.stored(served.uuid, *sent)
        failed = list(dict.fromkeys(failed))  # labels may fail for the same reason
        for line in saved:
            rospy.loginfo("%s", one_line(line))
        for line in failed:
            if line in locked:  # is tried again soon, which needs no line each time
                self._warn(line)
            else:
                rospy.logerr("%s", one_line(line))
        if locked and not self._closed:
            self._expect_more(_TRY_AGAIN)
        self.unsaved = failed
        return saved, failed

    def _tell_waiting(self, served: ServedMap, why: str, of: Optional[str] = None) -> None:
        self._waits[served.uuid] = why, file_stamp(served.target)
        for sent in served.pending.take_waiting(why, of):
            self.results.waiting(served.uuid, *sent, why)
