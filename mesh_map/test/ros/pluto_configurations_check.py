#!/usr/bin/python3
"""Configurations of release 1.x load as they are."""

import logging
import os
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
import yaml
from dynamic_reconfigure.client import Client
from map_node import WAIT, costs_of
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.ros import MeshMapServer
from mesh_msgs import zoo
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

CONFIGURATIONS = yaml.safe_load(
    Path(__file__).with_name("pluto_configurations.yaml").read_text(encoding="utf-8")
)


class Warnings(logging.Handler):
    """What the library warns of."""

    def __init__(self):
        super().__init__(logging.WARNING)
        self.lines = []

    def emit(self, record):
        self.lines.append(record.getMessage())


class PlutoConfigurations(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.path = os.path.join(cls.folder, "map.h5")
        world = zoo.outdoor_world(faces=3000)
        MapFile.write(cls.path, Mesh(world.vertices, world.faces))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def check(self, dataset):
        given = CONFIGURATIONS[dataset]
        rospy.set_param("~" + dataset, dict(given, mesh_file=self.path))
        warnings = Warnings()
        logging.getLogger("mesh_map").addHandler(warnings)
        self.addCleanup(logging.getLogger("mesh_map").removeHandler, warnings)
        server = MeshMapServer("~" + dataset)
        self.addCleanup(server.shutdown)
        mesh_map = server.load()
        names = [layer["name"] for layer in given["layers"]]
        self.assertEqual((list(mesh_map.layers), mesh_map.layer_errors), (names, {}))
        clamped = []
        for name in names:
            for parameter, value in given[name].items():
                found = mesh_map.layers[name].params[parameter]
                if found != value:
                    clamped.append((name, parameter, found))
        # The world is coarser than any robot of these configurations, which is said, too.
        coarse = [line for line in warnings.lines if "is in faces with edges longer" in line]
        # So is a radius within which no upright step rises above the threshold.
        steps = mesh_map.layers["height_diff"].params
        narrow = int(not steps["radius"] > steps["threshold"])
        said = [line for line in warnings.lines if "is not above threshold" in line]
        found = (len(warnings.lines), len(coarse), len(said))
        self.assertEqual(found, (len(clamped) + 1 + narrow, 1, narrow), warnings.lines)
        costs = costs_of(server.namespace + "/vertex_costs")
        self.addCleanup(costs.unregister)
        self.assertTrue(wait_until(lambda: set(costs.newest) == {*names, COMBINED_COSTS}))
        combined = costs.newest[COMBINED_COSTS].mesh_vertex_costs.costs
        self.assertTrue(np.isfinite(combined).any() and not np.isnan(combined).any())
        for name in names:
            client = Client("%s/%s" % (server.namespace, name), timeout=WAIT)
            values = client.get_configuration(WAIT)
            client.close()
            for parameter in given[name]:
                self.assertEqual(values[parameter], mesh_map.layers[name].params[parameter])
        return clamped

    def test_all_are_there(self):
        tested = {name[5:] for name in dir(self) if name.startswith("test_")} - {"all_are_there"}
        self.assertEqual(tested, set(CONFIGURATIONS))

    def test_botanical_garden_osnabrueck(self):
        self.assertEqual(self.check("botanical_garden_osnabrueck"), [])

    def test_stone_quarry_brockum(self):
        self.assertEqual(self.check("stone_quarry_brockum"), [])

    def test_physics_campus_westerberg(self):
        clamped = self.check("physics_campus_westerberg")
        self.assertEqual(clamped, [("height_diff", "radius", 0.02)])

    def test_farmers_pit_stemwede(self):
        self.assertEqual(self.check("farmers_pit_stemwede"), [])

    def test_market_garden_ibbenbueren_all(self):
        self.assertEqual(self.check("market_garden_ibbenbueren_all"), [])

    def test_market_garden_ibbenbueren_inner(self):
        self.assertEqual(self.check("market_garden_ibbenbueren_inner"), [])


if __name__ == "__main__":
    rospy.init_node("pluto_configurations_check")
    rostest.rosrun("mesh_map", "pluto_configurations_check", PlutoConfigurations)
