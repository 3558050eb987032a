"""A node mesh_map in a process of its own, and subscribers, for tests on a running ROS."""

import os
import subprocess
from pathlib import Path

import roslib.packages
import rospy
from mesh_msgs import arrays
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected

WAIT = 60.0  # seconds; far more than anything takes
STRANGE = Path(__file__).resolve().parent / "strange_layers"


class Subscriber:
    """Keeps what it gets.

    messages: all, in order; newest: by their type or ns.
    """

    def __init__(self, topic, kind, queue_size=None):
        self.messages, self.newest = [], {}
        self._subscriber = rospy.Subscriber(topic, kind, self._receive, queue_size=queue_size)

    def _receive(self, message):
        key = getattr(message, "type", "") if hasattr(message, "uuid") else ""
        self.newest[getattr(message, "ns", key)] = message
        self.messages.append(message)

    def connected(self):
        """Whether there is a publisher that sends to it, waited for."""
        return wait_until(lambda: connected(self._subscriber))

    def unregister(self):
        self._subscriber.unregister()


def costs_of(topic):
    """A subscriber to costs as RViz has it: with a queue of four."""
    return Subscriber(topic, arrays.MeshVertexCostsStamped, queue_size=4)


def start_node(test, name, **parameters):
    """Starts a node with these parameters, which knows the layers of strange_layers.

    The test case tells it to end, and the class waits for that: nodes take half a second for it, in
    which the next one starts. So each needs a name of its own. It may take its time to end.
    """
    rospy.set_param("/" + name, {"shutdown_timeout": WAIT, **parameters})
    executable = roslib.packages.find_node("mesh_map", "mesh_map")[0]
    environment = dict(os.environ)
    environment["ROS_PACKAGE_PATH"] = "%s:%s" % (STRANGE, environment["ROS_PACKAGE_PATH"])
    environment["PYTHONPATH"] = "%s:%s" % (STRANGE / "src", environment["PYTHONPATH"])
    node = subprocess.Popen(
        [executable, "__name:=" + name],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        universal_newlines=True,
    )
    test.addClassCleanup(node.stdout.close)
    test.addClassCleanup(node.wait, WAIT)
    test.addCleanup(node.terminate)
    return node


def end_node(node):
    """Ends it; returns what it has printed."""
    node.terminate()
    return node.communicate(timeout=WAIT)[0]
