"""The layer against plain loops, and its update against computing everything."""

import numpy as np
import pytest
from example_mesh_layer.smooth_layer import SmoothLayer
from mesh_map.base.errors import MeshMapError
from mesh_map.base.plugins import find_class
from mesh_map.costs.layer import LayerInput
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo

TYPE = "example_mesh_layer/SmoothLayer"
MESHES = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
meshes = pytest.mark.parametrize("mesh", MESHES, ids=[mesh.name for mesh in MESHES])
params = pytest.mark.parametrize(
    "params", [{}, {"strength": 1.0, "rounds": 4}, {"strength": 0.3, "rounds": 2}, {"strength": 0}]
)


def grid(size):
    """A flat map of size x size vertices."""
    x, y = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    vertices = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    corner = np.arange(size * size).reshape(size, size)[:-1, :-1].reshape(-1, 1)
    faces = np.concatenate([corner + [0, size, 1], corner + [1, size, size + 1]])
    return MeshMap(vertices.astype(np.float32), faces)


def random_input(count, seed):
    """Costs, some of them lethal or unknown; some lethal vertices have finite costs."""
    random = np.random.default_rng(seed)
    costs = random.random(count).astype(np.float32)
    costs[random.random(count) < 0.1] = np.inf
    costs[random.random(count) < 0.1] = np.nan
    return LayerInput(costs, np.isposinf(costs) | (random.random(count) < 0.1), None, 1.0)


def smoothed_slowly(mesh, read, strength=0.5, rounds=1):
    """The layer, vertex by vertex."""
    costs = np.where(read.lethal, np.inf, read.costs.astype(np.float64))
    for _ in range(rounds):
        last = costs.copy()
        for vertex in np.flatnonzero(np.isfinite(last)):
            around = np.unique(mesh.faces[(mesh.faces == vertex).any(1)])
            around = last[around[around != vertex]]
            around = around[np.isfinite(around)]
            if len(around):
                costs[vertex] = (1 - strength) * last[vertex] + strength * around.mean()
    return costs


@meshes
@params
def test_costs_are_those_of_the_formula(mesh, params):
    read = random_input(len(mesh.vertices), 1)
    layer = SmoothLayer("smooth", params)
    mesh_map, inputs = MeshMap(mesh.vertices, mesh.faces), {"a": read}
    result = layer.evaluate(mesh_map, inputs)
    expected = smoothed_slowly(mesh, read, **params)
    np.testing.assert_allclose(result.costs, expected, rtol=1e-6)
    np.testing.assert_array_equal(result.lethal, read.lethal | np.isposinf(read.costs))
    np.testing.assert_array_equal(layer.reuse(result.costs, mesh_map, inputs).lethal, result.lethal)


@params
@pytest.mark.parametrize("changes", [0, 1, 3, 400])
def test_an_update_is_the_same_bit_for_bit(params, changes):
    mesh_map = grid(30)
    layer = SmoothLayer("smooth", params)
    read, other = random_input(900, 2), random_input(900, 3)
    before = layer.evaluate(mesh_map, {"a": read})
    changed = np.sort(np.random.default_rng(4).permutation(900)[:changes]).astype(np.uint32)
    after = LayerInput(read.costs.copy(), read.lethal.copy(), None, 1.0)
    for now, new in zip(after[:2], other[:2]):
        now[changed] = new[changed]
    updated = layer.update(mesh_map, {"a": after}, changed, before)
    computed = layer.evaluate(mesh_map, {"a": after})
    assert np.array_equal(updated.costs.view(np.uint32), computed.costs.view(np.uint32))
    assert np.array_equal(updated.lethal, computed.lethal)
    assert np.array_equal(before.costs, layer.evaluate(mesh_map, {"a": read}).costs, equal_nan=True)


def test_an_update_looks_only_around_the_changes(monkeypatch):
    mesh_map = grid(60)
    layer = SmoothLayer("smooth", {"rounds": 3})
    read = LayerInput(np.ones(3600, np.float32), np.zeros(3600, np.bool_), None, 1.0)
    before = layer.evaluate(mesh_map, {"a": read})
    seen = []
    mixed = SmoothLayer._mixed
    monkeypatch.setattr(
        SmoothLayer, "_mixed", lambda *arguments: seen.append(arguments[3]) or mixed(*arguments)
    )
    layer.update(mesh_map, {"a": read}, np.array([1830], np.uint32), before)
    assert [len(zone) for zone in seen] == sorted((len(zone) for zone in seen), reverse=True)
    assert len(seen) == 3 and 37 == len(seen[-1]) and len(seen[0]) < 100


def test_smoothing_makes_costs_less_different():
    mesh_map = grid(20)
    read = LayerInput(
        np.random.default_rng(5).random(400).astype(np.float32), np.zeros(400, np.bool_), None, 1.0
    )
    spread = [
        float(np.std(SmoothLayer("s", {"rounds": n}).evaluate(mesh_map, {"a": read}).costs))
        for n in (1, 3, 10)
    ]
    assert float(np.std(read.costs)) > spread[0] > spread[1] > spread[2]
    even = LayerInput(np.full(400, 0.25, np.float32), read.lethal, None, 1.0)
    assert (SmoothLayer("s").evaluate(mesh_map, {"a": even}).costs == 0.25).all()


@pytest.mark.parametrize("names, said", [([], "none"), (["a", "b"], "a, b")])
def test_it_has_one_input(names, said):
    inputs = {name: random_input(9, 0) for name in names}
    with pytest.raises(MeshMapError, match=r"has the inputs: %s \(name one" % said):
        SmoothLayer("smooth").compute(grid(3), inputs)


def test_it_is_found_as_a_plugin():
    assert find_class("mesh_map", "mesh_map::Layer", TYPE) is SmoothLayer


def test_in_a_map():
    mesh_map = grid(12)
    height_diff = "mesh_layers/HeightDiffLayer"
    mesh_map.compute_layers(
        [
            {"name": "steps", "type": height_diff},
            {"name": "smooth", "type": TYPE, "params": {"inputs": ["steps"], "rounds": 2}},
            {"name": "lost", "type": TYPE, "params": {"inputs": ["nothing"]}},
        ]
    )
    assert list(mesh_map.layers) == ["steps", "smooth"] and list(mesh_map.layer_errors) == ["lost"]
    assert (mesh_map.layers["smooth"].result.costs == 0).all()
