"""Latched topics that carry several messages."""
import dataclasses
import io
import itertools
import struct
import threading
import time
from collections import OrderedDict, deque
from typing import Any, Callable, Deque, Dict, Hashable, List, Optional, Tuple, Type

import rospy

QUEUE = 4  # messages that subscribers hold while they are busy, as mesh displays of RViz do
INTERVAL = 0.125  # seconds for each: six layers are there soon, and 0.5 s of stall lose none

_LENGTH = struct.Struct("<I")


@dataclasses.dataclass
class _Kept:
    """A message that is kept: as it goes over the wire, or how to make it.

    data: its bytes; None before it is made.
    make_message: None afterwards.
    spare: one that was being made when this one replaced it, so that subscribers also get
        something where messages are replaced faster than they are made.
    """

    data: Optional[bytes] = None
    make_message: Optional[Callable[[], Any]] = None
    spare: Optional[bytes] = None


class _Recipient:
    """What one subscriber is still to get, and when."""

    _POLL = 0.02  # seconds between two looks at a connection that is still writing, at most

    def __init__(self, connection: Any, keys: Any) -> None:
        self._connection = connection
        self._keys: "OrderedDict[Hashable, None]" = OrderedDict.fromkeys(keys)
        self._written = connection.stat_num_msg
        self._sent: Deque[float] = deque(maxlen=QUEUE)  # when the last messages were

    def want(self, key: Hashable) -> None:
        """Adds a key; one that waits already keeps its place."""
        self._keys[key] = None

    def pause(self, now: float, interval: float) -> Optional[float]:
        """Seconds until the next message may be sent, None if there is none."""
        if not self._keys:
            return None
        at_least = 0.0
        if self._connection.stat_num_msg < self._written:
            at_least = min(self._POLL, max(0.001, 0.5 * (now - self._sent[-1])))
        if len(self._sent) < QUEUE:
            return at_least
        return max(at_least, self._sent[0] + QUEUE * interval - now)

    def first(self, messages: Dict[Hashable, _Kept]) -> Tuple[Hashable, Optional[_Kept]]:
        """The key that has waited longest, with its message; keys without one are dropped."""
        while self._keys:
            key = next(iter(self._keys))
            if key in messages:
                return key, messages[key]
            del self._keys[key]
        return None, None

    def expect_one(self, key: Hashable, now: float) -> None:
        """Notes, before the message of this key is handed to the connection, that it no longer
        waits, and when it was sent."""
        del self._keys[key]
        self._written = self._connection.stat_num_msg + 1
        self._sent.append(now)


class LatchedTopics:
    """A publisher that keeps the last message of each key and sends all to every new subscriber.

    A latched rospy.Publisher keeps one message in all: of ten cost layers, a late subscriber gets
    the last one. Here `publish("roughness", message)` replaces the message of that key alone.

    Subscribers get up to four messages at once, and each further one 4 * interval after the fourth
    before it, so that a queue of four (which mesh displays of RViz have) holds whatever arrives
    during a stall of 4 * interval, whenever that begins. Each one also waits until the one before
    has left for the network, so that a slow connection is not flooded. A key that is published
    again before its turn is sent once, with the newest message. A message to an idle subscriber is
    sent at once.

    Messages are serialized by publish(), in the thread of the caller, who also gets the errors;
    later changes to the message have no effect. `keep("roughness", make_message)` replaces what
    later subscribers get without sending anything now, and without making the message before a
    subscriber needs it; send() sends what is kept. All methods may be called from any thread.

    Two subscribers to a topic in one process share a connection; only the first gets everything.

    Args:
        name: topic.
        data_class: type of the messages: a generated class or one of mesh_msgs.arrays.
        interval: seconds that a subscriber has for a message, in the mean over four.
    """

    def __init__(self, name: str, data_class: Type[Any], interval: float = INTERVAL) -> None:
        self._interval = interval
        self._messages: "OrderedDict[Hashable, _Kept]" = OrderedDict()
        self._scheduled: Dict[Hashable, float] = {}
        self._recipients: Dict[Any, _Recipient] = {}
        self._condition = threading.Condition()
        self._sequence = itertools.count(1)
        self._closed = False
        # queue_size=0: each connection has a thread and an unlimited queue of its own, so that one
        # that has stopped reading holds up no other. The pacing puts one message at a time in it.
        self._publisher = rospy.Publisher(
            name,
            data_class,
            subscriber_listener=_Waker(self._wake),
            headers={"latching": "1"},
            queue_size=0,
        )
        self._data_class = data_class
        self._thread = threading.Thread(target=self._run, name="latched " + name, daemon=True)
        self._thread.start()

    def publish(self, key: Hashable, message: Any) -> None:
        """Sends `message` to all subscribers and keeps it for later ones under `key`.

        Raises:
            TypeError: a message of another type.
            genpy.SerializationError: a message that cannot be written; what was kept stays.
            rospy.ROSException: after unregister().
        """
        self._check_open("publish()")
        kept = _Kept(data=self._frozen(message))
        with self._condition:
            self._check_open("publish()")
            self._messages[key] = kept
            self._find_recipients()
            self._want(key)
            self._condition.notify_all()

    def keep(self, key: Hashable, make_message: Callable[[], Any]) -> None:
        """Keeps a message for later subscribers under `key`, without sending it now.

        Args:
            make_message: gives the message; called once, in a thread of its own, when the message
                is to be sent for the first time, so perhaps never. Where it gives None, nothing is
                kept under `key`; neither where it fails or gives what cannot be written, which is
                logged.
        Raises:
            rospy.ROSException: after unregister().
        """
        with self._condition:
            self._check_open("keep()")
            self._messages[key] = _Kept(make_message=make_message)
            self._condition.notify_all()

    def send(self, key: Hashable, delay: float = 0.0) -> None:
        """Sends what is kept under `key` by then to all subscribers, `delay` seconds from now.

        A key that is to be sent earlier already is sent once, then. Without anything kept there is
        nothing to send.

        Raises:
            rospy.ROSException: after unregister().
        """
        with self._condition:
            self._check_open("send()")
            due = time.monotonic() + delay
            self._scheduled[key] = min(due, self._scheduled.get(key, due))
            self._condition.notify_all()

    def remove(self, key: Hashable) -> None:
        """Forgets the message of `key`, if there is one; subscribers are not told."""
        with self._condition:
            self._messages.pop(key, None)
            self._scheduled.pop(key, None)

    def keys(self) -> List[Hashable]:
        """Keys with a message, in the order in which they are sent to a new subscriber."""
        with self._condition:
            return list(self._messages)

    def get_num_connections(self) -> int:
        """Number of subscribers."""
        with self._condition:
            return 0 if self._closed else int(self._publisher.get_num_connections())

    def unregister(self) -> None:
        """Ends the topic; what has not been sent yet is lost. Further calls have no effect."""
        with self._condition:
            if self._closed:
                return
            self._closed = True
            self._messages.clear()
            self._scheduled.clear()
            self._recipients.clear()
            self._condition.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        self._publisher.unregister()

    def _check_open(self, what: str) -> None:
        if self._closed:
            raise rospy.ROSException(what + " after unregister()")

    def _frozen(self, message: Any) -> bytes:
        """The message as it goes over the wire, its length in front."""
        if getattr(message, "_md5sum", None) != self._data_class._md5sum:
            shown = getattr(message, "_type", type(message).__name__)
            raise TypeError("expected a %s, got %s" % (self._data_class._type, shown))
        if message._has_header:
            message.header.seq = next(self._sequence)
        buffer = io.BytesIO()
        buffer.seek(_LENGTH.size)
        message.serialize(buffer)
        size = buffer.tell() - _LENGTH.size
        buffer.seek(0)
        buffer.write(_LENGTH.pack(size))
        return buffer.getvalue()

    def _wake(self) -> None:
        with self._condition:
            self._condition.notify_all()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            with self._condition:
                if self._closed:
                    return
                self._find_recipients()
                needed: Dict[Hashable, _Kept] = {}
                wait = self._send_due(time.monotonic(), needed)
                if not needed:
                    self._condition.wait(wait)
            for key, kept in needed.items():  # may take long: nobody who publishes waits for it
                self._make(key, kept)

    def _make(self, key: Hashable, kept: _Kept) -> None:
        data = None
        try:
            message = kept.make_message()
            data = None if message is None else self._frozen(message)
        except Exception as error:  # of a stranger's function; the other messages go on
            shown = " ".join(str(error).split())
            rospy.logerr("%s: no message of %s: %s", self._publisher.name, key, shown)
        with self._condition:
            current = self._messages.get(key)
            if current is not kept:
                if current is not None and current.data is None:
                    current.spare = data
            elif data is None:
                del self._messages[key]
            else:
                kept.data, kept.make_message = data, None

    def _find_recipients(self) -> None:
        """Compares the connections with those known: new ones want every key."""
        connections = list(self._publisher.impl.connections)
        known = self._recipients
        self._recipients = {c: known.get(c) or _Recipient(c, self._messages) for c in connections}

    def _want(self, key: Hashable) -> None:
        for recipient in self._recipients.values():
            recipient.want(key)

    def _send_due(self, now: float, needed: Dict[Hashable, _Kept]) -> float:
        """Sends what is due and returns the number of seconds until there may be more to do.

        What is due but has to be made first is noted in `needed`.
        """
        wait = 1.0  # also the longest time that the end of the node goes unnoticed
        for key, due in list(self._scheduled.items()):
            if due <= now:
                del self._scheduled[key]
                self._want(key)
            else:
                wait = min(wait, due - now)
        for connection, recipient in self._recipients.items():
            pause = recipient.pause(now, self._interval)
            if pause is None:
                continue
            if pause > 0.0:
                wait = min(wait, pause)
                continue
            key, kept = recipient.first(self._messages)
            if kept is None:
                continue
            data = kept.data or kept.spare
            if data is None:
                needed[key] = kept
                continue
            recipient.expect_one(key, now)
            if kept.data is None:
                kept.spare = None
                recipient.want(key)
            self._send(connection, data)
            wait = 0.0  # there may be another one that may follow at once
        return wait

    @staticmethod
    def _send(connection: Any, message: bytes) -> None:
        """Hands the kept bytes themselves to the connection, as rospy's publish() does a copy.

        A connection holds on to the last message it has sent: with a copy, each subscriber of a
        large mesh would cost as much memory as the mesh.
        """
        try:
            connection.write_data(message)
        except Exception as error:  # whatever the transport met, as rospy's publish()
            rospy.logdebug("connection to %s ended: %s", connection.endpoint_id, error)
            connection.close()


class _Waker(rospy.SubscribeListener):
    """Tells that a subscriber came."""

    def __init__(self, wake: Any) -> None:
        super().__init__()
        self._wake = wake

    def peer_subscribe(self, topic_name: str, topic_publish: Any, peer_publish: Any) -> None:
        self._wake()
