"""Parameters and arguments of the layer of obstacles, good and bad."""

import math

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.layers.obstacle import ObstacleLayer
from mesh_map.map.mesh_map import MeshMap

INF, NAN = math.inf, math.nan


def floor_map():
    """Ten by ten meters of two faces: face 0 where x > y."""
    vertices = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], np.float32)
    return MeshMap(vertices, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))


def test_the_declared_parameters_are_those_of_the_sheet_and_ours():
    declared = {p.name: (p.default, p.minimum, p.maximum) for p in ObstacleLayer.PARAMETERS}
    assert declared["robot_height"] == (INF, 0.0, INF)
    assert declared["max_obstacle_dist"] == (INF, 0.0, INF)
    assert declared["tf_tolerance"][0] == 0.1 and declared["down_axis"][0] == (0.0, 0.0, -1.0)
    layer = ObstacleLayer("o", {"robot_height": 0.7, "max_obstacle_dist": 10, "topic": "points"})
    assert layer.warnings == [] and layer.params["max_obstacle_dist"] == 10.0
    assert ObstacleLayer("o", {"down_axis": [0, 1, 0]}).params["down_axis"] == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    "name, value",
    [
        ("down_axis", value)
        for value in ([0, 0, 0], [1, 2], "down", [0, 0, NAN], [0, 0, "1"], 3, None)
    ]
    + [("qos", "best"), ("topic", 3), ("clearing", 1), ("decay", NAN), ("robot_height", "high")],
)
def test_bad_parameters_are_refused(name, value):
    with pytest.raises(MeshMapError, match="^%s is " % name):
        ObstacleLayer("o", {name: value})


def test_bad_arguments_are_refused():
    mesh_map, layer = floor_map(), ObstacleLayer("o")
    layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 0.0)
    good = {"points": [[-1, 0, 0.5]], "origin": (0, 0, 1), "stamp": 1.0, "down": (0, 0, -1)}
    for name, value, message in (
        ("points", [[1, 2]], "points has to have the shape"),
        ("points", "points", "points has to be numbers"),
        ("origin", (1, 2), "origin has to have the shape"),
        ("stamp", NAN, "the time has to be finite"),
        ("stamp", None, "the time has to be a number"),
        ("down", (0, 0, 0), "down has to be a direction"),
        ("down", (0, NAN, 1), "down has to be a direction"),
    ):
        with pytest.raises(ValueError, match=message):
            layer.insert_cloud(mesh_map, **dict(good, **{name: value}))
    with pytest.raises(ValueError, match="the time has to be finite"):
        layer.decay(INF)
    assert layer.marked_faces.tolist() == [0]


@pytest.mark.parametrize("limit", [1e155, 1.7976931348623157e308])
def test_limits_of_any_size_are_as_good_as_infinite_ones(limit):
    """Programs that know no infinite numbers write the largest one."""
    layer = ObstacleLayer("o", {"max_obstacle_dist": limit, "robot_height": limit})
    assert layer.insert_cloud(floor_map(), [[1, 0, 0.5], [9, 9, 9]], (0, 0, 1), 0.0) == 1
    assert layer.last_cloud.out_of_range == 0


@pytest.mark.parametrize(
    "values, warning",
    [
        ({"robot_height": 0.1, "min_obstacle_height": 0.1}, "min_obstacle_height 0.1 is not below"),
        ({"robot_height": 0}, "min_obstacle_height 0 is not below robot_height 0: no point"),
        ({"min_obstacle_dist": 5, "max_obstacle_dist": 4}, "min_obstacle_dist 5 is not below"),
    ],
)
def test_limits_between_which_there_is_nothing_are_said(values, warning):
    layer = ObstacleLayer("o", values)
    assert len(layer.warnings) == 1 and warning in layer.warnings[0]
    _, warnings = ObstacleLayer("o").checked_changes(values)
    assert warnings == layer.warnings
    layer.insert_cloud(floor_map(), [[1, 0, 0.003 + z / 50] for z in range(50)], (0, 0, 1), 0.0)
    assert layer.last_cloud.obstacles == 0
