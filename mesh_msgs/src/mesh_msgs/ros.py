"""Latched topics that carry several messages."""

import io
import struct
import threading
import time
from collections import OrderedDict
from typing import Any, Dict, Hashable, List, Optional, Type

import rospy

_LENGTH = struct.Struct("<I")


class LatchedTopics:
    """A publisher that keeps the last message of each key and sends all to every new subscriber.

    A latched rospy.Publisher keeps one message in all: of ten cost layers, a late subscriber gets
    the last one. Here `publish("roughness", message)` replaces the message of that key alone.

    Subscribers get their messages one by one, `interval` seconds apart, so that a queue of four
    (which mesh displays of RViz have) holds whatever arrives during a stall of 4 * interval. The
    next one also waits until the one before has left for the network, so that a slow connection is
    not flooded. A key that is published again before its turn is sent once, with the newest
    message. A message to an idle subscriber is sent at once.

    Messages are serialized by publish(), in the thread of the caller, who also gets the errors;
    later changes to the message have no effect. All methods may be called from any thread.

    Two subscribers to a topic in one process share a connection; only the first gets everything.

    Args:
        name: topic.
        data_class: type of the messages: a generated class or one of mesh_msgs.arrays.
        interval: seconds between two messages to the same subscriber.
    """

    def __init__(self, name: str, data_class: Type[Any], interval: float = 0.25) -> None:
        self._interval = interval
        self._messages: "OrderedDict[Hashable, bytes]" = OrderedDict()
        self._recipients: Dict[Any, _Recipient] = {}
        self._condition = threading.Condition()
        self._sequence = 0
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
        if getattr(message, "_md5sum", None) != self._data_class._md5sum:
            shown = getattr(message, "_type", type(message).__name__)
            raise TypeError("expected a %s, got %s" % (self._data_class._type, shown))
        with self._condition:
            if self._closed:
                raise rospy.ROSException("publish() after unregister()")
            self._messages[key] = self._frozen(message)
            self._find_recipients()
            for recipient in self._recipients.values():
                recipient.want(key)
            self._condition.notify_all()

    def remove(self, key: Hashable) -> None:
        """Forgets the message of `key`, if there is one; subscribers are not told."""
        with self._condition:
            self._messages.pop(key, None)

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
            self._recipients.clear()
            self._condition.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        self._publisher.unregister()

    def _frozen(self, message: Any) -> bytes:
        """The message as it goes over the wire, its length in front."""
        if message._has_header:
            self._sequence += 1
            message.header.seq = self._sequence
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
                self._condition.wait(self._send_due(time.monotonic()))

    def _find_recipients(self) -> None:
        """Compares the connections with those known: new ones want every key."""
        connections = list(self._publisher.impl.connections)
        known = self._recipients
        self._recipients = {c: known.get(c) or _Recipient(c, self._messages) for c in connections}

    def _send_due(self, now: float) -> float:
        """Sends what is due and returns the number of seconds until there may be more to do."""
        wait = 1.0  # also the longest time that the end of the node goes unnoticed
        for connection, recipient in self._recipients.items():
            pause = recipient.pause(now)
            if pause is None:
                continue
            if pause > 0.0:
                wait = min(wait, pause)
                continue
            message = recipient.next_message(self._messages)
            if message is not None:
                recipient.expect_one(now + self._interval)
                self._send(connection, message)
                wait = min(wait, self._interval)
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


class _Recipient:
    """What one subscriber is still to get, and when."""

    _POLL = 0.02  # seconds between two looks at a connection that is still writing

    def __init__(self, connection: Any, keys: Any) -> None:
        self._connection = connection
        self._keys: "OrderedDict[Hashable, None]" = OrderedDict.fromkeys(keys)
        self._written = connection.stat_num_msg
        self._not_before = 0.0

    def want(self, key: Hashable) -> None:
        """Adds a key; one that waits already keeps its place."""
        self._keys[key] = None

    def pause(self, now: float) -> Optional[float]:
        """Seconds until the next message may be sent, None if there is none."""
        if not self._keys:
            return None
        at_least = self._POLL if self._connection.stat_num_msg < self._written else 0.0
        return max(at_least, self._not_before - now)

    def next_message(self, messages: Dict[Hashable, Any]) -> Optional[Any]:
        """The message of the first key that still has one."""
        while self._keys:
            key, _ = self._keys.popitem(last=False)
            if key in messages:
                return messages[key]
        return None

    def expect_one(self, not_before: float) -> None:
        """Notes, before a message is handed to the connection, when the next one may follow."""
        self._written = self._connection.stat_num_msg + 1
        self._not_before = not_before
