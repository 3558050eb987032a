#!/usr/bin/python3
"""A client with the released service types, and the node as a released launch file starts it."""
import shutil
import unittest

import rospy
import rostest
from mesh_msgs.msg import MeshFaceCluster, MeshFaceClusterStamped

from label_manager.srv import DeleteLabel, GetLabeledClusterGroup, GetLabelGroups

FOLDER = "/tmp/label_manager_of_a_test/"  # of the launch file
UUID = "2d0a6f0e-released"


class ReleasedClient(unittest.TestCase):
    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)

    def test_store_ask_and_delete(self):
        topic = rospy.Publisher("label_manager/cluster_label", MeshFaceClusterStamped, queue_size=9)
        groups = rospy.ServiceProxy("label_manager/get_label_groups", GetLabelGroups)
        group = rospy.ServiceProxy(
            "label_manager/get_labeled_cluster_group", GetLabeledClusterGroup
        )
        delete = rospy.ServiceProxy("label_manager/delete_label", DeleteLabel)
        groups.wait_for_service(40)
        while not topic.get_num_connections():
            rospy.sleep(0.05)
        cluster = MeshFaceCluster(face_indices=[5, 3], label="tree_1")
        topic.publish(MeshFaceClusterStamped(uuid=UUID, cluster=cluster, override=True))
        found = []
        while not found:
            rospy.sleep(0.05)
            try:
                found = groups(uuid=UUID).labels
            except rospy.ServiceException:
                continue  # the label is not stored yet
        self.assertEqual(found, ["tree"])
        (tree,) = group(uuid=UUID, labelGroup="tree").clusters
        self.assertEqual((tree.label, sorted(tree.face_indices)), ("tree_1", [3, 5]))
        self.assertEqual(sorted(delete(uuid=UUID, label="tree_1").cluster.face_indices), [3, 5])


if __name__ == "__main__":
    rospy.init_node("released_client")
    rostest.rosrun("label_manager", "released_client", ReleasedClient)
