#!/usr/bin/python3
"""The launch file: the node mesh_map with a layer of this package, in its own processes."""

import os
import shutil
import signal
import subprocess
import tempfile
import unittest

import dynamic_reconfigure.client
import numpy as np
import rospy
import rostest
from mesh_msgs import arrays
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from std_srvs.srv import Trigger

WAIT = 30.0  # seconds; far more than anything takes
LAYERS = {"height_diff", "roughness", "smooth_roughness"}


def rough_ground(size=20):
    """A noisy grid, 0.1 m from vertex to vertex."""
    x, y = np.meshgrid(np.arange(size) * 0.1, np.arange(size) * 0.1, indexing="ij")
    z = np.random.default_rng(1).normal(0.0, 0.01, x.shape)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32)
    corner = np.arange(size * size).reshape(size, size)[:-1, :-1].reshape(-1, 1)
    faces = np.concatenate([corner + [0, size, 1], corner + [1, size, size + 1]])
    return Mesh(vertices, faces.astype(np.uint32))


class SmoothLayerInANode(unittest.TestCase):
    def setUp(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        self.path = os.path.join(folder, "map.h5")
        MapFile.write(self.path, rough_ground())
        self.costs = {}
        subscriber = rospy.Subscriber(
            "/mesh_map/vertex_costs", arrays.MeshVertexCostsStamped, self.receive, queue_size=4
        )
        self.addCleanup(subscriber.unregister)

    def receive(self, message):
        self.costs[message.type] = message.mesh_vertex_costs.costs

    def wait_for(self, condition):
        self.assertTrue(wait_until(condition, seconds=WAIT), "only %s came" % sorted(self.costs))

    def launch(self):
        """Starts the launch file; returns what ends it."""
        launch = subprocess.Popen(
            ["roslaunch", "example_mesh_layer", "smooth.launch", "mesh_file:=" + self.path]
        )

        def end():
            if launch.poll() is None:
                launch.send_signal(signal.SIGINT)
                launch.wait(WAIT)

        self.addCleanup(end)
        self.wait_for(lambda: LAYERS <= set(self.costs))
        return end

    def test_the_launch_file(self):
        end = self.launch()
        rough, smooth = self.costs["roughness"], self.costs["smooth_roughness"]
        self.assertEqual(len(rough), 400)
        self.assertLess(np.std(smooth), 0.9 * np.std(rough))
        self.assertTrue(rough.min() <= smooth.min() and smooth.max() <= rough.max())

        client = dynamic_reconfigure.client.Client("/mesh_map/smooth_roughness", timeout=WAIT)
        self.addCleanup(client.close)
        accepted = client.update_configuration({"rounds": 20})
        self.assertEqual(accepted["rounds"], 20)
        self.wait_for(lambda: not np.array_equal(self.costs["smooth_roughness"], smooth))
        smoother = self.costs["smooth_roughness"]
        self.assertLess(np.std(smoother), 0.9 * np.std(smooth))
        np.testing.assert_array_equal(self.costs["roughness"], rough)

        save = rospy.ServiceProxy("/mesh_map/save_map", Trigger)
        save.wait_for_service(WAIT)
        answer = save()
        self.assertTrue(answer.success, answer.message)
        stored = MapFile(self.path)
        np.testing.assert_array_equal(stored.vertex_costs("smooth_roughness"), smoother)
        self.assertEqual(stored.layer_parameters("smooth_roughness")["rounds"], 20)
        end()


if __name__ == "__main__":
    rospy.init_node("smooth_layer_check")
    rostest.rosrun("example_mesh_layer", "smooth_layer", SmoothLayerInANode)
