"""Weights of edges: both released formulas, computed once, and only where something changed."""

import math
import tracemalloc

import numpy as np
import pytest
from mesh_map.costs import edge_weights
from mesh_map.costs.edge_weights import PlanningCosts, difference_weights, mean_weights
from mesh_map.costs.settings import MapSettings
from mesh_map.geometry.mesh_geometry import MeshGeometry
from meshes import terrain

INF, NAN = math.inf, math.nan
LENGTHS = np.array([2, 2, 2, 2, 2], np.float32)
ENDS = np.array([[1, 3], [0, 0], [INF, 1], [NAN, 1], [INF, NAN]], np.float32)


def test_both_formulas():
    assert mean_weights(LENGTHS, ENDS, 0.5).tolist() == [4, 2, INF, INF, INF]
    assert mean_weights(LENGTHS, ENDS, 0.0).tolist() == [2, 2, INF, INF, INF]
    assert difference_weights(LENGTHS, ENDS, 0.5).tolist() == [4, 2, 2, 2, 2]
    assert mean_weights(LENGTHS, ENDS, 0.5).dtype == np.float32
    huge = np.full((5, 2), 3e38, np.float32)
    assert mean_weights(LENGTHS, huge, 10.0).tolist() == [INF] * 5


@pytest.fixture
def geometry():
    mesh = terrain(30)
    return MeshGeometry(mesh.vertices, mesh.faces)


def costs_of(geometry, seed=0):
    random = np.random.default_rng(seed)
    costs = random.uniform(0, 2, len(geometry.vertices)).astype(np.float32)
    costs[random.uniform(size=len(costs)) < 0.05] = np.inf
    costs[random.uniform(size=len(costs)) < 0.05] = np.nan
    return costs


def weights_one_by_one(geometry, costs, settings):
    """The formulas of the sheet, one edge after the other."""
    weights = []
    for (a, b), length in zip(geometry.topology.edges, geometry.edge_lengths):
        length, ends = float(length), [float(costs[a]), float(costs[b])]
        finite = all(map(math.isfinite, ends))
        if settings.edge_weight == "mean":
            weight = length * (1 + settings.edge_cost_factor * sum(ends) / 2) if finite else INF
        else:
            bumps = abs(ends[0] - ends[1]) if finite else 0
            weight = length * (1 + settings.layer_factor * bumps)
        weights.append(weight)
    return np.array(weights, np.float32)


SETTINGS = [
    MapSettings(),
    MapSettings(edge_cost_factor=5.0),
    MapSettings(edge_weight="difference"),
    MapSettings(edge_weight="difference", layer_factor=0.3),
]


@pytest.mark.parametrize("settings", SETTINGS)
def test_weights_of_a_mesh(geometry, settings):
    costs = costs_of(geometry)
    planning = PlanningCosts(7, costs, geometry, settings)
    expected = weights_one_by_one(geometry, costs, settings)
    assert np.allclose(planning.edge_weights, expected, rtol=1e-7, atol=0)
    assert planning.edge_weights is planning.edge_weights
    assert planning.edge_weights.dtype == np.float32 and not planning.edge_weights.flags.writeable
    assert planning.version == 7 and planning.costs is costs


@pytest.mark.parametrize("settings", SETTINGS)
def test_blocks_are_as_the_whole(geometry, settings, monkeypatch):
    costs = costs_of(geometry)
    whole = PlanningCosts(0, costs, geometry, settings).edge_weights
    monkeypatch.setattr(edge_weights, "_BLOCK", 100)
    blocks = PlanningCosts(0, costs, geometry, settings).edge_weights
    assert len(whole) > 1000 and np.array_equal(whole.view(np.uint32), blocks.view(np.uint32))


def test_memory_of_weights_is_little_more_than_their_own(geometry):
    mesh = terrain(400)
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    costs, settings = costs_of(geometry), MapSettings(edge_cost_factor=1.0)
    planning = PlanningCosts(0, costs, geometry, settings)
    assert len(geometry.edge_lengths) > 400000
    tracemalloc.start()
    try:
        weights = planning.edge_weights
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert weights.nbytes <= peak < 5 * weights.nbytes  # 11 times, all at once


def test_without_a_factor_weights_are_lengths(geometry):
    settings = MapSettings(edge_weight="difference", layer_factor=0.0)
    assert PlanningCosts(0, costs_of(geometry), geometry, settings).edge_weights is (
        geometry.edge_lengths
    )
    free = np.zeros(len(geometry.vertices), np.float32)
    weights = PlanningCosts(0, free, geometry, MapSettings()).edge_weights
    assert np.array_equal(weights, geometry.edge_lengths)


@pytest.mark.parametrize("settings", SETTINGS)
def test_after_a_change_weights_are_as_from_nothing(geometry, settings):
    random = np.random.default_rng(4)
    costs = costs_of(geometry)
    planning = PlanningCosts(0, costs, geometry, settings)
    for step in range(12):
        if step % 3:  # now and then nobody asks
            planning.edge_weights
        changed = np.unique(random.integers(0, len(costs), (0, 1, 9, 400)[step % 4]))
        costs = costs.copy()
        costs[changed] = np.where(changed % 3 == 0, np.inf, random.uniform(0, 3, len(changed)))
        planning = PlanningCosts(step, costs, geometry, settings, planning, changed)
        if step % 2:
            expected = PlanningCosts(step, costs, geometry, settings).edge_weights
            assert np.array_equal(planning.edge_weights.view(np.uint32), expected.view(np.uint32))


def test_only_edges_at_changed_vertices_are_computed(geometry, monkeypatch):
    computed = []

    def counted(lengths, costs, factor):
        computed.append(len(lengths))
        return mean_weights(lengths, costs, factor)

    monkeypatch.setattr(edge_weights, "mean_weights", counted)
    costs = costs_of(geometry)
    first = PlanningCosts(0, costs, geometry, MapSettings())
    first.edge_weights
    changed = np.array([5, 9], np.uint32)
    second = PlanningCosts(1, costs, geometry, MapSettings(), first, changed)
    third = PlanningCosts(2, costs, geometry, MapSettings(), second, np.array([700]))
    third.edge_weights
    around = [len(geometry.topology.neighbors_of(vertex)) for vertex in (5, 9, 700)]
    assert computed == [geometry.topology.edge_count, sum(around)]
    nothing = PlanningCosts(3, costs, geometry, MapSettings(), third, np.zeros(0, np.uint32))
    assert nothing.edge_weights is third.edge_weights and len(computed) == 2
