#!/usr/bin/python3
"""dynamic_reconfigure of a map and its layers, by a client as rqt_reconfigure is one."""

import ast
import math
import os
import shutil
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from dynamic_reconfigure.client import Client
from dynamic_reconfigure.msg import Config, DoubleParameter, GroupState, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from map_node import WAIT, costs_of, end_node, start_node
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_msgs import zoo
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

LAYERS = [
    {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"},
    {"name": "giant", "type": "strange/GiantLayer"},
    {"name": "flag", "type": "strange/FlagLayer"},
]


class ReconfigureTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        path = os.path.join(folder, "map.h5")
        world = zoo.outdoor_world(faces=2000)
        MapFile.write(path, Mesh(world.vertices, world.faces))
        self.name = self.id().rpartition(".")[2]
        self.node = start_node(
            self,
            self.name,
            mesh_file=path,
            layers=LAYERS,
            height_diff={"threshold": 0.4, "radius": 50, "factor": 0.5},
            flag={"height": 2},
            cost_limit=20,
            edge_weight="nonsense",
        )
        self.costs = costs_of("/%s/vertex_costs" % self.name)
        self.addCleanup(self.costs.unregister)

    def client(self, name=""):
        client = Client("/%s%s" % (self.name, name and "/" + name), timeout=WAIT)
        self.addCleanup(client.close)
        client.get_parameter_descriptions(WAIT)
        return client

    def newest(self, name):
        message = self.costs.newest.get(name)
        return None if message is None else message.mesh_vertex_costs.costs

    def wait_for_lethals(self, count):
        """Combined costs with so many lethal vertices."""

        def there():
            costs = self.newest(COMBINED_COSTS)
            return costs is not None and np.count_nonzero(np.isinf(costs)) == count

        self.assertTrue(wait_until(there), count)

    def test_a_layer(self):
        client = self.client("height_diff")
        described = {one["name"]: one for one in client.get_parameter_descriptions(WAIT)}
        limits = {name: (one["min"], one["max"], one["default"]) for name, one in described.items()}
        self.assertEqual(limits["threshold"], (0.05, 1.0, 0.185))
        self.assertEqual(limits["radius"], (0.02, 1.0, 0.3))
        self.assertEqual(limits["factor"], (0.0, 1.0, 1.0))
        values = client.get_configuration(WAIT)
        self.assertEqual((values["threshold"], values["radius"], values["factor"]), (0.4, 1, 0.5))
        self.assertEqual(rospy.get_param("/%s/height_diff/radius" % self.name), 1.0)

        self.assertTrue(wait_until(lambda: self.newest("height_diff") is not None))
        heights = self.newest("height_diff")
        counts = [np.count_nonzero(heights > np.float32(value)) for value in (0.4, 0.8)]
        self.assertGreater(counts[0], counts[1])
        self.wait_for_lethals(counts[0])
        answer = client.update_configuration({"threshold": 0.8})
        self.assertEqual(answer["threshold"], 0.8)
        self.wait_for_lethals(counts[1])
        self.assertEqual(rospy.get_param("/%s/height_diff/threshold" % self.name), 0.8)

        answer = client.update_configuration({"threshold": 7.0, "factor": 1.0})
        self.assertEqual((answer["threshold"], answer["factor"]), (1.0, 1.0))
        lethal = heights > 1
        self.wait_for_lethals(np.count_nonzero(lethal))
        found = self.newest(COMBINED_COSTS)
        np.testing.assert_array_equal(found, np.where(lethal, np.inf, heights))

        answer = client.update_configuration({"radius": 0.02})
        self.assertEqual(answer["radius"], 0.02)
        self.assertTrue(wait_until(lambda: self.newest("height_diff").max() < heights.max()))

    def test_what_is_refused_goes_back(self):
        client = self.client("flag")
        service = rospy.ServiceProxy("/%s/flag/set_parameters" % self.name, Reconfigure)
        updates = []
        client.config_callback = updates.append
        for config in (
            Config(doubles=[DoubleParameter("height", math.nan)]),
            Config(doubles=[DoubleParameter("height", math.inf)]),
            Config(doubles=[DoubleParameter("height", 13.0)]),  # the layer cannot be computed
            Config(strs=[StrParameter("height", "tall")]),
            Config(strs=[StrParameter("fabric", "paper")]),
            Config(strs=[StrParameter("unknown", "x")]),
            Config(strs=[StrParameter("groups", "x")]),
            Config(groups=[GroupState("Default", False, 0, 0)]),
            Config(groups=[GroupState("unknown", True, 7, 3)]),
        ):
            del updates[:]
            answer = service(config).config
            doubles = {one.name: one.value for one in answer.doubles}
            self.assertEqual(doubles, {"height": 2, "factor": 1, "combination_weight": 1}, config)
            self.assertEqual([(s.name, s.value) for s in answer.strs], [("fabric", "silk")])
            self.assertEqual([(g.name, g.state) for g in answer.groups], [("Default", True)])
            self.assertTrue(wait_until(lambda: updates))
            self.assertEqual((updates[-1]["height"], updates[-1]["fabric"]), (2.0, "silk"))
        self.assertEqual(client.update_configuration({"fabric": "wool"})["fabric"], "wool")
        self.assertEqual(rospy.get_param("/%s/flag/fabric" % self.name), "wool")
        output = end_node(self.node)
        for words in ("height is nan", "height is inf", "no flag is 13 m high", "height is 'tall'"):
            self.assertEqual(output.count(words), 1, output)
        self.assertEqual(output.count("/%s/flag: refused: " % self.name), 5, output)
        self.assertEqual(
            output.count("layer giant cannot be reconfigured: OverflowError"), 1, output
        )

    def test_the_map(self):
        client = self.client()
        described = {one["name"]: one for one in client.get_parameter_descriptions(WAIT)}
        for name in ("layer_factor", "edge_cost_factor", "cost_limit"):
            self.assertEqual((described[name]["min"], described[name]["max"]), (0.0, 10.0))
        self.assertEqual(described["min_contour_size"]["max"], 100000)
        for name, choices in (
            ("combination", ["sum", "normalized", "max"]),
            ("edge_weight", ["mean", "difference"]),
            ("default_layer", ["", "height_diff", "giant", "flag"]),
        ):
            enum = ast.literal_eval(described[name]["edit_method"])["enum"]
            self.assertEqual([one["value"] for one in enum], choices)
        values = client.get_configuration(WAIT)
        self.assertEqual((values["cost_limit"], values["edge_weight"]), (10.0, "mean"))

        self.assertTrue(wait_until(lambda: self.newest(COMBINED_COSTS) is not None))
        before = self.newest(COMBINED_COSTS)
        finite = np.isfinite(before)
        answer = client.update_configuration({"combination": "normalized", "cost_limit": 3.0})
        self.assertEqual((answer["combination"], answer["cost_limit"]), ("normalized", 3.0))
        self.assertTrue(wait_until(lambda: not np.array_equal(self.newest(COMBINED_COSTS), before)))
        self.assertLessEqual(self.newest(COMBINED_COSTS)[finite].max(), 0.5)  # its factor
        self.assertEqual(
            client.update_configuration({"default_layer": "flag"})["default_layer"], "flag"
        )
        self.assertTrue(wait_until(lambda: not self.newest(COMBINED_COSTS).any()))
        self.assertEqual(client.update_configuration({"layer_factor": -3})["layer_factor"], 0.0)
        output = end_node(self.node)
        self.assertIn("edge_weight is 'nonsense'", output)
        self.assertIn("cost_limit is 20, outside of [0.0, 10.0]: 10.0 is used", output)


if __name__ == "__main__":
    rospy.init_node("reconfigure_check")
    rostest.rosrun("mesh_map", "reconfigure_check", ReconfigureTest)
