#!/usr/bin/python3
"""Labels of a refined map: edits there become those of the parent's faces, and the other way."""

import os
import shutil
import subprocess
import tempfile
import unittest

import numpy as np
import roslib.packages
import rospy
import rostest
from map_node import WAIT, Subscriber, start_node
from mesh_map.io.map_source import MapSource
from mesh_msgs import array_services, arrays
from mesh_msgs.msg import StoreResult
from mesh_msgs.srv import GetLabelColors, GetLabelGroups, SetLabelColor
from mesh_msgs.testing import wait_until
from mesh_msgs.world.solids import floor
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from rosgraph_msgs.msg import Log
from std_msgs.msg import ColorRGBA, String
from std_srvs.srv import Trigger

LENGTH = 0.4
OWNER = "/owner"


class DerivedLabelsTest(unittest.TestCase):
    """Each test has nodes of its own; labels of the parent are of its two faces, and two more."""

    def setUp(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        self.path = os.path.join(folder, "map.h5")
        vertices, faces = floor((0.0, 0.0), (4.0, 2.0), 2.0)
        mesh = Mesh(np.float32(vertices), np.uint32(faces))
        mesh.labels["wall_1"] = Label(np.array([1], np.uint32), (10, 20, 30))
        self.file = MapFile.write(self.path, mesh)
        self.assertEqual(self.file.face_count, 4)
        derived = MapSource(self.path).make_map(max_edge_length=LENGTH).geometry.derived
        self.derived, self.parents = derived, derived.face_parents

    def start_owner(self):
        executable = roslib.packages.find_node("mesh_msgs_hdf5", "hdf5_map_server")[0]
        owner = subprocess.Popen([executable, self.path, "__ns:=" + OWNER])
        self.addCleanup(owner.wait, WAIT)
        self.addCleanup(owner.terminate)
        rospy.wait_for_service(OWNER + "/get_labeled_clusters", WAIT)
        return owner

    def start(self, name):
        self.name = name
        node = start_node(self, name, mesh_file=self.path, max_edge_length=LENGTH)
        progress = Subscriber("/%s/progress" % name, String)
        self.addCleanup(progress.unregister)
        self.assertTrue(wait_until(lambda: "ready" in str(progress.messages[-1:])))
        self.told = Subscriber("/%s/new_cluster_label" % name, arrays.MeshFaceCluster)
        self.addCleanup(self.told.unregister)
        self.assertTrue(self.told.connected())
        return node

    def publisher(self, topic):
        publisher = rospy.Publisher(topic, arrays.MeshFaceClusterStamped, queue_size=10)
        self.addCleanup(publisher.unregister)
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() > 0))
        return publisher

    def edit(self, publisher, uuid, label, faces, override=True):
        cluster = arrays.MeshFaceCluster(np.array(faces, np.uint32), label)
        publisher.publish(
            arrays.MeshFaceClusterStamped(uuid=uuid, cluster=cluster, override=override)
        )

    def ask(self, name, kind, *arguments):
        return rospy.ServiceProxy(name, kind)(*arguments)

    def labels(self, name_space, uuid=""):
        kind = array_services.GetLabeledClusters
        answer = self.ask(name_space + "/get_labeled_clusters", kind, uuid)
        return {each.label: sorted(each.face_indices) for each in answer.clusters}

    def parts(self, *parents):
        return np.flatnonzero(np.isin(self.parents, parents)).tolist()

    def test_edits_of_parts_are_edits_of_their_parents(self):
        owner = self.start_owner()
        self.start("edited")
        mine, derived = "/edited", self.derived
        self.assertEqual(self.labels(mine, derived.uuid), {"wall_1": self.parts(1)})
        publisher = self.publisher(mine + "/cluster_label")
        results = Subscriber(OWNER + "/store/result", StoreResult)  # of all that it is sent
        self.addCleanup(results.unregister)
        self.assertTrue(results.connected())
        some = self.parts(2)[3:5]
        self.edit(publisher, derived.uuid, "", some)  # no label: not even sent, nobody waits
        self.edit(publisher, derived.uuid, "tree_1", some)
        self.assertTrue(wait_until(lambda: "tree_1" in self.labels(OWNER)))
        self.assertEqual(self.labels(OWNER), {"tree_1": [2], "wall_1": [1]})
        self.assertTrue(wait_until(lambda: results.messages))
        self.assertEqual([each.name for each in results.messages], ["tree_1"])
        self.assertTrue(wait_until(lambda: self.told.messages))
        self.assertEqual(self.told.messages[0].label, "tree_1")
        self.assertEqual(self.told.messages[0].face_indices.tolist(), self.parts(2))
        self.assertEqual(self.labels(mine), {"tree_1": self.parts(2), "wall_1": self.parts(1)})

        self.edit(publisher, derived.uuid, "tree_1", [self.parts(0)[0]], override=False)
        self.assertTrue(wait_until(lambda: self.labels(OWNER)["tree_1"] == [0, 2]))
        # One part that is taken away takes its parent's face away.
        self.edit(publisher, derived.uuid, "tree_1", self.parts(0, 2)[:-1])
        self.assertTrue(wait_until(lambda: self.labels(OWNER)["tree_1"] == [0]))
        newest = lambda: self.told.messages[-1].face_indices.tolist()  # noqa: E731
        self.assertTrue(wait_until(lambda: newest() == self.parts(0)))

        # In the file, too, as faces of the parent.
        answer = self.ask(mine + "/save_map", Trigger)
        self.assertTrue(answer.success, answer.message)
        self.assertIn("labels: saved 1 label to " + self.path, answer.message)
        self.assertEqual(MapFile(self.path).label("tree_1").faces.tolist(), [0])
        owner.terminate()
        owner.wait(WAIT)
        saved = MapFile(self.path)
        self.assertEqual(saved.uuid, self.file.uuid)
        self.assertEqual(saved.label("tree_1").faces.tolist(), [0])
        self.assertEqual(saved.label("wall_1").faces.tolist(), [1])

    def test_labels_of_the_parent_are_told_as_their_parts(self):
        self.start_owner()
        self.start("told")
        publisher = self.publisher(OWNER + "/cluster_label")
        self.edit(publisher, self.file.uuid, "pillar_1", [3])
        self.assertTrue(wait_until(lambda: self.told.messages))
        message = self.told.messages[-1]
        self.assertEqual(message.label, "pillar_1")
        self.assertEqual(message.face_indices.tolist(), self.parts(3))
        self.ask(OWNER + "/delete_label", array_services.DeleteLabel, self.file.uuid, "pillar_1")
        self.assertTrue(wait_until(lambda: len(self.told.messages[-1].face_indices) == 0))
        self.assertEqual(self.told.messages[-1].label, "pillar_1")

    def test_deleted_and_colored_by_the_owner(self):
        self.start_owner()
        self.start("colored")
        mine, uuid = "/colored", self.derived.uuid
        colors = self.ask(mine + "/get_label_colors", GetLabelColors, uuid)
        self.assertEqual((colors.labels, round(255 * colors.colors[0].g)), (["wall_1"], 20))
        self.ask(mine + "/set_label_color", SetLabelColor, uuid, "wall_1", ColorRGBA(1, 0, 0, 1))
        of_owner = self.ask(OWNER + "/get_label_colors", GetLabelColors, self.file.uuid)
        self.assertEqual([round(of_owner.colors[0].r), round(of_owner.colors[0].g)], [1, 0])
        self.assertEqual(self.ask(mine + "/get_label_groups", GetLabelGroups, "").labels, ["wall"])
        self.ask(mine + "/delete_label", array_services.DeleteLabel, uuid, "wall_1")
        self.assertEqual(self.labels(OWNER), {})
        self.assertTrue(wait_until(lambda: self.told.messages))
        self.assertEqual(self.told.messages[-1].face_indices.tolist(), [])
        with self.assertRaisesRegex(rospy.ServiceException, "no label"):
            self.ask(mine + "/delete_label", array_services.DeleteLabel, uuid, "wall_1")

    def test_what_it_was_made_of(self):
        self.start("made")
        kind = array_services.GetDerivedMesh
        answer = self.ask("/made/get_derived_mesh", kind, self.derived.uuid)
        self.assertEqual(answer.parent_uuid, self.file.uuid)
        np.testing.assert_array_equal(answer.face_parents, self.parents)
        with self.assertRaisesRegex(rospy.ServiceException, "no map of uuid"):
            self.ask("/made/get_derived_mesh", kind, self.file.uuid)

    def test_nobody_who_stores_them(self):
        """It is said, and who could; so are edits of other meshes, and faces that are none."""
        log = Subscriber("/rosout", Log)
        self.addCleanup(log.unregister)
        self.start("alone")
        publisher = self.publisher("/alone/cluster_label")

        def refused(uuid, label, face, *words):
            self.edit(publisher, uuid, label, [face])
            lines = [message.msg for message in log.messages if "refused: " in message.msg]
            return any(all(word in line for word in words) for line in lines)

        uuid, count = self.derived.uuid, len(self.parents)
        nobody = "%s: nobody stores its labels (rosrun mesh_msgs_hdf5 hdf5_map_server" % self.path
        unknown = "there is no map of uuid '%s'" % self.file.uuid
        self.assertTrue(wait_until(lambda: refused(uuid, "tree_1", 0, nobody)))
        self.assertTrue(wait_until(lambda: refused(self.file.uuid, "tree_2", 0, unknown)))
        self.assertTrue(wait_until(lambda: refused(uuid, "tree_3", count, "face", str(count))))
        with self.assertRaisesRegex(rospy.ServiceException, "nobody stores its labels"):
            self.ask("/alone/delete_label", array_services.DeleteLabel, uuid, "wall_1")
        self.assertEqual(self.labels("/alone"), {"wall_1": self.parts(1)})

    def test_an_owner_that_comes_later(self):
        self.start("later")
        publisher = self.publisher("/later/cluster_label")
        self.start_owner()

        def stored():
            self.edit(publisher, self.derived.uuid, "tree_5", self.parts(0))
            return "tree_5" in self.labels(OWNER)

        self.assertTrue(wait_until(stored))
        self.assertEqual(self.labels(OWNER), {"tree_5": [0], "wall_1": [1]})


if __name__ == "__main__":
    rospy.init_node("derived_labels_check")
    rostest.rosrun("mesh_map", "derived_labels", DerivedLabelsTest)
