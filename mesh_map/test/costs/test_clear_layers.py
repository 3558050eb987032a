"""Layers that forget what sensors have seen."""

import logging
import threading

import numpy as np
import pytest
from mesh_map import MeshMapError
from mesh_map.costs import propagation
from mesh_map.layers.threshold_layer import HeightDiffLayer
from mesh_map.layers.obstacle import ObstacleLayer
from mesh_map.map.mesh_map import COMBINED_COSTS
from toy_layers import TYPES, DataLayer, calls, entry, evaluations, grid_map
from toy_layers import toys  # noqa: F401

LAYERS = [
    entry("ground", "data"),
    entry("rain", "washable"),
    entry("sun", "washable"),
    entry("all", "sum"),
]


class WashableLayer(DataLayer):
    """Its data can be forgotten."""

    def clear(self):
        if self.params["fails"]:
            raise RuntimeError("it does not come off")
        data = self.ALL.get(self.name, np.zeros(0))
        count = int(np.count_nonzero(data))
        data[:] = 0
        return count


@pytest.fixture
def washable(toys, monkeypatch):  # noqa: F811
    monkeypatch.setitem(TYPES, "washable", WashableLayer)
    toys["ground"] = np.full(64, 0.5, np.float32)
    toys["rain"], toys["sun"] = np.zeros((2, 64), np.float32)
    toys["rain"][:3] = 9
    toys["sun"][2:4] = 1
    mesh_map = grid_map()
    mesh_map.compute_layers(LAYERS)
    assert not mesh_map.layer_errors
    calls.clear()
    mesh_map.told = []
    mesh_map.add_listener(mesh_map.told.append)
    return mesh_map


def test_which_layers_can_be_cleared():
    assert ObstacleLayer.can_be_cleared() and WashableLayer.can_be_cleared()
    assert not HeightDiffLayer.can_be_cleared() and HeightDiffLayer("h").clear() == 0


def test_all_of_them_in_one_change(washable):
    assert np.isinf(washable.costs[:3]).all()
    assert washable.clear_layers() == {"rain": 3, "sun": 2}
    assert evaluations() == {"rain": 1, "sun": 1, "all": 1}
    (changes,) = washable.told
    assert [(change.name, len(change.vertices)) for change in changes] == [
        ("rain", 3),
        ("sun", 2),
        ("all", 4),
        (COMBINED_COSTS, 4),
    ]
    assert np.array_equal(washable.costs, np.full(64, 1.0, np.float32))  # ground, and all
    assert washable.clear_layers() == {"rain": 0, "sun": 0} and len(washable.told) == 1


def test_those_of_some_names(washable):
    assert washable.clear_layers(["ground", "sun"]) == {"sun": 2}
    assert np.isinf(washable.costs[:3]).all()
    assert washable.clear_layers([]) == {}


def test_a_name_that_is_none_changes_nothing(washable):
    with pytest.raises(MeshMapError, match="there is no layer snow"):
        washable.clear_layers(["rain", "snow"])
    assert np.isinf(washable.costs[:3]).all() and not washable.told


def test_a_layer_that_fails_does_not_hold_up_others(washable, caplog):
    washable.layers["rain"].params["fails"] = True
    with caplog.at_level(logging.ERROR):
        assert washable.clear_layers() == {"sun": 2}
    assert "layer rain stays as it was: RuntimeError: it does not come off" in caplog.text
    assert np.isinf(washable.costs[:3]).all()


def test_obstacles():
    mesh_map = grid_map()
    mesh_map.compute_layers([{"name": "seen", "type": "mesh_layers/ObstacleLayer"}])
    layer = mesh_map.layers["seen"]
    assert layer.insert_cloud(mesh_map, [[2.2, 2.2, 0.5], [5.2, 5.2, 0.5]], (0, 0, 1), 0.0) == 2
    mesh_map.refresh_layer("seen")
    assert np.isinf(mesh_map.costs).sum() == 6
    assert mesh_map.clear_layers() == {"seen": 2}
    assert not mesh_map.costs.any() and mesh_map.planning_costs().costs is mesh_map.costs


def test_what_a_robot_sees_comes_first(washable, monkeypatch):
    """Kernels of layers without data of sensors run in the background, of all others never."""
    background, seen = [], []

    class Loops:
        def __enter__(self):
            background.append(threading.get_ident())

        def __exit__(self, *_):
            background.pop()

    monkeypatch.setattr(propagation._kernels, "_BackgroundLoops", Loops)
    for layer in washable.layers.values():

        def evaluate(*arguments, _layer=layer, _compute=layer.compute):
            seen.append((_layer.name, threading.get_ident() in background))
            return _compute(*arguments)

        layer.compute = evaluate
    assert washable.layer_set.sensing == {"rain", "sun", "all"}
    for name in ("ground", "rain"):
        washable.set_layer_parameters(name, {"scale": 0.5})
    assert seen == [("ground", True), ("all", False), ("rain", False)] and not background
