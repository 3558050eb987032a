#!/usr/bin/python3
"""From a mesh file to a plan, with the commands and topics that a user has, and nothing else."""
import subprocess
import tempfile
import unittest
from contextlib import ExitStack
from pathlib import Path

import meshio
import mesh_msgs.msg
import mesh_msgs.srv
import nav_msgs.msg
import numpy as np
import rospkg
import rospy
import rostest
import yaml
from mesh_msgs import zoo
from mesh_msgs.identity import geometry_uuid
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from mesh_tools_test.demo import navigation_node
from mesh_tools_test.demo.planners import DIJKSTRA, EXACT, PLANNERS, WAVE_FRONT
from mesh_tools_test.demo.processes import process

SERVER = "/move_base_flex"


def edge_graph(vertices, faces):
    """The edges of a mesh as a sparse matrix of lengths, independent of our own kernels."""
    pairs = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    pairs = np.unique(pairs, axis=0)
    lengths = np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1)
    return coo_matrix((lengths, (pairs[:, 0], pairs[:, 1])), shape=(len(vertices),) * 2).tocsr()


def points(list_of_points):
    """(N,3) array of the stock messages' points."""
    return np.array([(p.x, p.y, p.z) for p in list_of_points])


class FileToPlan(unittest.TestCase):
    """One map, imported and served once for all tests."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("file_to_plan")
        cls.stack = ExitStack()
        folder = Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        cls.mesh = zoo.two_storeys()
        ply, cls.file = folder / "storeys.ply", folder / "storeys.h5"
        cells = [("triangle", cls.mesh.faces.astype(np.int32))]
        meshio.write_points_cells(ply, cls.mesh.vertices, cells)
        subprocess.run(
            ["rosrun", "mesh_msgs_hdf5", "mesh_tool", "import", str(ply), str(cls.file)], check=True
        )
        launch = ["roslaunch", "--wait", "mesh_navigation", "mesh_navigation.launch"]
        # For faces of a meter (that of mesh_navigation is for a robot's radius) and a ramp of 21
        # degrees, on which heights differ by 0.21 m within the radius. Lengths are compared.
        config = folder / "steps.yaml"
        shipped = Path(rospkg.RosPack().get_path("mesh_map")) / "config" / "height_diff.yaml"
        layers = yaml.safe_load(shipped.read_text(encoding="utf-8"))
        layers["height_diff"].update(threshold=0.25, factor=0.0)
        config.write_text(yaml.safe_dump(layers), encoding="utf-8")
        launch += [f"map_file:={cls.file}", f"map_config:={config}"]
        cls.navigation = cls.stack.enter_context(
            process("mesh_navigation", launch, folder / "logs")
        )
        server = ["rosrun", "mesh_msgs_hdf5", "hdf5_map_server", f"_inputFile:={cls.file}"]
        cls.stack.enter_context(process("hdf5_map_server", server, folder / "logs"))

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def geometry(self, topic):
        """What a stock subscriber receives on a latched geometry topic."""
        return rospy.wait_for_message(topic, mesh_msgs.msg.MeshGeometryStamped, timeout=60)

    def check_geometry(self, message):
        """The geometry is the file's, value for value, and its UUID that of its content."""
        received = points(message.mesh_geometry.vertices)
        np.testing.assert_array_equal(received, self.mesh.vertices.astype(np.float64))
        faces = np.array([face.vertex_indices for face in message.mesh_geometry.faces])
        np.testing.assert_array_equal(faces, self.mesh.faces)
        self.assertEqual(message.uuid, geometry_uuid(self.mesh.vertices, self.mesh.faces))
        self.assertEqual(message.header.frame_id, "map")

    def test_mesh_map_publishes_the_file(self):
        self.check_geometry(self.geometry(f"{SERVER}/mesh_map/mesh"))

    def test_map_server_publishes_and_serves_the_file(self):
        self.check_geometry(self.geometry("/mesh/geometry"))
        rospy.wait_for_service("/get_geometry", 30)
        get_geometry = rospy.ServiceProxy("/get_geometry", mesh_msgs.srv.GetGeometry)
        self.check_geometry(get_geometry("").mesh_geometry_stamped)

    def test_costs_refer_to_the_geometry(self):
        costs = rospy.wait_for_message(
            f"{SERVER}/mesh_map/vertex_costs", mesh_msgs.msg.MeshVertexCostsStamped, timeout=60
        )
        self.assertEqual(costs.uuid, geometry_uuid(self.mesh.vertices, self.mesh.faces))
        self.assertEqual(len(costs.mesh_vertex_costs.costs), len(self.mesh.vertices))

    def test_plan_from_storey_to_storey(self):
        """All paths lead up the ramp to the goal right above; that along the edges is as long as
        SciPy's Dijkstra says, those across the faces are shorter."""
        vertices = self.mesh.vertices.astype(np.float64)
        graph = edge_graph(vertices, self.mesh.faces)
        lower, upper = vertices[:, 2].min(), vertices[:, 2].max()
        above = np.flatnonzero(vertices[:, 2] == upper)
        below = np.flatnonzero(vertices[:, 2] == lower)
        gap, nearest = cKDTree(vertices[below, :2]).query(vertices[above, :2])
        pick = gap.argmin()
        start, goal = below[nearest[pick]], above[pick]
        length = dijkstra(graph, directed=False, indices=start)[goal]
        straight = np.linalg.norm(vertices[goal] - vertices[start])
        self.assertGreater(length, 2 * straight)

        client = navigation_node.PlanClient(self.navigation)
        ends = vertices[start], vertices[goal]
        plans = {each.name: client.plan(*ends, "map", each.name) for each in PLANNERS}
        for name, plan in plans.items():
            with self.subTest(name):
                self.check_path(plan, *ends, name)
        plan = plans[DIJKSTRA.name]
        self.assertAlmostEqual(plan.cost, length, delta=1e-3 * length)
        self.assertLess(cKDTree(vertices).query(plan.positions)[0].max(), 1e-3)
        # Across faces it is never farther than along edges; these ways are the two extremes.
        exact, front = plans[EXACT.name], plans[WAVE_FRONT.name]
        self.assertGreater(exact.cost, straight)
        self.assertLessEqual(exact.cost, front.length * (1 + 1e-6))
        self.assertLessEqual(front.cost, length * (1 + 1e-6))

    def check_path(self, plan, start, goal, name):
        """It begins and ends where it shall, and late subscribers get the same."""
        path = plan.positions
        np.testing.assert_allclose(path[0], start, atol=1e-3)
        np.testing.assert_allclose(path[-1], goal, atol=1e-3)
        self.assertNotEqual(plan.message, "")
        self.assertEqual(len(plan.potential), len(self.mesh.vertices))
        self.assertTrue((plan.potential >= 0).all())
        latched = rospy.wait_for_message(f"{SERVER}/{name}/path", nav_msgs.msg.Path, timeout=30)
        np.testing.assert_array_equal(points(p.pose.position for p in latched.poses), path)


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "file_to_plan", FileToPlan)
