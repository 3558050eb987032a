"""Parameters of a map as ROS users write them."""

import math

import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from meshes import terrain

HEIGHT_DIFF = {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}


def test_parameters_as_ros_users_write_them():
    """The map of a robot in the field, as rosparam gives it."""
    parameters = map_parameters(
        {
            "mesh_file": "map.h5",
            "mesh_part": "mesh",
            "global_frame": "map",
            "robot_frame": "base_footprint",
            "layers": [
                {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"},
                {"name": "inflation", "type": "mesh_layers/InflationLayer"},
            ],
            "height_diff": {"factor": 0.7, "threshold": 0.7, "radius": 0.0},
        }
    )
    assert (parameters.mesh_file, parameters.mesh_part) == ("map.h5", "mesh")
    assert parameters.global_frame == "map"
    assert parameters.layers == [
        dict(HEIGHT_DIFF, params={"factor": 0.7, "threshold": 0.7, "radius": 0.0}),
        {"name": "inflation", "type": "mesh_layers/InflationLayer", "params": {}},
    ]
    least = map_parameters({"mesh_file": "a.ply"})
    assert (least.mesh_part, least.global_frame, least.layers) == (None, "", [])
    usual = {"up_direction": (0, 0, 1), "orient": False, "normals": "mean", "max_edge_length": 0.0}
    assert least.geometry == usual


def test_misspelled_parameters_are_said(caplog):
    typos = {"max_edgelength": 0.2, "orgin": [1, 1, 1], "edge_cost_facto": 3, "layer": []}
    others = {"shutdown_timeout": 5.0, "costs_period": 1.0, "normal": {"threshold": 1.0}}
    map_parameters({"mesh_file": "map.h5", **typos, **others})
    meant = ("max_edge_length", "origin", "edge_cost_factor", "layers")
    expected = ["the parameter %s is not known; is %s meant?" % pair for pair in zip(typos, meant)]
    assert [record.message for record in caplog.records] == expected


@pytest.mark.parametrize("ros_2", [False, True])
def test_misspelled_names_of_layers_are_said(ros_2, caplog):
    """Their defaults would count, without a word: those of another robot."""
    kind = "mesh_layers/HeightDiffLayer"
    layers = ["height_diff", "steps"] if ros_2 else [{"name": "height_diff", "type": kind}]
    sections = {"heightdiff": {"threshold": 0.12}, "inflation": {"factor": 1.0}}
    map_parameters({"mesh_file": "map.h5", "layers": layers, **sections})
    said = "the parameter heightdiff is not known; is height_diff meant?"
    assert [record.message for record in caplog.records] == [said]
    caplog.clear()
    for odd in (None, 5, [None, 5, {"name": 5}], "height_diff"):
        map_parameters({"mesh_file": "map.h5", "layers": odd, **sections})
    assert not caplog.records


def test_parameters_in_the_entry_of_a_layer_count():
    mesh = terrain(12)
    entry = {"name": "steepness", "type": "mesh_layers/SteepnessLayer", "threshold": 0.5}
    values = {"mesh_file": "map.h5", "layers": [dict(entry, factor=0.5)]}
    for own, threshold in (({}, 0.5), ({"steepness": {"threshold": 0.25}}, 0.25)):
        mesh_map = MeshMap(mesh.vertices, mesh.faces)
        mesh_map.compute_layers(map_parameters({**values, **own}).layers)
        params = mesh_map.layers["steepness"].params
        assert (params["threshold"], params["factor"]) == (threshold, 0.5)


def test_parameters_as_for_ros_2():
    values = {
        "mesh_file": "a.h5",
        "layers": ["border", "static"],
        "border": {"type": "mesh_layers/BorderLayer", "threshold": 0.2},
        "static": {"type": "mesh_layers/MaxCombinationLayer", "inputs": ["border"]},
    }
    assert map_parameters(values).layers == [
        {"name": "border", "type": "mesh_layers/BorderLayer", "params": {"threshold": 0.2}},
        {
            "name": "static",
            "type": "mesh_layers/MaxCombinationLayer",
            "params": {"inputs": ["border"]},
        },
    ]
    assert values["border"]["type"] == "mesh_layers/BorderLayer"
    named = map_parameters({"mesh_file": "a.h5", "layers": ["border", "x"], "border": {"a": 1}})
    assert named.layers == [{"name": "border", "params": {"a": 1}}, "x"]


def test_parameters_of_the_geometry(tmp_path):
    mesh = terrain(12)
    map_file = MapFile.write(str(tmp_path / "map.h5"), Mesh(mesh.vertices, mesh.faces))
    values = {"up_direction": [0, 2, 0], "orient": True, "normals": "angle"}
    parameters = map_parameters(dict(values, mesh_file=map_file.path))
    mesh_map = MapSource(map_file.path).make_map(**parameters.geometry)
    assert mesh_map.geometry.up.tolist() == [0, 1, 0]
    with pytest.raises(MeshMapError, match="up_direction"):
        MapSource(map_file.path).make_map(up_direction=(0, 0, 0))


def test_layers_of_a_wrong_shape_are_passed_on_to_be_named():
    for layers in ("height_diff", {"name": "a"}, None, 3):
        assert map_parameters({"mesh_file": "a", "layers": layers}).layers == layers
    odd = [["a"], {"type": "t"}, {"name": math.nan}, {"name": "a", "params": {"factor": 1.0}}]
    assert map_parameters({"mesh_file": "a", "layers": odd}).layers == odd


@pytest.mark.parametrize(
    "values, message",
    [
        ({}, "mesh_file is not set"),
        ({"mesh_file": ""}, "mesh_file is not set"),
        ({"mesh_file": 3}, "mesh_file is 3, but it has to be a string"),
        ({"mesh_file": "a", "mesh_part": ["mesh"]}, "mesh_part is"),
        ({"mesh_file": "a", "orient": 1}, "orient is 1, but it has to be a boolean"),
        (
            {"mesh_file": "a", "normals": "best"},
            "normals is 'best', but it has to be one of mean, angle",
        ),
        ({"mesh_file": "a", "up_direction": "z"}, "up_direction is 'z', but it has to be a list"),
        ({"server_url": "http://a"}, r"\(server_url\) are not supported \(set mesh_file\)"),
        ("map.h5", "the parameters are 'map.h5', not a dictionary"),
    ],
)
def test_bad_parameters_are_refused(values, message):
    with pytest.raises(MeshMapError, match=message):
        map_parameters(values)
