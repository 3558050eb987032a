#!/usr/bin/python3
"""The node label_manager over ROS, with the generated classes of its clients."""
import os
import shutil
import subprocess
import tempfile
import threading
import unittest

import numpy as np
import rospy
import rostest
from mesh_msgs.diagnostics_ros import OK
from mesh_msgs.msg import MeshFaceCluster, MeshFaceClusterStamped
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics, connected
from mesh_msgs.srv import DeleteLabel, GetLabelGroups, GetLabeledClusterGroup, GetLabeledClusters
from server_process import command
from std_srvs.srv import Trigger

from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh

FACES = 300
RNG = np.random.default_rng(3)
MESH = Mesh(
    RNG.random((200, 3)).astype(np.float32),
    RNG.integers(0, 200, (FACES, 3)).astype(np.uint32),
    labels={"tree_1": Label(np.uint32([1, 2]), (9, 8, 7)), "treehouse_1": Label(np.uint32([3]))},
)
STRANGER = "7f3c1f1e-1111-4222-8333-444455556666"


def faces_of(clusters):
    return {cluster.label: list(cluster.face_indices) for cluster in clusters}


class Manager:
    """A running label_manager."""

    def __init__(self, name, *arguments):
        self.name = "/" + name
        if rospy.has_param(self.name):  # of a test before
            rospy.delete_param(self.name)
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            command(*arguments, name=name, executable="label_manager"),
            stdout=self.log,
            stderr=subprocess.STDOUT,
        )
        self.wait()

    def wait(self):
        rospy.wait_for_service(self.name + "/set_label_color", 60)  # the last one of the node

    def call(self, name, kind, *arguments):
        return rospy.ServiceProxy(self.name + "/" + name, kind)(*arguments)

    def clusters(self, uuid=""):
        return faces_of(self.call("get_labeled_clusters", GetLabeledClusters, uuid).clusters)

    def logged(self):
        return os.pread(self.log.fileno(), 1 << 20, 0)  # the node's place in the file stays

    def stop(self):
        self.process.terminate()
        code = self.process.wait(30)
        self.text = self.logged().decode()
        self.log.close()
        return code


def end(process):
    """What a test that failed has left."""
    if process.poll() is None:
        process.kill()
        process.wait(30)


class Labels(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.map = os.path.join(self.folder, "a.h5")
        self.labels = os.path.join(self.folder, "deep", "labels")
        self.uuid = MapFile.write(self.map, MESH).uuid
        self.managers = []
        self.publishers = {}

    def tearDown(self):
        for manager in self.managers:
            if manager.process.poll() is None:
                manager.stop()
        for publisher in self.publishers.values():
            publisher.unregister()
        shutil.rmtree(self.folder)

    def start(self, name, *arguments):
        manager = Manager(name, "_folder_path:=" + self.labels, *arguments)
        self.managers.append(manager)
        return manager

    def publish(self, manager, text, faces, override=True, uuid=None, topic=None):
        """Send a cluster, and wait for the one that comes back."""
        topic = topic or manager.name + "/cluster_label"
        if topic not in self.publishers:
            self.publishers[topic] = rospy.Publisher(topic, MeshFaceClusterStamped, queue_size=10)
        publisher = self.publishers[topic]
        found, done = [], threading.Event()

        def take(message):
            if message.label == text:
                found.append(message)
                done.set()

        subscriber = rospy.Subscriber(manager.name + "/new_cluster_label", MeshFaceCluster, take)
        self.until(lambda: connected(subscriber) and self.is_heard(publisher, manager))
        message = MeshFaceClusterStamped(uuid=self.uuid if uuid is None else uuid)
        message.override = override
        message.cluster = MeshFaceCluster(face_indices=list(faces), label=text)
        publisher.publish(message)
        self.assertTrue(done.wait(20), "label %s did not come back" % text)
        subscriber.unregister()
        self.assertEqual(list(found[0].face_indices), list(faces))

    def is_heard(self, publisher, manager):
        """By this one and, on the topic of all, by every other that runs."""
        everyone = [m for m in self.managers if m.process.poll() is None]
        wanted = everyone if publisher.name == "/cluster_label" else [manager]
        return {m.name for m in wanted} <= {c.endpoint_id for c in publisher.impl.connections}

    def until(self, condition):
        wait_until(condition, "a change", 20)

    def refused(self, manager, *call):
        with self.assertRaises(rospy.ServiceException) as refused:
            manager.call(*call)
        return str(refused.exception)

    def test_labels_of_a_map(self):
        diagnostics = HeardDiagnostics()
        manager = self.start("one", "_map_file:=" + self.map)
        diagnostics.expected("one: labels", OK, "maps with labels: 1")
        self.assertEqual(manager.clusters(), {"tree_1": [1, 2], "treehouse_1": [3]})
        self.publish(manager, "tree_1", [5, 4, 5], override=False)
        self.publish(manager, "tree_2", range(100, 300), uuid="mesh")
        expected = {
            "tree_1": [1, 2, 4, 5],
            "tree_2": list(range(100, 300)),
            "treehouse_1": [3],
        }
        for uuid in (self.uuid, "", "mesh"):
            self.assertEqual(manager.clusters(uuid), expected)
        groups = manager.call("get_label_groups", GetLabelGroups, self.uuid).labels
        self.assertEqual(groups, ["tree", "treehouse"])
        group = manager.call("get_labeled_cluster_group", GetLabeledClusterGroup, "", "tree")
        self.assertEqual(sorted(faces_of(group.clusters)), ["tree_1", "tree_2"])  # defect 10
        deleted = manager.call("delete_label", DeleteLabel, self.uuid, "tree_1").cluster
        self.assertEqual((deleted.label, list(deleted.face_indices)), ("tree_1", [1, 2, 4, 5]))
        self.assertIn(
            "did you mean", self.refused(manager, "delete_label", DeleteLabel, "", "tre_2")
        )
        self.publish(manager, "treehouse_1", [])  # defect 10: this did not clear
        del expected["tree_1"]
        expected["treehouse_1"] = []
        self.assertEqual(manager.clusters(), expected)
        self.assertNotEqual(sorted(MapFile(self.map).labels()), sorted(expected))
        answer = manager.call("save_map", Trigger)
        self.assertTrue(answer.success)
        self.assertIn("3 labels saved to " + self.map, answer.message)
        self.assertEqual(sorted(MapFile(self.map).labels()), sorted(expected))
        self.assertEqual(manager.call("save_map", Trigger).message, "no changes")
        self.publish(manager, "late_1", [7])
        self.assertEqual(manager.stop(), 0)
        self.assertEqual(MapFile(self.map).label("late_1").faces.tolist(), [7])
        self.assertEqual(os.listdir(self.folder), ["a.h5"])

    def test_a_label_that_came_back_is_there_after_a_kill(self):
        manager = self.start("one", "_map_file:=" + self.map)
        self.publish(manager, "tree_1", [9])
        self.publish(manager, "new_1", range(FACES))
        os.kill(LabelStore(self.map, read_only=True).owner["pid"], 9)
        manager.process.wait(20)
        again = self.start("two", "_inputFile:=" + self.map)
        expected = {"new_1": list(range(FACES)), "tree_1": [9], "treehouse_1": [3]}
        self.assertEqual(again.clusters(), expected)
        again.stop()
        self.assertIn("2 label edits", again.text)
        found = MapFile(self.map).labels()
        self.assertEqual({text: label.faces.tolist() for text, label in found.items()}, expected)
        self.assertEqual(found["tree_1"].color, (9, 8, 7))

    def test_what_is_unknown_is_an_error(self):
        manager = self.start("one", "_map_file:=" + self.map)
        for name, kind, arguments in (
            ("get_labeled_clusters", GetLabeledClusters, ()),
            ("get_label_groups", GetLabelGroups, ()),
            ("get_labeled_cluster_group", GetLabeledClusterGroup, ("tree",)),
            ("delete_label", DeleteLabel, ("tree_1",)),
        ):
            self.assertIn(self.uuid, self.refused(manager, name, kind, STRANGER, *arguments))
        topic = rospy.Publisher("/one/cluster_label", MeshFaceClusterStamped, queue_size=10)
        self.until(topic.get_num_connections)
        for text, faces in (("a/b", [1]), ("", [1]), ("bad_1", [FACES]), ("../x_1", [1])):
            message = MeshFaceClusterStamped(uuid=self.uuid)
            message.cluster = MeshFaceCluster(face_indices=faces, label=text)
            for _ in range(3):
                topic.publish(message)
        self.publish(manager, "good_1", [1])
        topic.unregister()
        self.assertEqual(sorted(manager.clusters()), ["good_1", "tree_1", "treehouse_1"])
        manager.stop()
        self.assertEqual(manager.text.count("face 300"), 1)  # one line each, however many come
        self.assertEqual(manager.text.count("label not stored"), 4)

    def test_without_a_map_labels_are_kept_as_ever(self):
        """Also those of the topic of the tool in RViz, which never reached it (defect 34)."""
        manager = self.start("one")
        self.publish(manager, "tree_1", [5, 3], uuid=STRANGER)
        self.publish(manager, "tree_1", [9], uuid=STRANGER, override=False, topic="/cluster_label")
        self.assertEqual(manager.clusters(STRANGER), {"tree_1": [3, 5, 9]})  # defect 8: no face 0
        deleted = manager.call("delete_label", DeleteLabel, STRANGER, "tree_1").cluster
        self.assertEqual(list(deleted.face_indices), [3, 5, 9])  # defect 9: this was empty
        self.publish(manager, "rock_1", [4], uuid=STRANGER)
        self.publish(manager, "tree_7", [1], uuid=self.uuid)
        self.assertIn(STRANGER, self.refused(manager, "get_label_groups", GetLabelGroups, "x"))
        self.assertEqual(manager.stop(), 0)
        again = self.start("two", "_map_file:=" + self.map)
        self.assertEqual(again.clusters(STRANGER), {"rock_1": [4]})
        self.assertEqual(again.clusters()["tree_7"], [1])  # moved into the map of that UUID

    def test_old_labels_are_imported_on_request(self):
        old = os.path.join(self.folder, "old")
        os.makedirs(os.path.join(old, self.uuid))
        with open(os.path.join(old, self.uuid, "bush_1.dat"), "wb") as stream:
            stream.write(b",7,5")
        manager = self.start("one", "_map_file:=" + self.map, "_import_folder:=" + old)
        self.assertEqual(manager.clusters()["bush_1"], [5, 7])
        with open(os.path.join(old, self.uuid, "bush_2.dat"), "wb") as stream:
            stream.write(b"8")
        answer = manager.call("import_labels", Trigger)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(manager.clusters()["bush_2"], [8])

    def test_old_labels_are_there_as_the_released_launch_file_has_it(self):
        old = os.path.join(self.labels, STRANGER)
        os.makedirs(old)
        with open(os.path.join(old, "tree_1.dat"), "wb") as file:
            file.write(b",5,3")
        manager = self.start("one")
        self.assertEqual(manager.clusters(STRANGER), {"tree_1": [3, 5]})
        self.assertEqual(
            manager.call("get_label_groups", GetLabelGroups, STRANGER).labels, ["tree"]
        )
        answer = manager.call("delete_label", DeleteLabel, STRANGER, "tree_1")
        self.assertEqual(list(answer.cluster.face_indices), [3, 5])
        manager.stop()
        manager = self.start("two")
        self.assertEqual(manager.clusters(STRANGER), {})
        manager.stop()
        self.assertEqual(os.listdir(old), ["tree_1.dat"])

    def test_labels_of_a_map_with_another_owner_are_sent_there(self):
        owner = self.start("owner", "_map_file:=" + self.map)
        other = self.start("other", "_map_file:=" + self.map)
        self.publish(other, "a_1", [1, 2])
        self.publish(other, "a_1", [3], override=False)
        self.publish(other, "b_1", [4], topic="/cluster_label")  # both hear that
        self.publish(owner, "c_1", [5])
        expected = {"a_1": [1, 2, 3], "b_1": [4], "c_1": [5], "tree_1": [1, 2], "treehouse_1": [3]}
        for manager in (owner, other):
            self.until(lambda m=manager: m.clusters() == expected)
        deleted = other.call("delete_label", DeleteLabel, "", "a_1").cluster
        self.assertEqual(list(deleted.face_indices), [1, 2, 3])
        self.assertIn("no label", self.refused(other, "delete_label", DeleteLabel, "", "zzz"))
        del expected["a_1"]
        self.assertEqual(other.clusters(), expected)
        owner.stop()
        self.publish(other, "d_1", [6])  # it is the owner now
        self.assertEqual(other.stop(), 0)
        self.assertIn("edited by /owner", other.text)
        self.assertEqual(sorted(MapFile(self.map).labels()), sorted([*expected, "d_1"]))
        self.assertEqual(os.listdir(self.folder), ["a.h5"])

    def test_an_owner_that_cannot_be_reached_is_named(self):
        here = {"run_id": rospy.get_param("/run_id"), "master": "http://by-another-name:11311"}
        nobody = {"cluster_topic": "/nobody/cluster_label", "delete_service": "/nobody/delete"}
        manager = None  # one for all: it follows whoever is the owner
        for info, words in (
            ({"program": "mesh_tool"}, "is not on this roscore"),
            ({"node": "/x", "master": "http://elsewhere:11311", **nobody}, "not on this roscore"),
            ({"node": "/x", **here}, "takes no label edits"),
            ({"node": "/x", **here, "delete_service": "no name"}, "takes no label edits"),
            ({"node": "/one", **here, **nobody}, "is of the same name"),
            ({"node": "/x", **here, **nobody}, "did not delete label tree_1"),
        ):
            with self.subTest(info), LabelStore(self.map, owner_info=info) as owner:
                manager = manager or self.start("one", "_map_file:=" + self.map)
                refused = self.refused(manager, "delete_label", DeleteLabel, "", "tree_1")
                self.assertIn(words, refused)
                self.assertIn("(pid %d" % os.getpid(), refused)
                self.assertEqual(sorted(manager.clusters()), ["tree_1", "treehouse_1"])
                self.assertFalse(owner.dirty)

    def test_a_label_that_the_owner_does_not_store_is_an_error(self):
        info = {"node": rospy.get_name(), "run_id": rospy.get_param("/run_id")}
        info["cluster_topic"] = "/deaf/cluster_label"
        heard = []
        deaf = rospy.Subscriber("/deaf/cluster_label", MeshFaceClusterStamped, heard.append)
        with LabelStore(self.map, owner_info=info):
            manager = self.start("one", "_map_file:=" + self.map)
            topic = rospy.Publisher("/one/cluster_label", MeshFaceClusterStamped, queue_size=10)
            self.until(topic.get_num_connections)
            message = MeshFaceClusterStamped(uuid="mesh")
            message.cluster = MeshFaceCluster(face_indices=[1], label="new_1")
            topic.publish(message)
            self.until(lambda: heard)
            self.assertEqual((heard[0].uuid, heard[0].cluster.label), (self.uuid, "new_1"))
            self.until(lambda: b"has not stored label new_1: see its log" in manager.logged())
            manager.stop()
        deaf.unregister()
        topic.unregister()
        self.assertEqual(len(heard), 1)

    def test_beside_a_map_server(self):
        """Whoever started first owns the labels; a label on the topic of both is stored once."""
        server = subprocess.Popen(
            ["rosrun", "mesh_msgs_hdf5", "hdf5_map_server", "_inputFile:=" + self.map],
            stdout=subprocess.DEVNULL,
        )
        self.addCleanup(end, server)
        rospy.wait_for_service("/delete_label", 60)
        topic = rospy.Publisher("/cluster_label", MeshFaceClusterStamped, queue_size=10)
        self.publishers["/cluster_label"] = topic
        self.until(lambda: topic.get_num_connections() > 0)  # the server; no manager runs yet
        ask = rospy.ServiceProxy("/get_labeled_clusters", GetLabeledClusters)
        knowing = self.start("knowing", "_map_file:=" + self.map)
        self.publish(knowing, "a_1", [1, 2])
        self.publish(knowing, "b_1", [3], topic="/cluster_label")
        expected = {"a_1": [1, 2], "b_1": [3], "tree_1": [1, 2], "treehouse_1": [3]}
        self.until(lambda: faces_of(ask("").clusters) == expected)
        self.assertEqual(knowing.clusters(), expected)
        knowing.call("delete_label", DeleteLabel, "", "a_1")
        self.assertNotIn("a_1", faces_of(ask("").clusters))
        knowing.stop()
        alone = self.start("alone")  # names no map: labels on that topic are the server's business
        self.publish(alone, "x_1", [5], uuid=STRANGER, topic="/cluster_label")
        for text in ("c_1", "c_2"):
            message = MeshFaceClusterStamped(uuid=self.uuid)
            message.cluster = MeshFaceCluster(face_indices=[1], label=text)
            topic.publish(message)
        self.until(lambda: "c_2" in faces_of(ask("").clusters))
        self.publish(alone, "x_2", [5], uuid=STRANGER, topic="/cluster_label")
        self.assertIn(
            "known: " + STRANGER, self.refused(alone, "get_label_groups", GetLabelGroups, self.uuid)
        )
        self.assertEqual(sorted(alone.clusters()), ["x_1", "x_2"])
        alone.stop()
        server.terminate()
        self.assertEqual(server.wait(30), 0)
        self.assertEqual(
            sorted(MapFile(self.map).labels()), ["b_1", "c_1", "c_2", "tree_1", "treehouse_1"]
        )

    def test_the_launch_file(self):
        process = subprocess.Popen(
            ["roslaunch", "--wait", "mesh_msgs_hdf5", "label_manager.launch", "map:=" + self.map]
            + ["folder_path:=" + self.labels],
            stdout=subprocess.DEVNULL,
        )
        rospy.wait_for_service("/label_manager/set_label_color", 60)
        answer = rospy.ServiceProxy("/label_manager/get_label_groups", GetLabelGroups)("")
        self.assertEqual(answer.labels, ["tree", "treehouse"])
        process.terminate()
        self.assertEqual(process.wait(30), 0)

    def test_a_bad_map_ends_the_node_with_one_line(self):
        result = subprocess.run(
            ["rosrun", "mesh_msgs_hdf5", "label_manager", "_map_file:=nowhere.h5"]
            + ["_folder_path:=" + self.labels],
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
        )
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.count(b"\n"), 1)
        self.assertIn(b"nowhere.h5: there is no such file", result.stderr)


if __name__ == "__main__":
    rospy.init_node("label_things")
    rostest.rosrun("mesh_msgs_hdf5", "label_things", Labels)
