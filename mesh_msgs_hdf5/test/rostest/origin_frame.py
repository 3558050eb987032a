#!/usr/bin/python3
"""The origins of maps on /tf_static, and when there are none."""
import os
import tempfile
import time
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from mesh_msgs.testing import wait_until
from server_process import Server
from tf2_msgs.msg import TFMessage

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

ORIGIN = (431235.25, 5791235.5, 89.0)
PUBLISHED = "its origin is not published in frame utm"


class OriginFrame(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.found = {}  # child -> {(node, parent, place)}
        rospy.Subscriber("/tf_static", TFMessage, cls.take)
        # a frame with a parent
        cls.publisher = rospy.Publisher("/tf_static", TFMessage, latch=True, queue_size=1)
        link = TransformStamped()
        link.header.frame_id, link.child_frame_id = "building", "floor"
        link.transform.rotation.w = 1.0
        cls.publisher.publish(TFMessage([link]))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def take(cls, message):
        node = message._connection_header["callerid"]
        for link in message.transforms:
            at = link.transform.translation
            assert (link.transform.rotation.w, link.transform.rotation.z) == (1, 0)
            value = (node, link.header.frame_id, (at.x, at.y, at.z))
            cls.found.setdefault(link.child_frame_id, set()).add(value)

    def map(self, number, **members):
        """The path of a new map."""
        path = os.path.join(self.folder.name, "%d.h5" % number)
        vertices = np.eye(3, dtype=np.float32) * number
        mesh = Mesh(vertices, np.uint32([[0, 1, 2]]), origin=ORIGIN, crs="EPSG:25832")
        for name, value in members.items():
            setattr(mesh, name, value)
        MapFile.write(path, mesh)
        return path

    def serve(self, namespace, paths, words, **parameters):
        server = Server(namespace, inputFile=paths, **parameters)
        self.addCleanup(server.stop)
        server.wait_for(words)
        return server

    def test_the_origin_is_the_place_in_the_parent(self):
        path = self.map(1, frame_id="one")
        line = "%s: frame one is at 431235.25, 5791235.5, 89.0 of frame utm (EPSG:25832)" % path
        self.serve("/a", [path], line, origin_frame="utm")
        wait_until(lambda: "one" in self.found, "frame one")
        self.assertEqual(self.found["one"], {("/a/hdf5_map_server", "utm", ORIGIN)})

    def test_a_frame_with_a_parent_gets_no_second_one(self):
        path = self.map(2, frame_id="floor")
        words = PUBLISHED + ": frame floor already has the parent building"
        server = self.serve("/b", [path], words, origin_frame="utm")
        self.assertEqual(len(server.logged(path + ": " + PUBLISHED)), 1)
        time.sleep(0.5)
        self.assertEqual({parent for _, parent, _ in self.found["floor"]}, {"building"})

    def test_of_two_maps_in_one_frame_the_first_one_counts(self):
        first, second = self.map(3, frame_id="two"), self.map(4, frame_id="two", origin=(1, 2, 3))
        third = self.map(5, frame_id="three", origin=(0, 0, 0), crs="")
        words = "%s: frame three is at 0.0, 0.0, 0.0 of frame utm (the map names no" % third
        server = self.serve("/c", [first, second, third], words, origin_frame="utm")
        words = "%s: %s: frame two is at the origin of %s" % (second, PUBLISHED, first)
        self.assertEqual(len(server.logged(words)), 1)
        wait_until(lambda: "three" in self.found, "frame three")
        self.assertEqual({place for _, _, place in self.found["two"]}, {ORIGIN})

    def test_nothing_is_published_unless_asked_for(self):
        server = self.serve("/d", [self.map(6, frame_id="four")], "serving")
        time.sleep(0.5)
        self.assertNotIn("four", self.found)
        self.assertEqual(server.logged("origin"), [])


if __name__ == "__main__":
    rospy.init_node("origin_frame")
    rostest.rosrun("mesh_msgs_hdf5", "origin_frame", OriginFrame)
