"""The benchmark of layers measures what it says, and its peers agree with mesh_map."""
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs import zoo
from mesh_msgs.testing import wait_until
from mesh_tools_test.base.noisy_world import layer, map_with, noisy_world
from mesh_tools_test.layers import changing, computing, peers, starting

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/layers.py"


@pytest.fixture(scope="module")
def world():
    return noisy_world(8_000)


def test_the_tree_agrees_where_all_is_connected():
    plane = zoo.jittered_plane(cells=30, size=6.0)
    vertices = plane.vertices.copy()
    vertices[:, 2] = np.random.default_rng(0).normal(0, 0.03, len(vertices))
    made = map_with(
        MeshGeometry(vertices, plane.faces),
        [layer("h", "HeightDiff", radius=0.5), layer("r", "Roughness", radius=0.5)],
    )
    angles = peers.numpy_mean_angles(made.vertex_normals, made.topology.edges)
    height, rough = peers.kdtree_statistics(made.vertices, angles, 0.5, 3)
    np.testing.assert_allclose(made.layers["h"].result.costs[::3], height, atol=1e-6)
    np.testing.assert_allclose(made.layers["r"].result.costs[::3], rough, atol=1e-3)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of numba itself
def test_numba_agrees(world):
    compiled = peers.numba_statistics()
    if compiled is None:
        pytest.skip("python3-numba is not installed")
    made = map_with(
        world.fresh_geometry(),
        [layer("h", "HeightDiff", radius=0.6), layer("r", "Roughness", radius=0.6)],
    )
    t = made.topology
    angles = peers.numpy_mean_angles(made.vertex_normals, t.edges)
    height, rough = compiled(made.vertices, t.neighbor_offsets, t.neighbors, angles, 0.6, 2)
    np.testing.assert_allclose(height, made.layers["h"].result.costs, atol=1e-6)
    np.testing.assert_allclose(rough, made.layers["r"].result.costs, atol=2e-3)


def test_ways_along_edges_are_no_shorter_than_over_the_surface(world):
    made = map_with(
        world.fresh_geometry(),
        [
            layer("h", "HeightDiff", threshold=0.4),
            layer("i", "Inflation", inscribed_radius=0.8, inflation_radius=2.0),
        ],
    )
    lethal = made.layers["h"].result.lethal
    ways = peers.scipy_distances(made.topology, made.geometry.edge_lengths, lethal, 2.0)
    near = (ways > 0) & (ways <= 0.79)
    assert near.sum() > 20 and (made.layers["i"].result.costs[near] == 1.0).all()


def test_clouds_meet_the_map(world):
    made = map_with(world.fresh_geometry(), [layer("o", "Obstacle", topic="points")])
    both, origin = changing.clouds(made)
    assert [len(cloud) for cloud in both] == [changing.POINTS] * 2
    marked = made.layers["o"].insert_cloud(made, both[0], origin, 1.0)
    made.refresh_layer("o")
    assert marked > 10 and np.isposinf(made.costs).sum() > 10


def test_clouds_are_measured_while_a_layer_is_computed(world):
    figures = changing.meanwhile(world, 1)
    assert [figure.peer for figure in figures] == ["without that"] * 2
    assert [figure.floor for figure in figures] == [150.0, None]
    assert 0 < figures[0].value <= figures[1].value


def test_clouds_do_not_wait_for_what_is_measured_beside_them(world, monkeypatch):
    """All that come are measured, also those for which a newer one is taken."""
    made = map_with(world.fresh_geometry(), [layer("obstacle", "Obstacle", topic="points")])
    sensor, came, taken = changing._Sensor(made), [], []
    insert = made.layers["obstacle"].insert_cloud

    def slow(*arguments):
        taken.append(arguments)
        assert wait_until(lambda: len(came) >= 5)  # so the next ones do not wait for it
        return insert(*arguments)

    monkeypatch.setattr(made.layers["obstacle"], "insert_cloud", slow)
    sensor.see(lambda: len(came) < 5 and not came.append(len(sensor.delays)))
    assert came == [0] * 5 and len(sensor.delays) == 5
    assert 2 <= len(taken) < 5 and sensor.delays[0] > 4 * 1000 * changing.PERIOD - 1


def test_a_map_with_stored_layers_computes_none(world, tmp_path):
    path = str(tmp_path / "map.h5")
    starting.stored_map(world, path)
    source = starting.MapSource(path)
    made = source.make_map()
    asked = {}

    def stored(name, fingerprint):
        asked[name] = source.stored_costs(name, fingerprint)
        return asked[name]

    made.compute_layers(starting.CONFIG, None, stored)
    assert sorted(asked) == sorted(entry["name"] for entry in starting.CONFIG)
    assert all(costs is not None for costs in asked.values())


def test_all_parts_give_figures(tmp_path):
    parts = list(computing.PARTS) + list(changing.PARTS)
    command = [str(SCRIPT), "--faces", "5000", "--repeats", "1", "--only", *parts]
    subprocess.run(command + ["--json", str(tmp_path / "f.json")], check=True)
    figures = json.loads((tmp_path / "f.json").read_text())
    assert len(figures) > 20 and all(figure["value"] > 0 for figure in figures)
    assert {"topology", "inflation 0.25/0.4 m", "cloud of 100,000 points"} <= {
        figure["name"] for figure in figures
    }


def test_the_node_starts_from_stored_layers(tmp_path):
    command = [str(SCRIPT), "--faces", "5000", "--repeats", "1", "--only", "start"]
    subprocess.run(command + ["--json", str(tmp_path / "f.json")], check=True)
    figures = {f["name"]: f["value"] for f in json.loads((tmp_path / "f.json").read_text())}
    assert 0 < figures["node: start to the mesh"] <= figures["node: start to all topics"]
    assert figures["memory of a map with 5 layers"] > 0
