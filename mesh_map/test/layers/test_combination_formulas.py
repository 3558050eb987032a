"""Combination of layers and weights of edges, against formulas in plain NumPy."""

import layer_oracles
import numpy as np
import pytest
from layer_calls import made, scaled
from mesh_map.costs.combination import Combination
from mesh_map.costs.edge_weights import difference_weights, mean_weights
from mesh_map.costs.layer import LayerInput, checked
from mesh_map.map.mesh_map import MeshMap


def random_layers(count, number, seed):
    """Layers of (costs, lethal, factor) with lethal and unknown costs, and lethal finite ones."""
    random = np.random.default_rng(seed)
    layers = []
    for _ in range(number):
        costs = random.choice([0.1, 1.0, 1e6]) * random.random(count).astype(np.float32)
        costs[random.random(count) < 0.1] = np.inf
        costs[random.random(count) < 0.1] = np.nan
        lethal = np.isposinf(costs) | (random.random(count) < 0.05)
        layers.append((costs.astype(np.float32), lethal, float(random.choice([0.0, 0.3, 1.0]))))
    return layers


@pytest.mark.parametrize("mode", ["sum", "normalized", "max"])
@pytest.mark.parametrize("seed", range(8))
def test_combination(mode, seed):
    layers = random_layers(500, 1 + seed % 4, seed)
    if seed == 0:
        layers.append((np.full(500, 3, np.float32), np.zeros(500, bool), 1.0))  # all the same
    if seed == 1:
        layers.append((np.full(500, np.inf, np.float32), np.ones(500, bool), 0.0))
    results = [(checked((costs, lethal), 500), factor) for costs, lethal, factor in layers]
    found = Combination(results, 500, mode).costs
    expected = layer_oracles.combined(layers, mode)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7)
    assert np.array_equal(np.isnan(found), np.isnan(expected))


@pytest.mark.parametrize(
    "kind, formula",
    [
        ("SumCombination", lambda costs, weights: (weights * costs).sum(1)),
        ("AvgCombination", lambda costs, weights: (weights * costs).sum(1)),
        ("MaxCombination", lambda costs, weights: costs.max(1)),
        ("WeightedCombination", lambda costs, weights: (weights * costs).sum(1) / weights.sum()),
    ],
)
def test_combination_layers(kind, formula):
    mesh, oracle = scaled("jittered_plane")
    count = oracle.count
    layers = random_layers(count, 3, 5)
    weights = np.array([0.2, 1.0, 0.5])
    inputs = {
        "layer_%d" % number: LayerInput(*checked((costs, lethal), count), weight)
        for number, ((costs, lethal, _), weight) in enumerate(zip(layers, weights))
    }
    result = made(kind).evaluate(MeshMap(mesh.vertices, mesh.faces), inputs)
    costs = np.stack([costs for costs, _, _ in layers], 1).astype(np.float64)
    lethal = np.any([lethal for _, lethal, _ in layers], 0)
    expected = np.where(lethal, np.inf, formula(np.where(lethal[:, None], 0, costs), weights))
    np.testing.assert_allclose(result.costs, expected, rtol=1e-6)
    assert np.array_equal(result.lethal, lethal)


@pytest.mark.parametrize("name", ["torus", "fan_of_three", "soup_6"])
@pytest.mark.parametrize(
    "kind, public", [("mean", mean_weights), ("difference", difference_weights)]
)
@pytest.mark.parametrize("factor", [0.0, 0.4, 10.0])
def test_edge_weights(name, kind, public, factor):
    mesh, oracle = scaled(name)
    costs, _, _ = random_layers(oracle.count, 1, 9)[0]
    expected = layer_oracles.edge_weights(oracle, costs.astype(np.float64), kind, factor)
    found = public(oracle.lengths, costs[oracle.edges], factor)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("kind", ["mean", "difference"])
def test_planners_get_these_weights(kind):
    """Through a whole map: layers, their combination, and what planning_costs() gives."""
    mesh, oracle = scaled("two_storeys")
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers(
        [
            {"name": "height", "type": "mesh_layers/HeightDiffLayer", "params": {"factor": 0.7}},
            {"name": "clearance", "type": "mesh_layers/ClearanceLayer"},
        ]
    )
    assert mesh_map.layer_errors == {}
    mesh_map.set_settings(edge_weight=kind, edge_cost_factor=2.5, layer_factor=1.5)
    layers = [
        (mesh_map.layers[name].result.costs, mesh_map.layers[name].result.lethal, factor)
        for name, factor in (("height", 0.7), ("clearance", 1.0))
    ]
    costs = layer_oracles.combined(layers)
    np.testing.assert_allclose(mesh_map.costs, costs, rtol=1e-6, atol=1e-7)
    assert np.isinf(costs).any() and (np.isfinite(costs) & (costs > 0)).any()
    planning = mesh_map.planning_costs()
    assert np.array_equal(mesh_map.topology.edges, oracle.edges)
    factor = {"mean": 2.5, "difference": 1.5}[kind]
    expected = layer_oracles.edge_weights(oracle, costs, kind, factor)
    np.testing.assert_allclose(planning.edge_weights, expected, rtol=1e-5)
    assert planning.costs is mesh_map.costs
