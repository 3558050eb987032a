"""Parameters of the layers as both releases have them, maps of the field, and bad input."""

import logging
import math

import numpy as np
import pytest
from layer_calls import made
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from meshes import BOTANICAL, TRAY, data_mesh, terrain

NAMES = {
    "height_diff": "HeightDiff",
    "roughness": "Roughness",
    "steepness": "Steepness",
    "inflation": "Inflation",
}


def entry(name, kind="", **params):
    return {
        "name": name,
        "type": "mesh_layers/%sLayer" % (kind or NAMES[name]),
        "params": params,
    }


def inflation(inflated, inscribed, lethal, value):
    return entry(
        "inflation",
        inflation_radius=inflated,
        inscribed_radius=inscribed,
        lethal_value=lethal,
        inscribed_value=value,
        repulsive_field=False,
        factor=1.0,
    )


def limit(name, threshold, **params):
    return entry(name, threshold=threshold, factor=params.pop("factor", 1.0), **params)


# What the users of the robot Pluto have in their *_map.yaml.
FIELD = {
    "botanical_garden": [
        limit("height_diff", 0.1),
        limit("roughness", 0.6),
        inflation(0.25, 0.15, 1, 0.4),
    ],
    "stone_quarry": [
        limit("height_diff", 0.2),
        limit("roughness", 0.7),
        inflation(1.0, 0.3, 6, 4),
    ],
    "physics_campus": [
        limit("height_diff", 0.7, radius=0.0, factor=0.7),
        limit("steepness", 0.3),
        inflation(0.7, 0.2, 1, 4),
    ],
    "farmers_pit": [
        limit("height_diff", 0.1),
        limit("roughness", 0.6),
        limit("steepness", 0.5),
        inflation(1.5, 0.4, 1, 4),
    ],
    "market_garden_all": [
        limit("height_diff", 0.12),
        limit("steepness", 0.8),
        inflation(1.0, 1.0, 1, 0.4),
    ],
    "market_garden_inner": [limit("height_diff", 0.08)],
}
# And the tutorials of the release for ROS 2.
LATER = [
    entry("border", "Border", threshold=0.2, border_cost=1.0),
    entry("height_diff", threshold=0.2),
    entry("roughness", threshold=0.8),
    entry("static", "AvgCombination", inputs=["height_diff", "border", "roughness"]),
    entry(
        "static_inflation",
        "Inflation",
        inputs=["static"],
        inflation_radius=1.5,
        inscribed_radius=0.4,
        lethal_value=math.inf,
        inscribed_value=1.0,
        cost_scaling_factor=2.0,
        repulsive_field=False,
    ),
    entry("obstacle", "Obstacle", robot_height=0.7, max_obstacle_dist=10.0, topic="points"),
    entry("obstacle_inflation", "Inflation", inputs=["obstacle"], inflation_radius=1.5),
    entry("final", "MaxCombination", inputs=["static_inflation", "obstacle_inflation", "static"]),
]


@pytest.mark.parametrize("name", FIELD)
@pytest.mark.parametrize("mesh_name", ["terrain", TRAY, BOTANICAL])
def test_configurations_of_the_field(name, mesh_name, caplog):
    mesh = terrain() if mesh_name == "terrain" else data_mesh(mesh_name)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    with caplog.at_level(logging.WARNING, "mesh_map"):
        mesh_map.compute_layers(FIELD[name])
    assert mesh_map.layer_errors == {}
    assert list(mesh_map.layers) == [entry["name"] for entry in FIELD[name]]
    of_campus = ["radius is 0.0", "radius, 0.02 m, is not above threshold, 0.7 m"]
    expected = of_campus if name == "physics_campus" else []
    warnings = [record.getMessage() for record in caplog.records]
    assert len(warnings) == len(expected), warnings
    assert all(text in warning for text, warning in zip(expected, warnings))
    costs, lethal = mesh_map.costs, np.zeros(len(mesh.vertices), bool)
    for layer in mesh_map.layers.values():
        assert np.isfinite(layer.result.costs).all()
        lethal |= layer.result.lethal
    assert np.array_equal(np.isposinf(costs), lethal) and not np.isnan(costs).any()
    if "inflation" in mesh_map.layers:
        before = np.any([item.result.lethal for item in list(mesh_map.layers.values())[:-1]], 0)
        found = mesh_map.layers["inflation"].result
        assert np.array_equal(found.lethal, before)
        params = mesh_map.layers["inflation"].params
        assert (found.costs[before] == np.float32(params["lethal_value"])).all()
        assert found.costs[~before].max(initial=0) <= np.float32(params["inscribed_value"])


def test_the_configuration_of_the_later_release():
    mesh = terrain()
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.set_settings(default_layer="final", edge_cost_factor=5.0)
    mesh_map.compute_layers(LATER)
    assert mesh_map.layer_errors == {} and len(mesh_map.layers) == len(LATER)
    final = mesh_map.layers["final"].result
    assert np.array_equal(mesh_map.costs, np.where(final.lethal, np.inf, final.costs))
    assert np.isinf(mesh_map.planning_costs().edge_weights).any()


THRESHOLD = (0.3, 0.01, 3.1415)
RADIUS = (0.3, 0.02, 1.0)
# default, minimum, maximum; the widest of both releases where they differ, or our own
SHEET = {
    "HeightDiff": {
        "threshold": (0.185, 0.05, 1.0),
        "radius": RADIUS,
        "include_vertex": (True,),
    },
    "Roughness": {"threshold": THRESHOLD, "radius": RADIUS, "include_vertex": (False,)},
    "Steepness": {"threshold": THRESHOLD},
    "Ridge": {"threshold": THRESHOLD, "radius": (0.3, 0.01, 1.0)},
    "Border": {"threshold": (0.5, 0.05, 1.0), "border_cost": (1.0, 0.02, 10.0)},
    "Clearance": {"robot_height": (0.5, 0.05, 100.0), "height_inflation": (0.3,)},
    "Collision": {
        "robot_radius": (0.0, 0.0, 5.0),
        "step_height": (0.185, 0.01, 100.0),
        "robot_height": (0.5, 0.05, 100.0),
    },
    "Inflation": {
        "inscribed_radius": (0.25, 0.01, 5.0),
        "inflation_radius": (0.4, 0.01, 10.0),
        "layer_factor": (1.0, 0.0, 1.0),
        "min_contour_size": (3, 0, 100000),
        "lethal_value": (2.0, -1.0, None),
        "inscribed_value": (1.0, 0.0, 100000.0),
        "repulsive_field": (True,),
        "cost_scaling_factor": (1.0, 0.0, 5.0),
    },
    "Obstacle": {
        "robot_height": (math.inf,),
        "max_obstacle_dist": (math.inf,),
        "tf_tolerance": (0.1,),
    },
}


@pytest.mark.parametrize("kind", SHEET)
def test_parameters_of_the_releases(kind):
    known = {parameter.name: parameter for parameter in made(kind).all_parameters()}
    assert (known["factor"].default, known["factor"].minimum, known["factor"].maximum) == (1, 0, 1)
    weight = known["combination_weight"]
    assert (weight.default, weight.minimum, weight.maximum) == (1, 0, 1)
    for name, (default, *limits) in SHEET[kind].items():
        parameter = known[name]
        assert parameter.default == default and type(parameter.default) is type(default), name
        assert parameter.description, name
        if limits:
            assert parameter.minimum == limits[0], name
            assert limits[1] is None or parameter.maximum == limits[1], name


GOOD = entry("height_diff")
BAD_LISTS = {
    "no list": ("height_diff", "layers"),
    "mapping": ({"height_diff": {}}, "layers"),
    "number": (3, "layers"),
    "entry is text": ([GOOD, "roughness"], "layer 1"),
    "no type": ([GOOD, {"name": "x"}], "layer 1"),
    "no name": ([GOOD, {"type": "mesh_layers/RoughnessLayer"}], "layer 1"),
    "name with slash": ([GOOD, entry("a/b", "Roughness")], "layer 1"),
    "empty name": ([GOOD, entry("", "Roughness")], "layer 1"),
    "name is a number": ([GOOD, entry(3, "Roughness")], "layer 1"),
    "twice": ([GOOD, GOOD], "layer 1"),
    "unknown type": ([GOOD, entry("x", "Unknown")], "x"),
    "type is a number": ([GOOD, {"name": "x", "type": 3}], "layer 1"),
    "NaN": ([GOOD, entry("x", "Roughness", radius=math.nan)], "x"),
    "infinite": ([GOOD, entry("x", "Roughness", radius=math.inf)], None),
    "text for a number": ([GOOD, entry("x", "Roughness", radius="0.3")], "x"),
    "list for a number": ([GOOD, entry("x", "Roughness", radius=[0.3])], "x"),
    "boolean for a number": ([GOOD, entry("x", "Roughness", radius=True)], "x"),
    "NaN factor": ([GOOD, entry("x", "Roughness", factor=math.nan)], "x"),
    "reads itself": ([GOOD, entry("x", "MaxCombination", inputs=["x"])], "x"),
    "reads nobody": ([GOOD, entry("x", "MaxCombination", inputs=["y"])], "x"),
    "inputs are text": ([GOOD, entry("x", "MaxCombination", inputs="height_diff")], "x"),
    "parameters are a list": ([GOOD, dict(entry("x", "Border"), params=[1])], "layer 1"),
}


@pytest.mark.parametrize("text", BAD_LISTS)
def test_bad_lists_of_layers(text, caplog):
    """One clear error, and the other layers unharmed."""
    mesh = terrain(12)
    config, name = BAD_LISTS[text]
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    with caplog.at_level(logging.ERROR, "mesh_map"):
        mesh_map.compute_layers(config)
    if name is not None:
        assert list(mesh_map.layer_errors) == [name]
        assert len(caplog.records) == 1 and "\n" not in caplog.records[0].getMessage()
        assert len(mesh_map.layer_errors[name]) > 10
    if isinstance(config, list):
        alone = MeshMap(mesh.vertices, mesh.faces)
        alone.compute_layers([GOOD])
        assert "height_diff" in mesh_map.layers
        found = mesh_map.layers["height_diff"].result
        assert np.array_equal(found.costs, alone.layers["height_diff"].result.costs)
        if name is not None:
            assert np.array_equal(mesh_map.costs, alone.costs)
    else:
        assert not mesh_map.layers and not mesh_map.costs.any()


def test_a_circle_of_inputs(caplog):
    config = [
        entry("a", "MaxCombination", inputs=["c"]),
        entry("b", "SumCombination", inputs=["a"]),
        GOOD,
        entry("c", "MaxCombination", inputs=["b", "height_diff"]),
        entry("d", "MaxCombination", inputs=["height_diff"]),
        entry("e", "MaxCombination", inputs=["c"]),
    ]
    mesh = terrain(12)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    with caplog.at_level(logging.ERROR, "mesh_map"):
        mesh_map.compute_layers(config)
    assert list(mesh_map.layers) == ["height_diff", "d"]
    assert set(mesh_map.layer_errors) == {"a", "b", "c", "e"}
    circles = [r.getMessage() for r in caplog.records if {"a", "b", "c"} <= set(r.getMessage())]
    assert circles


@pytest.mark.parametrize(
    "vertices, faces, text",
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.zeros((0, 3)), "no"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "no"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "face"),
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], "vert"),
        ([[0, 0, 0], [1, 0, 1e60], [0, 1, 0]], [[0, 1, 2]], "vert"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 0xFFFFFFFF]], "face"),
    ],
)
def test_maps_that_are_none(vertices, faces, text):
    with pytest.raises(MeshMapError, match=text):
        MeshMap(np.asarray(vertices, float), np.asarray(faces))


@pytest.mark.parametrize("up", [(0, 0, 0), (0, 0, math.nan), (1, 2), "up", (0, 0, math.inf), None])
def test_directions_that_are_none(up):
    with pytest.raises(MeshMapError, match="up_direction"):
        MeshGeometry(np.eye(3), [[0, 1, 2]], up_direction=up)


def test_parameters_that_are_refused_change_nothing():
    mesh = terrain(12)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers([GOOD, inflation(1.0, 0.3, 6, 4)])
    before, version = mesh_map.costs, mesh_map.planning_costs().version
    for name, values in (
        ("height_diff", {"radius": math.nan}),
        ("height_diff", {"threshold": 0.1, "radius": "wide"}),
        ("inflation", {"inflation_radius": 2.0, "repulsive_field": 3}),
        ("inflation", {"inputs": ["height_diff"]}),
        ("nobody", {"radius": 0.3}),
    ):
        with pytest.raises(MeshMapError):
            mesh_map.set_layer_parameters(name, values)
    for values in ({"combination": "mean"}, {"layer_factor": math.nan}, {"default_layer": "x"}):
        with pytest.raises(MeshMapError):
            mesh_map.set_settings(**values)
    assert mesh_map.costs is before and mesh_map.planning_costs().version == version
