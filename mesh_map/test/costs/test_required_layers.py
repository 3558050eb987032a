"""Layers that do not stand: what is said of it, what goes on, and how they come back."""

import numpy as np
import pytest
from mesh_map import MeshMap, MeshMapError
from mesh_map.base.parameter import Parameter
from toy_layers import TYPES, DataLayer, FailingLayer, calls, entry, evaluations, grid_map
from toy_layers import toys  # noqa: F401

pytestmark = pytest.mark.usefixtures("toys")
WALL = np.where(np.arange(64) == 10, 9, 0).astype(np.float32)


@pytest.fixture
def walled(toys):  # noqa: F811
    """Vertex 10 is lethal in the layer wall, and unknown in the layer fog is vertex 20."""
    toys["wall"] = WALL
    toys["fog"] = np.where(np.arange(64) == 20, np.nan, 1).astype(np.float32)
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("wall", "data"), entry("fog", "data"), entry("all", "sum")])
    assert not mesh_map.fault and not np.isfinite(mesh_map.costs[[10, 20]]).any()
    return mesh_map


def optional(name, type_name, inputs=None, **params):
    """An entry of a layer that is not required."""
    return dict(entry(name, type_name, inputs, **params), required=False)


@pytest.mark.parametrize(
    "part, fault",
    [
        (entry("wall", "dta"), "layer wall: KeyError: 'dta'"),
        (entry("wall", "data", fails=True), "layer wall: RuntimeError: it was told to fail"),
        (entry("wall", "data", scale="2"), "layer wall: scale is '2', but it has to be a number"),
        (entry("wall", "sum", ["wal"]), "layer wall: its input wal is no layer (known: ground)"),
        (dict(entry("wall", "data"), required="no"), "required of layer wall is 'no' (true or"),
        (dict(entry("wall", "data"), required=None), "required of layer wall is None (true or"),
        ({"name": "wall", "required": False}, "layer 1: an entry of the list of layers is {'name'"),
        (dict(entry("3", "data"), required=False), "layer 1: '3' is no name for a layer"),
        (entry("ground", "data"), "layer 1: there are two layers of the name ground"),
        ("wall", "layer 1: an entry of the list of layers is 'wall'"),
    ],
)
def test_a_required_layer_that_is_left_out_is_a_fault(part, fault):
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("ground", "data"), part])
    assert fault in mesh_map.fault and list(mesh_map.layers) == ["ground"]
    mesh_map.compute_layers([entry("ground", "data")])
    assert mesh_map.fault == ""


def test_what_is_no_list_of_layers_is_a_fault():
    mesh_map = grid_map()
    mesh_map.compute_layers("ground")
    assert mesh_map.fault == "layers: the list of layers is a str, not a list"


def test_a_layer_that_is_not_required_is_let_go_by_those_that_read_it_too():
    mesh_map = grid_map()
    mesh_map.compute_layers(
        [
            entry("ground", "data"),
            optional("lost", "data", fails=True),
            optional("typo", "dta"),
            entry("all", "max", ["lost", "ground", "typo"]),
        ]
    )
    assert list(mesh_map.layers) == ["ground", "all"] and mesh_map.fault == ""
    assert set(mesh_map.layer_failures) == {"lost", "typo"}
    required = entry("lost", "data", fails=True)
    mesh_map.compute_layers([entry("ground", "data"), required, entry("all", "sum", ["lost"])])
    lost = "layer lost: RuntimeError: it was told to fail"
    assert mesh_map.fault == lost + "; layer all: its input lost is left out"


def test_a_layer_that_is_not_enabled_is_taken_out(walled, toys):  # noqa: F811
    alone = grid_map()
    alone.compute_layers([entry("fog", "data"), entry("all", "sum")])
    toys["wall"] = toys["wall"] + 1
    for mode in ("sum", "normalized", "max"):
        walled.set_settings(combination=mode)
        alone.set_settings(combination=mode)
        calls.clear()
        walled.set_layer_parameters("wall", {"enabled": False})
        assert evaluations() == {"all": 1}
        assert np.array_equal(walled.costs, alone.costs, equal_nan=True)
        walled.refresh_layer("wall")
        walled.set_layer_parameters("wall", {"scale": 2.0})
        assert not evaluations()
        walled.set_layer_parameters("wall", {"enabled": True, "scale": 1.0})
        assert evaluations() == {"wall": 1, "all": 1} and np.isinf(walled.costs[10])


def test_a_mean_does_not_count_what_is_not_enabled(toys):  # noqa: F811
    toys.update(one=np.full(64, 1, np.float32), two=np.full(64, 4, np.float32))
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("one", "data"), entry("two", "data"), entry("mean", "mean")])
    assert mesh_map.layers["mean"].result.costs[0] == 2.5
    mesh_map.set_layer_parameters("two", {"enabled": False})
    assert mesh_map.layers["mean"].result.costs[0] == 1


def test_a_default_layer_that_is_not_enabled_does_not_count(walled):
    walled.set_settings(default_layer="fog")
    assert walled.costs[10] == 1
    walled.set_layer_parameters("fog", {"enabled": False})
    assert np.isinf(walled.costs[10]) and not walled.fault
    walled.set_layer_parameters("fog", {"enabled": True})
    assert walled.costs[10] == 1


def test_a_layer_that_is_not_enabled_cannot_fail():
    mesh_map = grid_map()
    config = [
        entry("typo", "dta", enabled=False),
        entry("lost", "data", fails=True, enabled=False),
        entry("circle", "sum", ["circle"], enabled=False),
        entry("ground", "data"),
        entry("all", "sum", ["ground", "lost", "typo"]),
    ]
    mesh_map.compute_layers(config)
    assert mesh_map.fault == "" and list(mesh_map.layers) == ["lost", "ground", "all"]
    with pytest.raises(MeshMapError, match="layer lost: RuntimeError: it was told to fail"):
        mesh_map.set_layer_parameters("lost", {"enabled": True})
    assert mesh_map.fault == "" and not mesh_map.layers["lost"].params["enabled"]
    config[1]["params"]["enabled"] = "no"
    mesh_map.compute_layers(config)
    assert "layer lost: enabled is 'no', but it has to be a boolean" in mesh_map.fault


def test_a_layer_that_stays_as_it_was_is_a_fault_until_it_is_evaluated(toys):  # noqa: F811
    toys["water"] = np.zeros(64, np.float32)
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("water", "data"), entry("near", "failing")])
    FailingLayer.broken = True
    toys["water"] = WALL
    mesh_map.refresh_layer("water")
    assert mesh_map.fault == "layer near: KeyError: 'broken'"
    mesh_map.set_layer_parameters("near", {"enabled": False})
    assert mesh_map.fault == ""
    with pytest.raises(MeshMapError):
        mesh_map.set_layer_parameters("near", {"enabled": True})
    FailingLayer.broken = False
    mesh_map.set_layer_parameters("near", {"enabled": True})
    assert mesh_map.fault == "" and mesh_map.layers["near"].result.costs[9] == 1


def test_a_layer_that_is_mended_takes_its_place(toys):  # noqa: F811
    toys["wall"] = WALL
    config = [
        entry("ground", "data"),
        entry("wall", "data", fails=True),
        entry("near", "neighbors", ["wall"]),
        entry("all", "sum"),
    ]
    mesh_map = grid_map()
    mesh_map.compute_layers(config)
    told = []
    mesh_map.add_listener(told.append)
    assert list(mesh_map.layers) == ["ground", "all"] and "layer wall" in mesh_map.fault
    mesh_map.set_layer_parameters("wall", {"fails": False})
    assert mesh_map.fault == ""
    config[1] = entry("wall", "data")
    fresh = MeshMap.of(mesh_map.geometry)
    fresh.compute_layers(config)
    assert list(mesh_map.layers) == list(fresh.layers)
    for name, layer in fresh.layers.items():
        assert np.array_equal(mesh_map.layers[name].result.costs, layer.result.costs)
    assert np.array_equal(mesh_map.costs, fresh.costs)
    assert [change.name for change in told[0]] == ["wall", "near", "all", "Combined Costs"]


def test_a_layer_that_gets_no_data(walled):
    walled.set_without_data("wall", "no topic")
    assert walled.fault == "layer wall: no topic"
    walled.refresh_layer("wall")
    assert walled.fault == "layer wall: no topic"
    walled.set_layer_parameters("wall", {"enabled": False})
    assert walled.fault == ""
    walled.set_layer_parameters("wall", {"enabled": True})
    walled.set_without_data("wall", "")
    assert walled.fault == ""


def test_a_layer_whose_data_are_not_current(walled):
    silent = ["no cloud for 3 s"]
    walled.watch_data("wall", lambda: silent[0])
    assert walled.fault == walled.gap == "layer wall: no cloud for 3 s" and not walled.lasting_fault
    walled.set_without_data("fog", "no topic")
    assert walled.lasting_fault == "layer fog: no topic" and "wall" in walled.gap
    assert set(walled.layer_failures) == {"wall", "fog"}
    walled.set_without_data("fog", "")
    silent[0] = ""
    assert walled.fault == walled.gap == ""
    walled.watch_data("wall", lambda: silent[1])
    assert walled.gap == "layer wall: IndexError: list index out of range"
    walled.set_layer_parameters("wall", {"enabled": False})
    assert walled.gap == ""
    walled.compute_layers([optional("wall", "data")])
    walled.watch_data("wall", lambda: "no cloud")
    assert walled.fault == walled.gap == "" and walled.layer_failures == {"wall": "no cloud"}


def test_a_default_layer_that_is_none_is_a_fault_until_another_is_chosen():
    mesh_map = grid_map()
    mesh_map.set_settings(default_layer="al")
    mesh_map.compute_layers([entry("ground", "data"), entry("all", "sum")])
    assert mesh_map.fault == "default_layer: al is no layer: all layers are combined"
    mesh_map.set_settings(default_layer="all")
    assert mesh_map.fault == ""


WAYS = "__init__ announce compute update reuse clear fingerprint checked_changes".split()


class LeavingLayer(DataLayer):
    """Exits the program in the method that is set."""

    PARAMETERS = DataLayer.PARAMETERS + (Parameter("depth", 1.0),)
    exits = ""

    def __getattribute__(self, name):
        if name == LeavingLayer.exits:
            raise SystemExit("enough")
        return super().__getattribute__(name)

    def __init__(self, *args):
        if LeavingLayer.exits == "__init__":
            raise SystemExit("enough")
        super().__init__(*args)

    def announce(self, geometry):
        pass

    def clear(self):
        return 1


@pytest.mark.parametrize("way", WAYS)
def test_a_layer_that_exits_the_program_fails_as_any_other(way, monkeypatch):
    monkeypatch.setitem(TYPES, "leaving", LeavingLayer)
    monkeypatch.setattr(LeavingLayer, "exits", "")
    mesh_map, config = grid_map(), [entry("ground", "data"), entry("exit", "leaving")]
    mesh_map.compute_layers(config)
    LeavingLayer.exits = way
    for change in (
        lambda: mesh_map.set_layer_parameters("exit", {"depth": 2.0}),
        lambda: mesh_map.set_layer_parameters("exit", {"threshold": 2.0}),
        lambda: mesh_map.refresh_layer("exit"),
        lambda: mesh_map.clear_layers(),
        lambda: mesh_map.layers_to_store(),
    ):
        try:
            change()
        except MeshMapError as error:
            assert "SystemExit: enough" in str(error)
    mesh_map.compute_layers(config, stored=lambda *_: None)
    assert list(mesh_map.layers)[0] == "ground"
    if way in ("__init__", "announce", "compute"):
        assert mesh_map.fault == "layer exit: SystemExit: enough"


def test_a_layer_that_exits_the_program_as_it_is_to_be_stored(monkeypatch):
    monkeypatch.setitem(TYPES, "leaving", LeavingLayer)
    monkeypatch.setattr(LeavingLayer, "exits", "fingerprint")
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("ground", "data"), entry("exit", "leaving")])
    layers, errors = mesh_map.layers_to_store()
    assert list(layers) == ["ground"] and errors == {"exit": "SystemExit: enough"}


def test_parameters_that_a_layer_exits_the_program_over(monkeypatch):
    monkeypatch.setitem(TYPES, "leaving", LeavingLayer)
    monkeypatch.setattr(LeavingLayer, "exits", "checked_changes")
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("exit", "leaving")])
    with pytest.raises(MeshMapError, match="^layer exit: SystemExit: enough$"):
        mesh_map.set_layer_parameters("exit", {"scale": 2.0})
    assert mesh_map.fault == "" and mesh_map.layers["exit"].params["scale"] == 1.0


def test_listeners_that_exit_the_program_harm_nobody(walled):
    def leave(_changes):
        raise SystemExit("enough")

    told = []
    walled.add_listener(leave)
    walled.add_listener(told.append)
    walled.set_layer_parameters("wall", {"scale": 3.0})
    assert told


def test_a_plugin_that_exits_while_it_is_imported(monkeypatch):
    from mesh_map.base import plugins

    def leave(_name):
        raise SystemExit("enough")

    monkeypatch.undo()
    monkeypatch.setattr(plugins.importlib, "import_module", leave)
    mesh_map = grid_map()
    mesh_map.compute_layers([{"name": "exit", "type": "mesh_layers/BorderLayer"}])
    assert "cannot be imported: SystemExit: enough" in mesh_map.fault
