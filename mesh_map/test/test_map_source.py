"""Maps from files, and layers stored in them."""

import math

import numpy as np
import pytest
from meshes import terrain
from mesh_map.errors import MeshMapError
from mesh_map.map_source import MapSource, map_parameters
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.mesh import Mesh

HEIGHT_DIFF = {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}
STORED = {"type": "mesh_layers/HeightDiffLayer", "radius": 0.3}


@pytest.fixture
def map_file(tmp_path):
    mesh = terrain(12)
    path = str(tmp_path / "map.h5")
    return MapFile.write(path, Mesh(mesh.vertices, mesh.faces, frame_id="hall"))


def costs_of(path, layers=(HEIGHT_DIFF,)):
    source = MapSource(path)
    mesh_map = source.make_map()
    mesh_map.compute_layers(list(layers), stored=source.stored_costs)
    return mesh_map.layers["height_diff"].result.costs


def test_a_map_file(map_file):
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    assert source.is_map_file and mesh_map.frame_id == "hall" and mesh_map.uuid == map_file.uuid
    assert np.array_equal(mesh_map.vertices, map_file.vertices)
    assert np.array_equal(mesh_map.faces, map_file.faces)
    assert source.make_map("floor").frame_id == "floor"


def test_layers_are_reused_when_their_parameters_are_the_same(map_file):
    marked = np.linspace(0, 1, 144).astype(np.float32)
    map_file.write_layers({"height_diff": (marked, STORED)})
    assert np.array_equal(costs_of(map_file.path), marked)
    threshold = dict(HEIGHT_DIFF, params={"threshold": 0.5, "factor": 0.1})
    assert np.array_equal(costs_of(map_file.path, [threshold]), marked)
    radius = dict(HEIGHT_DIFF, params={"radius": 0.2})
    assert not np.array_equal(costs_of(map_file.path, [radius]), marked)


@pytest.mark.parametrize("parameters", [None, {}, dict(STORED, radius=0.2), dict(STORED, type="x")])
def test_layers_of_other_parameters_are_computed(map_file, parameters):
    fresh = costs_of(map_file.path)
    map_file.write_layers({"height_diff": (np.zeros(144, np.float32), parameters)})
    assert fresh.any() and np.array_equal(costs_of(map_file.path), fresh)


def test_layers_of_a_replaced_file_are_computed_anew(map_file, caplog):
    fresh = costs_of(map_file.path)
    map_file.write_layers({"height_diff": (np.full(144, 0.5, np.float32), STORED)})
    source = MapSource(map_file.path)
    MapFile.write(map_file.path, Mesh(np.ones((3, 3), np.float32), np.array([[0, 1, 2]])))
    mesh_map = source.make_map()
    mesh_map.compute_layers([HEIGHT_DIFF], stored=source.stored_costs)
    assert np.array_equal(mesh_map.layers["height_diff"].result.costs, fresh)
    assert "layer height_diff is computed anew" in caplog.text and "replaced" in caplog.text


def test_only_what_is_needed_is_read(map_file, monkeypatch):
    """A map may hold textures of gigabytes."""
    seen = []
    monkeypatch.setattr(
        type(MapSource(map_file.path)._members),
        "read",
        lambda self, members=None: seen.append(members) or map_file.read(members),
    )
    MapSource(map_file.path)
    assert seen == [("vertex_normals", "vertex_colors")]


def test_save_and_load(map_file):
    before = map_file.layer_names()
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    mesh_map.compute_layers([HEIGHT_DIFF, dict(HEIGHT_DIFF, name="wide", params={"radius": 0.6})])
    assert map_file.layer_names() == before == []
    assert source.save_layers(mesh_map.layers) == ["height_diff", "wide"]
    saved = MapFile(map_file.path)
    assert saved.layer_names() == ["height_diff", "wide"]
    assert saved.layer_parameters("wide") == dict(STORED, radius=0.6)
    for name, layer in mesh_map.layers.items():
        assert np.array_equal(saved.vertex_costs(name), layer.result.costs)
    assert saved.uuid == mesh_map.uuid


def write_obj(path):
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0.25\nf 1 2 3\n")
    return str(path)


def test_a_mesh_file_is_a_map_too(tmp_path):
    source = MapSource(write_obj(tmp_path / "mesh.obj"))
    mesh_map = source.make_map()
    assert not source.is_map_file and mesh_map.frame_id == "map" and len(mesh_map.uuid) == 36
    mesh_map.compute_layers([dict(HEIGHT_DIFF, params={"radius": 1.0})], stored=source.stored_costs)
    assert mesh_map.layers["height_diff"].result.costs.tolist() == [0, 0, 0]
    with pytest.raises(MeshMapError, match="mesh.obj is no map file.*mesh_tool import"):
        source.save_layers(mesh_map.layers)


def test_nothing_to_save(map_file):
    with pytest.raises(MeshMapError, match="there are no layers to store"):
        MapSource(map_file.path).save_layers({})


@pytest.mark.parametrize(
    "content", [None, b"", b"version https://git-lfs.github.com/spec/v1\n", b"\x89HDF\r\n\x1a\n"]
)
def test_files_that_are_no_maps(tmp_path, content):
    path = tmp_path / "map.h5"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(MeshMapError) as error:
        MapSource(str(path))
    assert str(path) in str(error.value) and "\n" not in str(error.value)
    with pytest.raises(MeshMapError):
        MapSource(str(tmp_path))


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
        ({"server_url": "http://a"}, r"\(server_url\) are not supported \(set mesh_file\)"),
        ("map.h5", "the parameters are 'map.h5', not a dictionary"),
    ],
)
def test_bad_parameters_are_refused(values, message):
    with pytest.raises(MeshMapError, match=message):
        map_parameters(values)
