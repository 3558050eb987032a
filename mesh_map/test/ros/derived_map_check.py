#!/usr/bin/python3
"""A mesh of few large faces on a running ROS, refined by max_edge_length."""

import os
import shutil
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from map_node import WAIT, Subscriber, costs_of, end_node, start_node
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.io.map_source import MapSource
from mesh_map.ros import MeshMapServer
from mesh_msgs import array_services, arrays
from mesh_msgs.srv import GetUUIDs
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics
from mesh_msgs.world.solids import floor
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from std_msgs.msg import String
from std_srvs.srv import Trigger

LAYERS = {
    "layers": [
        {"name": "values", "type": "mesh_layers/StoredLayer"},
        {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"},
    ],
    "height_diff": {"radius": 0.3},
}
LENGTH = 0.3
COARSE = "edges longer than radius of layer height_diff, 0.3 m"


class DerivedMapTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        self.path = os.path.join(folder, "map.h5")
        vertices, faces = floor((0.0, 0.0), (6.0, 4.0), 9.0)
        mesh = Mesh(np.float32(vertices), np.uint32(faces))
        mesh.vertex_colors = np.array([[0, 0, 0], [90, 60, 30], [0, 60, 255], [9, 9, 9]], np.uint8)
        mesh.vertex_costs["values"] = np.float32([0.0, 0.25, 0.5, 1.0])
        mesh.face_attributes["slope"] = np.float32([3.0, 5.0])
        self.file = MapFile.write(self.path, mesh)
        self.expected = MapSource(self.path).make_map(max_edge_length=LENGTH)

    def test_what_is_published_is_the_derived_mesh(self):
        expected, derived = self.expected, self.expected.geometry.derived
        diagnostics = HeardDiagnostics()
        node = start_node(self, "fine", mesh_file=self.path, max_edge_length=LENGTH, **LAYERS)
        geometry = rospy.wait_for_message("/fine/mesh", arrays.MeshGeometryStamped, WAIT)
        costs = costs_of("/fine/vertex_costs")
        names = {"values", "height_diff", COMBINED_COSTS}
        self.assertTrue(wait_until(lambda: set(costs.newest) == names), costs.newest.keys())
        colors = rospy.wait_for_message("/fine/vertex_colors", arrays.MeshVertexColorsStamped, WAIT)
        of_faces = rospy.wait_for_message("/fine/face_costs", arrays.MeshFaceCostsStamped, WAIT)
        messages = [geometry, colors, of_faces, *costs.newest.values()]
        self.assertEqual({message.uuid for message in messages}, {derived.uuid})
        self.assertNotEqual(derived.uuid, self.file.uuid)
        np.testing.assert_array_equal(geometry.mesh_geometry.vertices, expected.vertices)
        np.testing.assert_array_equal(geometry.mesh_geometry.faces, expected.faces)
        self.assertEqual(len(colors.mesh_vertex_colors.vertex_colors), len(expected.vertices))
        np.testing.assert_array_equal(
            of_faces.mesh_face_costs.costs, np.float32([3.0, 5.0])[derived.face_parents]
        )
        np.testing.assert_array_equal(
            costs.newest["values"].mesh_vertex_costs.costs,
            derived.vertex_values(self.file.vertex_costs("values")),
        )
        uuids = rospy.ServiceProxy("/fine/get_uuids", GetUUIDs)().uuids
        self.assertEqual(uuids, [derived.uuid])
        served = rospy.ServiceProxy("/fine/get_vertex_colors", array_services.GetVertexColors)
        message = served(derived.uuid).mesh_vertex_colors_stamped
        np.testing.assert_array_equal(
            message.mesh_vertex_colors.vertex_colors, colors.mesh_vertex_colors.vertex_colors
        )
        progress = Subscriber("/fine/progress", String)
        self.assertTrue(wait_until(lambda: "ready" in str(progress.messages[-1:])))

        remark = rospy.wait_for_message("/fine/remark", String, WAIT)
        self.assertEqual(remark.data, "")

        # What is saved belongs to the parent.
        answer = rospy.ServiceProxy("/fine/save_map", Trigger)()
        self.assertTrue(answer.success, answer.message)
        saved = MapFile(self.path)
        self.assertEqual((saved.uuid, saved.face_count), (self.file.uuid, 2))
        np.testing.assert_array_equal(
            saved.vertex_costs("height_diff"),
            costs.newest["height_diff"].mesh_vertex_costs.costs[: saved.vertex_count],
        )
        self.assertNotIn("remark", diagnostics.expected("fine: map", 0, "ready").values)
        log = end_node(node)
        self.assertIn("made of 2 faces", log)
        self.assertNotIn(COARSE, log)

    def test_seams_of_textures(self):
        """What is published is the file's mesh, with copies; what is computed knows no seam."""
        x, y = np.meshgrid(np.arange(20) * 0.2, np.arange(10) * 0.2, indexing="ij")
        vertices = np.stack([x, y, 0.2 * np.sin(3 * x)], -1).reshape(-1, 3).astype(np.float32)
        corner = np.arange(200).reshape(20, 10)[:-1, :-1].ravel()
        faces = np.stack([corner, corner + 10, corner + 11, corner, corner + 11, corner + 1], 1)
        faces = faces.reshape(-1, 3).astype(np.uint32)
        plain = Mesh(vertices, faces)
        originals = np.arange(100, 110, dtype=np.uint32)  # the column at x = 2 m
        right = vertices[faces][:, :, 0].mean(1) > 2.0
        moved = np.where(right[:, None] & np.isin(faces, originals), faces + 100, faces)
        split = Mesh(np.concatenate([vertices, vertices[originals]]), moved.astype(np.uint32))
        split.seam_originals = originals
        split.texture_coordinates = np.random.default_rng(0).random((210, 2)).astype(np.float32)
        paths = [os.path.join(os.path.dirname(self.path), name) for name in ("s.h5", "p.h5")]
        file = MapFile.write(paths[0], split)
        self.assertEqual(file.parent_uuid, MapFile.write(paths[1], plain).uuid)
        layers = {
            "layers": [
                {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"},
                {"name": "border", "type": "mesh_layers/BorderLayer"},
            ]
        }
        node = start_node(self, "seams", mesh_file=paths[0], **layers)
        geometry = rospy.wait_for_message("/seams/mesh", arrays.MeshGeometryStamped, WAIT)
        np.testing.assert_array_equal(geometry.mesh_geometry.vertices, split.vertices)
        np.testing.assert_array_equal(geometry.mesh_geometry.faces, split.faces)
        costs = costs_of("/seams/vertex_costs")
        names = {"height_diff", "border", COMBINED_COSTS}
        self.assertTrue(wait_until(lambda: set(costs.newest) == names), costs.newest.keys())
        whole = MapSource(paths[1]).make_map()
        whole.compute_layers(layers["layers"])
        served = rospy.ServiceProxy("/seams/get_vertex_costs", array_services.GetVertexCosts)
        for name, layer in whole.layers.items():
            expected = np.concatenate([layer.result.costs, layer.result.costs[originals]])
            message = costs.newest[name]
            self.assertEqual(message.uuid, file.uuid)
            np.testing.assert_array_equal(message.mesh_vertex_costs.costs, expected)
            answer = served(file.uuid, name).mesh_vertex_costs_stamped.mesh_vertex_costs
            np.testing.assert_array_equal(answer.costs, expected)
        answer = rospy.ServiceProxy("/seams/save_map", Trigger)()
        self.assertTrue(answer.success, answer.message)
        stored = MapFile(paths[0])
        self.assertEqual((stored.uuid, stored.parent_uuid), (file.uuid, file.parent_uuid))
        self.assertEqual(len(stored.vertex_costs("border")), 210)
        self.assertIn("shown with 10 copies along seams", end_node(node))

    def test_large_faces_are_said_once(self):
        diagnostics = HeardDiagnostics()
        node = start_node(self, "coarse", mesh_file=self.path, **LAYERS)
        progress = Subscriber("/coarse/progress", String)
        self.assertTrue(wait_until(lambda: "ready" in str(progress.messages[-1:])))
        status = diagnostics.expected("coarse: map", 0, "ready")
        values = {one.key: one.value for one in status.values}
        self.assertIn(COARSE, values["remark"])
        remark = rospy.wait_for_message("/coarse/remark", String, WAIT)
        self.assertEqual(remark.data, values["remark"])
        log = end_node(node)
        self.assertEqual(log.count(COARSE), 1, log)
        self.assertIn("max_edge_length: 0.15, half", log)

    def test_the_radius_of_a_robot_counts(self):
        rospy.set_param("/robot/mesh_map", {"mesh_file": self.path})
        server = MeshMapServer("/robot/mesh_map", {"the robot's radius": 0.2})
        self.addCleanup(server.shutdown)
        with self.assertLogs("mesh_map", "WARNING") as logged:
            server.load()
        said = [line for line in logged.output if "the robot's radius, 0.2 m" in line]
        self.assertEqual(len(said), 1, logged.output)
        rospy.set_param("/robot/mesh_map", {"mesh_file": self.path, "max_edge_length": 0.2})
        with self.assertLogs("mesh_map", "WARNING") as logged:
            mesh_map = server.load()
        self.assertNotIn("the robot's radius", str(logged.output))
        self.assertGreater(len(mesh_map.faces), 1000)


if __name__ == "__main__":
    rospy.init_node("derived_map_check")
    rostest.rosrun("mesh_map", "derived_map", DerivedMapTest)
