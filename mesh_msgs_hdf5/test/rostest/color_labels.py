#!/usr/bin/python3
"""Colors of labels over ROS: both nodes, late subscribers, an owner elsewhere, errors."""
import os
import shutil
import signal
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from mesh_msgs.msg import MeshFaceCluster, MeshFaceClusterStamped, MeshLabelColors
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected
from mesh_msgs.srv import DeleteLabel, GetLabelColors, SetLabelColor
from server_process import Publishers, Server
from std_msgs.msg import ColorRGBA

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh

FACES = 50
RNG = np.random.default_rng(4)
MESH = Mesh(
    RNG.random((40, 3)).astype(np.float32),
    RNG.integers(0, 40, (FACES, 3)).astype(np.uint32),
    labels={
        "tree_1": Label(np.uint32([1, 2]), (255, 0, 51)),
        "tree_2": Label(np.uint32([3])),
        "wall_1": Label(np.uint32([4])),
    },
)


def colors_of(answer):
    """label -> bytes, of a message or an answer."""
    assert len(answer.labels) == len(answer.colors)
    assert all(color.a == 1.0 for color in answer.colors)
    return {
        label: tuple(int(round(255 * part)) for part in (color.r, color.g, color.b))
        for label, color in zip(answer.labels, answer.colors)
    }


def rgba(red, green, blue, alpha=1.0):
    return ColorRGBA(red / 255.0, green / 255.0, blue / 255.0, alpha)


class Colors(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.path = os.path.join(self.folder, "a.h5")
        self.uuid = MapFile.write(self.path, MESH).uuid
        self.servers = []

    def tearDown(self):
        for server in self.servers:
            server.ask_to_stop()
        for server in self.servers:
            server.stop()
        shutil.rmtree(self.folder)

    def start(self, namespace):
        self.servers.append(Server(namespace, inputFile=self.path))
        return self.servers[-1]

    def listen(self, topic, kind):
        found = []
        subscriber = rospy.Subscriber(topic, kind, found.append, queue_size=10)
        self.addCleanup(subscriber.unregister)
        wait_until(lambda: connected(subscriber), "a publisher of " + topic)
        return found

    def refused(self, server, *arguments):
        with self.assertRaises(rospy.ServiceException) as refused:
            server.call("set_label_color", SetLabelColor, *arguments)
        return str(refused.exception)

    def check_all(self, server, prefix, expected):
        """Service and late subscriber tell the same."""
        self.assertEqual(
            colors_of(server.call(prefix + "get_label_colors", GetLabelColors, "")), expected
        )
        topic = "%s/%slabel_colors" % (server.namespace, prefix)
        found = []
        subscriber = rospy.Subscriber(topic, MeshLabelColors, found.append, queue_size=4)
        wait_until(
            lambda: found and colors_of(found[-1]) == expected, "%s on %s" % (expected, topic)
        )
        subscriber.unregister()
        self.assertEqual(found[-1].uuid, self.uuid)

    def test_colors_are_told_set_taken_away_and_saved(self):
        server = self.start("/colors")
        expected = {"tree_1": (255, 0, 51)}
        self.check_all(server, "", expected)
        live = self.listen("/colors/label_colors", MeshLabelColors)
        clusters = self.listen("/colors/new_cluster_label", MeshFaceCluster)
        for label, color in (("tree_2", (1, 2, 3)), ("wall_1", (0, 0, 0)), ("tree_1", (7, 8, 9))):
            server.call("set_label_color", SetLabelColor, "mesh", label, rgba(*color))
            expected[label] = color
            wait_until(lambda: live and colors_of(live[-1]) == expected, "the color of " + label)
        server.call("set_label_color", SetLabelColor, self.uuid, "wall_1", rgba(5, 5, 5, 0.0))
        del expected["wall_1"]
        self.check_all(server, "", expected)
        # a label that is labeled anew keeps its color
        publishers = Publishers()
        message = MeshFaceClusterStamped(uuid=self.uuid, override=True)
        message.cluster = MeshFaceCluster(face_indices=[9], label="tree_1")
        publishers.send("/colors/cluster_label", message)
        wait_until(lambda: clusters, "the label")
        self.check_all(server, "", expected)
        # a deleted label has neither faces nor a color
        server.call("delete_label", DeleteLabel, self.uuid, "tree_2")
        del expected["tree_2"]
        wait_until(lambda: clusters[-1].label == "tree_2", "the deleted label")
        self.assertEqual(list(clusters[-1].face_indices), [])
        wait_until(lambda: colors_of(live[-1]) == expected, "the colors without it")
        self.assertEqual(server.stop(), 0)
        labels = MapFile(self.path).labels()
        found = {text: label.color for text, label in labels.items()}
        self.assertEqual(found, {"tree_1": (7, 8, 9), "wall_1": None})
        self.assertEqual(labels["tree_1"].faces.tolist(), [9])

    def test_a_color_that_was_answered_survives_the_death_of_the_server(self):
        killed = self.start("/killed")
        killed.call("set_label_color", SetLabelColor, "", "tree_2", rgba(1, 2, 3))
        killed.call("set_label_color", SetLabelColor, "", "tree_1", rgba(0, 0, 0, 0.0))
        self.assertEqual(killed.stop(signal.SIGKILL), -signal.SIGKILL)
        self.assertEqual(MapFile(self.path).labels()["tree_2"].color, None)
        server = self.start("/survivor")
        self.check_all(server, "", {"tree_2": (1, 2, 3)})
        self.assertEqual(server.stop(), 0)
        self.assertEqual(MapFile(self.path).labels()["tree_2"].color, (1, 2, 3))

    def test_a_server_that_is_to_change_nothing_refuses(self):
        self.servers.append(Server("/fixed", inputFile=self.path, read_only=True))
        server = self.servers[-1]
        self.assertIn("read only", self.refused(server, "", "tree_1", rgba(1, 2, 3)))
        self.check_all(server, "", {"tree_1": (255, 0, 51)})

    def test_what_is_wrong_is_an_error_and_changes_nothing(self):
        server = self.start("/wrong")
        self.assertIn("did you mean", self.refused(server, "", "tre_1", rgba(1, 2, 3)))
        self.assertIn(self.uuid, self.refused(server, "another", "tree_1", rgba(1, 2, 3)))
        for bad in (
            ColorRGBA(1.5, 0, 0, 1),
            ColorRGBA(0, float("nan"), 0, 1),
            ColorRGBA(0, 0, 0, -1),
        ):
            self.assertIn("from 0 to 1", self.refused(server, "", "tree_1", bad))
        self.check_all(server, "", {"tree_1": (255, 0, 51)})

    def test_the_owner_of_the_labels_is_asked_to_set_a_color(self):
        owner, other = self.start("/owner"), self.start("/other")
        other.call("set_label_color", SetLabelColor, "", "tree_2", rgba(1, 2, 3))
        expected = {"tree_1": (255, 0, 51), "tree_2": (1, 2, 3)}
        self.check_all(owner, "", expected)
        self.check_all(other, "", expected)
        owner.stop()  # the other one is the owner from now on
        other.call("set_label_color", SetLabelColor, "", "tree_1", rgba(0, 0, 0, 0.0))
        self.check_all(other, "", {"tree_2": (1, 2, 3)})

    def test_label_manager_offers_the_same(self):
        folder = os.path.join(self.folder, "labels")
        manager = Server(
            "/managed",
            executable="label_manager",
            ready="label_manager/set_label_color",
            map_file=self.path,
            folder_path=folder,
        )
        self.servers.append(manager)
        self.check_all(manager, "label_manager/", {"tree_1": (255, 0, 51)})
        manager.call("label_manager/set_label_color", SetLabelColor, "", "wall_1", rgba(1, 2, 3))
        expected = {"tree_1": (255, 0, 51), "wall_1": (1, 2, 3)}
        self.check_all(manager, "label_manager/", expected)


if __name__ == "__main__":
    rospy.init_node("color_labels")
    rostest.rosrun("mesh_msgs_hdf5", "color_labels", Colors)
