"""A running hdf5_map_server for the rostests, each in a namespace of its own."""
import functools
import os
import signal
import subprocess
import threading
import time

import roslib.packages
import rospy
from mesh_msgs.testing import wait_until

TIMEOUT = 30.0  # seconds; only reached when something is broken


@functools.lru_cache(maxsize=None)
def program(executable):
    """Where rosrun finds it; rosrun itself looks for it anew each time, which takes 0.3 s."""
    (path, *_) = roslib.packages.find_node("mesh_msgs_hdf5", executable)
    return path


def command(*arguments, name="hdf5_map_server", executable="hdf5_map_server"):
    return [program(executable), "__name:=" + name, *arguments]


class Server:
    """A node; lines is what it has logged so far."""

    def __init__(
        self,
        namespace,
        *arguments,
        executable="hdf5_map_server",
        ready="save_map",
        **parameters,
    ):
        """ready: the service that tells that it is up."""
        self.namespace = namespace
        for name, value in parameters.items():
            rospy.set_param("%s/%s/%s" % (namespace, executable, name), value)
        environment = dict(
            os.environ,
            ROS_NAMESPACE=namespace,
            PYTHONUNBUFFERED="1",
            ROSCONSOLE_STDOUT_LINE_BUFFERED="1",
        )
        self.lines = []
        self._asked = False
        self.process = subprocess.Popen(
            command(*arguments, name=executable, executable=executable),
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        try:
            rospy.wait_for_service(namespace + "/" + ready, TIMEOUT)
        except rospy.ROSException as error:
            raise AssertionError("%s; its log:\n%s" % (error, "\n".join(self.lines))) from error

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(line.decode("utf-8", "replace").rstrip())

    def logged(self, words):
        """Lines with these words."""
        return [line for line in self.lines if words in line]

    def wait_for(self, words):
        """The first line with these words: what a client sees may come before its log line."""
        return wait_until(lambda: self.logged(words), "%r in the log" % words)[0]

    def call(self, name, kind, *arguments):
        return rospy.ServiceProxy(self.namespace + "/" + name, kind)(*arguments)

    def ask_to_stop(self, number=signal.SIGTERM):
        """Send it a signal, once; stop() waits for its end."""
        if self.process.poll() is None and not self._asked:
            self._asked = True
            self.process.send_signal(number)

    def stop(self, number=signal.SIGTERM):
        """End it; returns the exit code."""
        if not self._asked or number == signal.SIGKILL:
            self._asked = False
            self.ask_to_stop(number)
        code = self.process.wait(TIMEOUT)
        self._thread.join(TIMEOUT)
        self.process.stdout.close()
        return code


def received(topic, kind, count, queue_size=4):
    """Messages that a late subscriber gets, and whether there are more than count."""
    found = []
    subscriber = rospy.Subscriber(topic, kind, found.append, queue_size=queue_size)
    wait_until(lambda: len(found) >= count, "%d messages on %s" % (count, topic))
    time.sleep(0.3)  # whether there are more
    subscriber.unregister()
    return found


class Publishers:
    """Publishers to the topics of servers; each is there before its first message goes."""

    def __init__(self):
        self._publishers = {}

    def send(self, topic, message):
        if topic not in self._publishers:
            kind = type(message)
            self._publishers[topic] = rospy.Publisher(topic, kind, queue_size=10)
        publisher = self._publishers[topic]
        wait_until(publisher.get_num_connections, "a subscriber of " + topic)
        publisher.publish(message)
