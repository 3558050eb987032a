#!/usr/bin/python3
"""Array messages over real connections, with the generated classes at the other end.

The other end is a process of its own, as usual among nodes: this file again, with the argument
"peer".
"""

import subprocess
import sys
import threading
import unittest

import numpy as np
import rospy

import mesh_msgs.msg
import mesh_msgs.srv
from mesh_msgs import array_services, arrays
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected

COUNT = 1001
TIMEOUT = 20.0  # seconds; only reached when something is broken


def geometry(cls=arrays.MeshGeometryStamped):
    """A message with odd sizes and text beyond ASCII, in the array class."""
    random = np.random.default_rng(0)
    message = cls(uuid="größe")
    message.header.frame_id = "map"
    message.header.stamp = rospy.Time(12, 34)
    message.mesh_geometry = arrays.MeshGeometry(
        random.random((COUNT, 3)), random.random((COUNT, 3)), random.integers(0, COUNT, (COUNT, 3))
    )
    return message


def same(received):
    """Whether a message of either class is the geometry of above, but for the sequence number."""
    ours = arrays.MeshGeometryStamped.from_message(received)
    ours.header.seq = 0
    return ours == geometry()


def peer():
    """Uses generated classes alone: sends what arrives back, offers and calls services."""
    rospy.init_node("peer", anonymous=True)
    publisher = rospy.Publisher(
        "from_stock", mesh_msgs.msg.MeshGeometryStamped, queue_size=1, latch=True
    )
    kept = []

    def echo(message):
        assert type(message.mesh_geometry.vertices) is list
        kept.append(message)
        publisher.publish(message)

    def ask(_request):
        call = rospy.ServiceProxy("geometry_of_arrays", mesh_msgs.srv.GetGeometry)
        response = call(uuid="größe").mesh_geometry_stamped
        assert type(response.mesh_geometry.faces) is list
        return mesh_msgs.srv.GetUUIDResponse("same" if same(response) else "different")

    rospy.Subscriber("to_stock", mesh_msgs.msg.MeshGeometryStamped, echo, queue_size=1)
    rospy.Service("ask", mesh_msgs.srv.GetUUID, ask)
    rospy.Service(
        "geometry_of_stock",
        mesh_msgs.srv.GetGeometry,
        lambda _: mesh_msgs.srv.GetGeometryResponse(kept[-1]),
    )
    rospy.spin()


class ArraysOverRos(unittest.TestCase):
    """Publisher and subscriber, service and client."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("arrays_over_ros")
        cls.peer = subprocess.Popen([sys.executable, __file__, "peer"])

    @classmethod
    def tearDownClass(cls):
        cls.peer.terminate()
        cls.peer.wait(TIMEOUT)

    def received(self, name, data_class):
        return rospy.wait_for_message(name, data_class, TIMEOUT)

    def test_messages_reach_a_stock_subscriber_and_come_back_from_a_stock_publisher(self):
        for data_class in (mesh_msgs.msg.MeshGeometryStamped, arrays.MeshGeometryStamped):
            publisher = rospy.Publisher("to_stock", data_class, queue_size=1, latch=True)
            publisher.publish(geometry())
            message = self.received("from_stock", arrays.MeshGeometryStamped)
            self.assertIs(type(message), arrays.MeshGeometryStamped)
            self.assertIsInstance(message.mesh_geometry.vertices, np.ndarray)
            self.assertTrue(same(message))
            publisher.unregister()

    def test_services_with_arrays_at_either_end(self):
        def answer(request):
            self.assertEqual(request.uuid, "größe")
            return array_services.GetGeometryResponse(mesh_geometry_stamped=geometry())

        service = rospy.Service("geometry_of_arrays", array_services.GetGeometry, answer)
        rospy.wait_for_service("ask", TIMEOUT)
        self.assertEqual(rospy.ServiceProxy("ask", mesh_msgs.srv.GetUUID)().uuid, "same")
        service.shutdown()

        publisher = rospy.Publisher(
            "to_stock", arrays.MeshGeometryStamped, queue_size=1, latch=True
        )
        publisher.publish(geometry())
        self.received("from_stock", arrays.MeshGeometryStamped)
        call = rospy.ServiceProxy("geometry_of_stock", array_services.GetGeometry)
        message = call(uuid="").mesh_geometry_stamped
        self.assertIsInstance(message.mesh_geometry.faces, np.ndarray)
        self.assertTrue(same(message))
        publisher.unregister()

    def test_command_line_tools_understand_the_topic(self):
        publisher = rospy.Publisher("costs", arrays.MeshVertexCosts, queue_size=1, latch=True)
        publisher.publish(arrays.MeshVertexCosts(costs=[0.5, np.nan, np.inf]))
        command = ["rostopic", "echo", "-n1", "costs"]
        shown = subprocess.run(command, stdout=subprocess.PIPE, timeout=TIMEOUT, check=True)
        self.assertEqual(shown.stdout.decode().split("\n")[0], "costs: [0.5, nan, inf]")
        publisher.unregister()

    def test_connected_means_that_the_publisher_sends(self):
        """rospy counts a connection that the publisher has answered, but does not know of yet."""
        publisher = rospy.Publisher("held_up", arrays.MeshGeometryStamped, queue_size=1)
        go_on, add = threading.Event(), publisher.impl.add_connection
        publisher.impl.add_connection = lambda connection: go_on.wait(TIMEOUT) and add(connection)
        # who goes is noticed here with the next one that comes, as by a node with no subscriber
        publisher.impl.check = lambda: None
        arrived = threading.Event()

        def subscribed():
            subscriber = rospy.Subscriber(
                "held_up", arrays.MeshGeometryStamped, lambda _message: arrived.set()
            )
            self.until(subscriber.get_num_connections)
            self.assertFalse(connected(subscriber) or connected(publisher, subscriber))
            go_on.set()
            self.until(lambda: connected(publisher, subscriber))
            publisher.publish(geometry())
            self.assertTrue(arrived.wait(TIMEOUT))
            return subscriber

        subscribed().unregister()
        go_on.clear()
        arrived.clear()
        subscriber = subscribed()  # the publisher has not noticed yet that the first one is gone
        publisher.unregister()
        self.until(lambda: not connected(subscriber))
        subscriber.unregister()

    def until(self, condition):
        wait_until(condition, "a change", TIMEOUT)

    def test_a_damaged_message_ends_neither_the_node_nor_other_connections(self):
        got, arrived = [], threading.Event()

        def keep(message):
            got.append(message)
            arrived.set()

        damaging = rospy.Publisher("from_stock", arrays.MeshGeometryStamped, queue_size=1)
        subscriber = rospy.Subscriber("from_stock", arrays.MeshGeometryStamped, keep)
        self.until(lambda: connected(damaging))
        arrived.wait(0.5)  # what the peer has latched from another test
        arrived.clear()
        before = len(got)
        damaged = rospy.AnyMsg()
        damaged._buff = b"\xff" * 100
        damaging.publish(damaged)
        publisher = rospy.Publisher(
            "to_stock", arrays.MeshGeometryStamped, queue_size=1, latch=True
        )
        publisher.publish(geometry())
        self.assertTrue(arrived.wait(TIMEOUT))
        self.assertEqual(len(got), before + 1)
        self.assertTrue(same(got[-1]))
        for topic in (subscriber, damaging, publisher):
            topic.unregister()


if __name__ == "__main__":
    if sys.argv[1:] == ["peer"]:
        peer()
    else:
        import rostest

        rostest.rosrun("mesh_msgs", "arrays_over_ros", ArraysOverRos)
