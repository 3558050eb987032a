"""What tests on a running ROS wait for."""

import re
from typing import Any, List, Optional
from xmlrpc.client import ServerProxy

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from mesh_msgs.testing import wait_until

# in what getBusInfo of ROS's Slave API tells of a connection
_DESTINATION, _DIRECTION, _TOPIC, _TRANSPORT = 1, 2, 4, 6
_REMOTE_PORT = re.compile(r" to \[.*:(\d+) on socket ")  # as roscpp and rospy write it


def connected(*ends: Any) -> bool:
    """Whether each rospy.Publisher has a subscriber, and each rospy.Subscriber a publisher that
    sends to it: then no message is lost that is published from now on.

    Subscriber.get_num_connections() tells less: a publisher answers to a new subscriber before it
    begins to send to it.
    """
    return all(
        _is_sent_to(end) if isinstance(end, rospy.Subscriber) else end.get_num_connections() > 0
        for end in ends
    )


def _is_sent_to(subscriber: rospy.Subscriber) -> bool:
    connections = list(subscriber.impl.connections)
    return bool(connections) and all(
        _sends(connection.endpoint_id, subscriber.resolved_name, connection.local_endpoint[1])
        for connection in connections
    )


def _sends(publisher: str, topic: str, port: int) -> bool:
    """Whether the node at this URI sends a topic to the node of this process on this port: it may
    still have the connection of a subscriber to the same topic that has gone.
    """
    name = rospy.get_name()
    try:
        code, _, infos = ServerProxy(publisher).getBusInfo(name)
    except OSError:  # it has ended
        return False
    return code == 1 and any(
        info[_TOPIC] == topic
        and info[_DESTINATION] == name
        and info[_DIRECTION] == "o"
        and _REMOTE_PORT.findall(info[_TRANSPORT]) == [str(port)]
        for info in infos
    )


class HeardDiagnostics:
    """What nodes tell on /diagnostics, from now on."""

    def __init__(self) -> None:
        self._heard: List[DiagnosticArray] = []
        self._subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, self._heard.append)

    def expected(self, name: str, level: int, words: str) -> DiagnosticStatus:
        """The first status of this name and level, and with these words in its message.

        Raises:
            AssertionError: it has not come within a minute.
        """
        return wait_until(lambda: self._found(name, level, words), "%s: %s" % (name, words))

    def unregister(self) -> None:
        """Listens no more."""
        self._subscriber.unregister()

    def _found(self, name: str, level: int, words: str) -> Optional[DiagnosticStatus]:
        parts = (one for message in list(self._heard) for one in message.status)
        fitting = (one for one in parts if (one.name, one.level) == (name, level))
        return next((one for one in fitting if words in one.message), None)
