"""Costs as they would be if the layers that can be cleared were empty."""

import numpy as np
import pytest
from test_clear_layers import WashableLayer
from toy_layers import TYPES, calls, entry, evaluations, grid_map
from toy_layers import toys  # noqa: F401

LAYERS = [
    entry("ground", "data"),
    entry("rain", "washable"),
    entry("around", "neighbors", inputs=["ground", "rain"]),
    entry("far", "neighbors", inputs=["around"], share=0.25),
    entry("all", "max"),
]


@pytest.fixture
def made(toys, monkeypatch):  # noqa: F811
    """Makes a map: a random number of vertices is lethal in ground, and in rain."""
    monkeypatch.setitem(TYPES, "washable", WashableLayer)

    def make(seed, **settings):
        random = np.random.default_rng(seed)
        for name in ("ground", "rain"):
            toys[name] = random.uniform(0, 6, 64).astype(np.float32)
        mesh_map = grid_map()
        mesh_map.set_settings(**settings)
        mesh_map.compute_layers(LAYERS)
        assert not mesh_map.layer_errors
        calls.clear()
        return mesh_map

    return make


@pytest.mark.parametrize(
    "settings",
    [{}, {"combination": "max"}, {"combination": "normalized"}, {"default_layer": "far"}],
    ids=str,
)
@pytest.mark.parametrize("seed", range(3))
def test_as_after_clearing(made, seed, settings):
    mesh_map = made(seed, edge_cost_factor=2.0, **settings)
    before = mesh_map.costs
    cleared = mesh_map.cleared_costs()
    assert mesh_map.costs is before and mesh_map.layers["rain"].result.lethal.any()
    assert not np.array_equal(cleared.planning.costs, before)
    mesh_map.clear_layers()
    np.testing.assert_array_equal(cleared.planning.costs, mesh_map.costs)
    np.testing.assert_array_equal(
        cleared.planning.edge_weights, mesh_map.planning_costs().edge_weights
    )
    assert list(cleared.results) == list(mesh_map.layers)
    for name, result in cleared.results.items():
        for mine, its in zip(result, mesh_map.layers[name].result):
            np.testing.assert_array_equal(mine, its)


def test_only_what_reads_sensors_is_evaluated_and_only_once(made, toys):  # noqa: F811
    mesh_map = made(0)
    first = mesh_map.cleared_costs()
    assert evaluations() == {"around": 1, "far": 1, "all": 1}
    toys["rain"][:] = 9
    mesh_map.refresh_layer("rain")
    calls.clear()
    assert mesh_map.cleared_costs() is first and not evaluations()
    toys["ground"][:5] = 9
    mesh_map.refresh_layer("ground")
    second = mesh_map.cleared_costs()
    assert second is not first and np.isinf(second.planning.costs[:5]).all()
    mesh_map.set_layer_parameters("far", {"share": 0.5})
    assert mesh_map.cleared_costs() is not second


def test_without_sensors_it_is_the_map(toys):  # noqa: F811
    toys["ground"] = np.full(64, 9, np.float32)
    mesh_map = grid_map()
    mesh_map.compute_layers([LAYERS[0]])
    cleared = mesh_map.cleared_costs()
    assert cleared.planning is mesh_map.planning_costs()
    assert cleared.results["ground"] is mesh_map.layers["ground"].result


def test_what_fails_without_sensors_closes_nothing(made, monkeypatch, caplog):
    mesh_map = made(1)

    def compute(self, mesh_map, inputs):
        raise RuntimeError("it needs rain")

    monkeypatch.setattr(TYPES["neighbors"], "compute", compute)
    cleared = mesh_map.cleared_costs()
    assert not cleared.results["around"].costs.any()
    np.testing.assert_array_equal(
        np.isinf(cleared.planning.costs), mesh_map.layers["ground"].result.lethal
    )
    assert "layer around without what sensors see: RuntimeError: it needs rain" in caplog.text


def test_layers_that_can_be_cleared_now(made):
    mesh_map = made(0)
    assert mesh_map.clearable_layers == ("rain",)
    silence = ["no cloud for 3 s"]
    mesh_map.watch_data("rain", lambda: silence[0])
    assert mesh_map.clearable_layers == ()
    silence[0] = ""
    assert mesh_map.clearable_layers == ("rain",)
    mesh_map.set_layer_parameters("rain", {"enabled": False})
    assert mesh_map.clearable_layers == ()
    assert np.array_equal(mesh_map.cleared_costs().planning.costs, mesh_map.costs)
