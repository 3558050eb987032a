"""The layers of the demo: every kind that there is, and the same in the server."""
import io
import re

import numpy as np
import pytest
import yaml

from mesh_map.base.errors import PluginError
from mesh_map.base.plugins import find_class
from mesh_map.costs.layer import BASE_CLASS_TYPE
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_map.map.coarse_edges import coarse_remark
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_tools_test.demo import layers, pipeline
from mesh_tools_test.demo.report import Report


@pytest.mark.parametrize("config", [layers.FOR_FILES, layers.FOR_SCANS, layers.FOR_WORLD])
def test_the_server_gets_the_same_layers(config):
    values = yaml.safe_load(layers.server_config(config, 0.5))
    read = map_parameters(dict(values, mesh_file="map.h5"))
    assert read.layers == config and read.geometry["max_edge_length"] == 0.5
    assert values["edge_cost_factor"] == layers.EDGE_COST_FACTOR


def test_the_generated_world_has_one_of_every_kind_that_measures():
    with pytest.raises(PluginError) as error:  # which names those that there are
        find_class("mesh_map", BASE_CLASS_TYPE, "no/Such")
    known = set(re.findall(r"mesh_layers/\w+", str(error.value)))
    combining = {name for name in known if "Combination" in name}
    stored = {"mesh_layers/StoredLayer", "mesh_layers/SpeedLimitLayer"}  # need data of the user
    assert {entry["type"] for entry in layers.FOR_WORLD} == known - combining - stored


def test_the_flower_bed_lies_on_the_straight_way():
    world = outdoor_world(faces=5_000)
    mesh = Mesh(vertices=world.vertices, faces=world.faces)
    label = layers.flower_bed(mesh, (0, 0, 0), (8, 2, 5))
    centers = mesh.vertices[mesh.faces].mean(axis=1)[:, :2]
    inside = (
        np.linalg.norm(centers - [8 * layers.BED_AT, 2 * layers.BED_AT], axis=1) < layers.BED_RADIUS
    )
    assert len(label.faces) and np.array_equal(np.flatnonzero(inside), label.faces)


def test_the_generated_world_leaves_nothing_to_remark(tmp_path):
    made = pipeline.prepare(Report(io.StringIO()), tmp_path, None, 20_000, 0)
    assert coarse_remark(made.mesh_map, {"the robot's radius": layers.MAX_EDGE_LENGTH}) == ""
    assert coarse_remark(MapSource(str(made.path)).make_map(), {"the robot's radius": 0.25}) != ""


@pytest.mark.parametrize("seed", range(3))
def test_start_and_goal_of_the_generated_world_are_connected(tmp_path, seed):
    made = pipeline.prepare(Report(io.StringIO()), tmp_path, None, 20_000, seed)
    assert np.isfinite(made.mesh_map.costs).any() and np.isposinf(made.mesh_map.costs).any()
    mesh_map = made.mesh_map
    goal = mesh_map.nearest_vertex(made.goal, 0.1)[0]
    solver = DijkstraSolver(topology=mesh_map.topology, edge_lengths=mesh_map.geometry.edge_lengths)
    field = solver.solve(goal, mesh_map.costs, pipeline.COST_LIMIT)
    # The start itself may lie within an inflation; planners leave that by the shortest way.
    near = np.linalg.norm(mesh_map.vertices - made.start, axis=1) < 0.5
    assert near.any() and np.isfinite(mesh_map.costs[near]).any()
    least = np.linalg.norm(made.goal - made.start) - 0.5
    assert least < field.potential[near].min() < np.inf
