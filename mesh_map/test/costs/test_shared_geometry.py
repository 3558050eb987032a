"""Robots with different layers share one file without computing its geometry again."""

import gc
import json
import subprocess
import sys
from pathlib import Path
import weakref

import numpy as np
import pytest
from kernel_calls import counted_kernels
from mesh_map.io.map_source import MapSource
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from meshes import terrain

GEOMETRY = ("topology", "normals", "edge_lengths")  # in the names of their kernels


def layer(name, radius):
    return {"name": name, "type": "mesh_layers/HeightDiffLayer", "params": {"radius": radius}}


CLIMBER = [layer("steps", 0.3), layer("wide", 0.6)]
WHEELED = [layer("height_diff", 0.3), layer("fine", 0.2)]


@pytest.fixture
def path(tmp_path):
    mesh = terrain(12)
    return MapFile.write(str(tmp_path / "map.h5"), Mesh(mesh.vertices, mesh.faces)).path


def started(path, layers, frame_id="", **options):
    """Source and map of a robot, as the node has them when everything can be published."""
    source = MapSource(path)
    mesh_map = source.make_map(frame_id, **options)
    mesh_map.compute_layers(layers, stored=source.stored_costs)
    assert list(mesh_map.layers) == [entry["name"] for entry in layers]
    assert np.isfinite(mesh_map.vertex_normals).all() and np.isfinite(mesh_map.costs).any()
    return source, mesh_map


def of_geometry(counts):
    """The kernels that compute what does not depend on layers."""
    return {name: n for name, n in counts.items() if any(part in name for part in GEOMETRY)}


def test_in_one_process_the_geometry_is_there_once(path):
    with counted_kernels() as counts:
        _, climber = started(path, CLIMBER)
        _, wheeled = started(path, WHEELED)
        assert climber.geometry.edge_lengths is wheeled.geometry.edge_lengths
    assert climber is not wheeled and climber.geometry is wheeled.geometry
    found = of_geometry(counts)
    assert len(found) >= 4 and set(found.values()) == {1}
    assert list(climber.layers) == ["steps", "wide"] and list(wheeled.layers)[0] == "height_diff"


@pytest.mark.parametrize(
    "other", [{"frame_id": "hall"}, {"up_direction": (0, 1, 0)}, {"normals": "angle"}]
)
def test_another_view_of_the_geometry_is_not_shared(path, other):
    assert MapSource(path).make_map(**other).geometry is not MapSource(path).make_map().geometry


@pytest.mark.parametrize("up", [(0, 0, 1), [0, 0, 2], np.array([0, 0, 1.0])])
def test_a_view_may_be_said_in_many_ways(path, up):
    usual = MapSource(path).make_map()
    same = MapSource(path).make_map(up_direction=up, orient=False, normals="mean")
    assert same.geometry is usual.geometry


@pytest.mark.parametrize("options", [{"orient": True}, {"up_direction": (0, 1, 0)}])
def test_the_same_view_is_shared(path, options):
    with counted_kernels() as counts:
        first = MapSource(path).make_map(**options)
        first.compute_layers(CLIMBER)
        second = MapSource(path).make_map(**options)
        assert first.geometry is second.geometry and second.vertex_normals is not None
    found = of_geometry(counts)
    assert found["_vertex_normals"] == 1 and (found["_topology"] == 1 or "orient" in options)


def test_another_geometry_is_not_shared(path):
    geometries = [MapSource(path).make_map().geometry]
    mesh = MapFile(path).read(())
    MapFile(path).update(Edit(vertex_normals=np.tile(np.float32([0, 0, 1]), (144, 1))))
    geometries.append(MapSource(path).make_map().geometry)
    mesh.vertices = mesh.vertices + np.float32(1)
    MapFile.write(path, mesh)
    geometries.append(MapSource(path).make_map().geometry)
    assert len(set(map(id, geometries))) == 3
    assert len({geometry.content_uuid for geometry in geometries}) == 2


def test_it_goes_with_the_last_map(path):
    first, second = MapSource(path).make_map(), MapSource(path).make_map()
    watched = weakref.ref(first.geometry)
    del first
    gc.collect()
    assert watched() is second.geometry
    del second
    gc.collect()
    assert watched() is None


def test_the_identity_of_a_file_of_ours_is_not_computed_again(path, monkeypatch):
    """It was when the file was read."""
    source = MapSource(path)
    with monkeypatch.context() as patch:
        patch.setattr("mesh_map.geometry.mesh_geometry.geometry_uuid", None)
        assert source.make_map().geometry.content_uuid == MapFile(path).uuid


ROBOTS = """
import json, os, sys
sys.path[:0] = json.loads(sys.argv[1])
from kernel_calls import counted_kernels
from test_shared_geometry import started
for line in sys.stdin:
    if os.fork() == 0:
        with counted_kernels() as counts:
            source, mesh_map = started(*json.loads(line))
            source.save_layers(mesh_map.layers)
        print(json.dumps(counts))
        sys.exit()
    assert os.wait()[1] == 0
"""


@pytest.fixture
def robot_in_a_process(path):
    """Which kernels a robot with these layers called that started, and stored them, in a process of
    its own. All are forked from one that has only imported what they need.
    """
    room = Path(__file__).resolve().parent
    folders = json.dumps([str(room), str(room.parent / "support")])
    command = [sys.executable, "-c", ROBOTS, folders]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "universal_newlines": True}

    def robot(layers):
        print(json.dumps([path, layers]), file=robots.stdin, flush=True)
        return json.loads(robots.stdout.readline())

    with subprocess.Popen(command, **pipes) as robots:
        yield robot
    assert robots.returncode == 0


def test_another_process_takes_it_from_the_file(path, robot_in_a_process):
    first = robot_in_a_process(CLIMBER)
    assert len(of_geometry(first)) >= 3 and set(of_geometry(first).values()) == {1}
    assert set(first) > set(of_geometry(first))
    assert robot_in_a_process(CLIMBER) == {}
    # one of its layers is that of the first robot by another name
    second = robot_in_a_process(WHEELED)
    assert of_geometry(second) == {"_topology": 1} and set(second) < set(first)
    assert robot_in_a_process(WHEELED) == robot_in_a_process(CLIMBER) == {}
    assert robot_in_a_process(CLIMBER[:1] + WHEELED[1:]) == {}
    assert MapFile(path).layer_names() == ["fine", "height_diff", "steps", "wide"]
