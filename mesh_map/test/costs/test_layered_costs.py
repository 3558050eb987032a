"""Changes of layers in use: what is evaluated again, who is told, and what stays after errors."""

import math

import numpy as np
import pytest
from mesh_map import MeshMap, MeshMapError
from mesh_map.costs import propagation
from mesh_map.costs.settings import MapSettings
from mesh_map.geometry import mesh_geometry
from mesh_map.map.mesh_map import COMBINED_COSTS
from toy_layers import CHAIN, FailingLayer, calls, entry, evaluations, grid_map, told
from toy_layers import chain, toys  # noqa: F401

pytestmark = pytest.mark.usefixtures("toys")


def test_a_parameter_of_costs_evaluates_the_layer_and_who_reads_it(chain):  # noqa: F811
    before = {name: layer.result for name, layer in chain.layers.items()}
    assert chain.set_layer_parameters("water", {"scale": 0.75})["scale"] == 0.75
    assert evaluations() == {"water": 1, "near": 1, "all": 1}
    assert told(chain) == [("water", 1), ("near", 1)]
    assert chain.layers["ground"].result is before["ground"]
    chain.set_layer_parameters("ground", {"scale": 2.0})
    assert evaluations() == {"ground": 1, "all": 1}
    assert chain.layers["near"].result.costs[10] == 0.5 * 0.75 * 9


def test_a_layer_says_what_it_needs_before_it_is_evaluated(chain):  # noqa: F811
    assert calls["near", "announce"] == 0
    chain.set_layer_parameters("near", {"share": 0.25})
    assert calls["near", "announce"] == calls["near", "compute"] == 1
    chain.compute_layers(CHAIN)
    assert calls["near", "announce"] == calls["near", "compute"] == 2


def test_what_does_not_change_evaluates_nothing(chain):  # noqa: F811
    for values in ({}, {"scale": 1}, {"scale": 1.0, "threshold": 5}, {"unknown": 3}):
        assert chain.set_layer_parameters("water", values) == chain.layers["water"].params
    assert chain.set_layer_parameters("water", {"scale": 99.0})["scale"] == 10.0
    calls.clear()
    chain.told.clear()
    chain.set_layer_parameters("water", {"scale": 10})
    assert not evaluations() and not chain.told


def test_a_result_as_before_ends_what_follows(chain):  # noqa: F811
    chain.set_layer_parameters("water", {"threshold": 8.5})
    assert evaluations() == {"water": 1} and not chain.told


def test_a_threshold_takes_the_costs_as_they_are(chain):  # noqa: F811
    chain.set_layer_parameters("water", {"threshold": 9.5})
    assert calls["water", "reuse"] == 1 and calls["water", "compute"] == 0
    assert evaluations() == {"water": 1, "near": 1, "all": 1}
    assert told(chain) == [("near", 7), ("all", 7), (COMBINED_COSTS, 7)]
    assert not np.isinf(chain.costs).any()


def test_a_factor_changes_the_combination_alone(chain):  # noqa: F811
    before = chain.costs
    chain.set_layer_parameters("ground", {"factor": 0.5})
    assert not evaluations() and told(chain) == [(COMBINED_COSTS, 62)]
    free = np.isfinite(chain.costs)
    ground = chain.layers["ground"].result.costs
    assert np.allclose(before[free] - chain.costs[free], 0.5 * ground[free], atol=1e-6)


def test_a_weight_changes_those_that_read_weights(chain):  # noqa: F811
    chain.set_layer_parameters("water", {"combination_weight": 0.25})
    assert evaluations() == {"all": 1}  # lethal whatever its weight
    assert not chain.told
    chain.set_layer_parameters("ground", {"combination_weight": 0.25})
    assert evaluations() == {"all": 1}
    assert told(chain) == [("all", 62), (COMBINED_COSTS, 62)]


def test_weights_do_not_matter_to_all(chain):  # noqa: F811
    for name, reads_weights in (("sum", True), ("mean", True), ("max", False), ("failing", False)):
        chain.compute_layers(CHAIN[:2] + [entry("reading", name)])
        calls.clear()
        chain.set_layer_parameters("ground", {"combination_weight": 0.5})
        assert evaluations() == ({"reading": 1} if reads_weights else {})


def test_data_of_a_layer(chain, toys):  # noqa: F811
    toys["water"][20] = 1
    chain.refresh_layer("water")
    assert {name: calls[name, "update"] for name in chain.layers} == dict(
        ground=0, water=1, near=1, all=1
    )
    assert evaluations() == {"water": 1, "near": 1, "all": 1}
    (changes,) = chain.told
    assert [change.name for change in changes] == ["water", "near", "all", COMBINED_COSTS]
    for change in changes:
        assert change.vertices.dtype == np.uint32 and change.vertices.tolist() == [20]
        assert change.costs.shape == (64,) and not change.costs.flags.writeable
    assert changes[3].costs is chain.costs
    chain.told.clear()
    chain.refresh_layer("water")
    assert not chain.told


@pytest.mark.parametrize(
    "values, message",
    [
        ({"scale": math.nan}, "scale is nan, but it has to be a number"),
        ({"threshold": 1, "scale": "2"}, "scale is '2', but it has to be a number"),
        ({"fails": True, "threshold": 2}, "layer water: RuntimeError: it was told to fail"),
        ({"fails": 1}, "fails is 1, but it has to be a boolean"),
    ],
)
def test_refused_parameters_change_nothing(chain, values, message):  # noqa: F811
    layer = chain.layers["water"]
    params, result, planning = dict(layer.params), layer.result, chain.planning_costs()
    with pytest.raises(MeshMapError) as error:
        chain.set_layer_parameters("water", values)
    assert str(error.value) == message
    assert layer.params == params and layer.result is result
    assert chain.planning_costs() is planning and not chain.told
    chain.set_layer_parameters("water", {"scale": 2.0})
    assert layer.params == dict(params, scale=2.0)


def test_inputs_stay(chain):  # noqa: F811
    with pytest.raises(MeshMapError, match="inputs cannot be changed"):
        chain.set_layer_parameters("near", {"inputs": ["ground"]})


def test_a_layer_that_does_not_exist_or_is_left_out(chain):  # noqa: F811
    with pytest.raises(MeshMapError, match=r"no layer fire \(known: ground, water, near, all\)"):
        chain.set_layer_parameters("fire", {})
    chain.compute_layers(CHAIN + [entry("fire", "data", fails=True)])
    with pytest.raises(MeshMapError, match="layer fire: RuntimeError: it was told to fail"):
        chain.set_layer_parameters("fire", {"scale": 2.0})
    chain.compute_layers(CHAIN + [entry("fire", "data", scale="hot")])
    with pytest.raises(MeshMapError, match=r"no layer fire \(it is left out: scale is 'hot'"):
        chain.set_layer_parameters("fire", {"scale": 2.0})


def test_warnings_are_logged(chain, caplog):  # noqa: F811
    chain.set_layer_parameters("water", {"scale": 99, "speed": 1})
    chain.set_settings(layer_factor=-1)
    assert [record.getMessage().split(":")[:2] for record in caplog.records] == [
        ["layer water", " scale is 99, outside of [0.0, 10.0]"],
        ["layer water", " unknown parameters"],
        ["layer_factor is -1, outside of [0.0, 10.0]", " 0.0 is used"],
    ]


def test_a_layer_that_fails_stays_and_is_computed_when_it_can(toys, caplog):  # noqa: F811
    toys["water"] = np.zeros(64, np.float32)
    mesh_map = grid_map()
    config = [entry("water", "data"), entry("near", "failing"), entry("all", "sum", ["near"])]
    mesh_map.compute_layers(config)
    before = mesh_map.layers["near"].result
    FailingLayer.broken = True
    toys["water"][5] = 9
    mesh_map.refresh_layer("water")
    assert mesh_map.layers["near"].result is before
    assert [record.getMessage() for record in caplog.records] == [
        "layer near stays as it was: KeyError: 'broken'"
    ]
    assert np.isinf(mesh_map.costs).nonzero()[0].tolist() == [5]
    FailingLayer.broken = False
    toys["water"][50] = 1  # what it has missed is not lost
    calls.clear()
    mesh_map.refresh_layer("water")
    assert calls["near", "compute"] == 1 and calls["near", "update"] == 0
    fresh = grid_map()
    fresh.compute_layers(config)
    for name in mesh_map.layers:
        for one, other in zip(mesh_map.layers[name].result, fresh.layers[name].result):
            assert one is other or np.array_equal(one, other)
    calls.clear()
    toys["water"][51] = 1
    mesh_map.refresh_layer("water")
    assert calls["near", "update"] == 1 and calls["near", "compute"] == 0


def test_a_layer_that_fails_with_each_cloud_says_so_now_and_then(toys, caplog):  # noqa: F811
    mesh_map = grid_map()
    mesh_map.compute_layers([entry("water", "data"), entry("near", "failing")])

    def change(times):
        caplog.clear()
        for _ in range(times):
            toys["water"] = toys.get("water", np.zeros(64, np.float32)) + np.float32(0.25)
            mesh_map.refresh_layer("water")
        return caplog.messages

    FailingLayer.broken = True
    line = "layer near stays as it was: KeyError: 'broken'"
    assert change(5) == [line]
    propagation.FAILURE_PERIOD, period = 0.0, propagation.FAILURE_PERIOD
    try:
        assert change(2) == [line] * 2
    finally:
        propagation.FAILURE_PERIOD = period
    FailingLayer.broken = False
    assert change(1) == []
    FailingLayer.broken = True
    assert change(1) == [line]


def test_data_that_cannot_be_used_leave_the_layer(chain, toys, caplog):  # noqa: F811
    result = chain.layers["water"].result
    toys["water"] = np.zeros(3, np.float32)
    chain.refresh_layer("water")
    assert chain.layers["water"].result is result and not chain.told
    assert caplog.messages[-1].startswith("layer water stays as it was: the costs are of shape (3,")
    toys["water"] = np.zeros(64, np.float32)
    calls.clear()
    chain.refresh_layer("water")
    assert calls["water", "compute"] == 1 and calls["water", "update"] == 0


def test_after_a_failure_the_costs_are_not_taken_as_they_are(chain, toys):  # noqa: F811
    toys["water"] = np.zeros(3, np.float32)
    chain.refresh_layer("water")
    toys["water"] = np.full(64, 2, np.float32)
    calls.clear()
    chain.set_layer_parameters("water", {"threshold": 1.0})
    assert calls["water", "compute"] == 1 and calls["water", "reuse"] == 0
    assert np.isinf(chain.costs).all()
    chain.set_layer_parameters("water", {"threshold": 3.0})
    assert calls["water", "compute"] == 1 and calls["water", "reuse"] == 1


def test_settings(chain):  # noqa: F811
    assert chain.settings == MapSettings()
    ground, near = (chain.layers[name].result for name in ("ground", "near"))
    assert chain.set_settings(default_layer="ground").default_layer == "ground"
    assert np.array_equal(chain.costs, ground.costs)
    assert told(chain) == [(COMBINED_COSTS, 63)]
    chain.set_settings(default_layer="near")
    assert np.array_equal(chain.costs, near.costs)
    chain.set_settings(default_layer="", combination="max")
    largest = np.max([layer.result.costs for layer in chain.layers.values()], axis=0)
    assert np.array_equal(chain.costs, largest)
    assert not evaluations()
    version = chain.planning_costs().version
    chain.told.clear()
    chain.set_settings(edge_weight="difference", layer_factor=2)
    assert chain.planning_costs().version == version + 1 and not chain.told
    assert chain.settings == MapSettings("max", "", "difference", 2.0, 0.0)
    chain.set_settings(layer_factor=2.0)
    assert chain.planning_costs().version == version + 1


@pytest.mark.parametrize(
    "values, message",
    [
        ({"combination": "mean"}, "combination is 'mean', but it has to be one of sum, normalized"),
        ({"edge_weight": 3}, "edge_weight is 3, but it has to be a string"),
        ({"layer_factor": math.nan}, "layer_factor is nan"),
        ({"cost": 1, "speed": 2}, r"unknown settings: cost, speed \(known: combination, default_l"),
        ({"default_layer": "fire"}, r"default_layer is fire, which is no layer \(known: ground, w"),
    ],
)
def test_refused_settings_change_nothing(chain, values, message):  # noqa: F811
    planning = chain.planning_costs()
    with pytest.raises(MeshMapError, match=message):
        chain.set_settings(edge_cost_factor=3.0, **values)
    assert chain.settings == MapSettings() and chain.planning_costs() is planning


def test_a_default_layer_that_is_left_out(caplog):
    mesh_map = grid_map()
    mesh_map.set_settings(default_layer="all")
    mesh_map.compute_layers([entry("ground", "data"), entry("all", "sum", ["fire"])])
    text = "all is no layer: all layers are combined"
    assert mesh_map.layer_errors["default_layer"] == text and "default_layer " + text in caplog.text
    mesh_map.compute_layers(CHAIN)
    assert not mesh_map.layer_errors and mesh_map.costs is not None
    assert np.array_equal(mesh_map.costs, mesh_map.layers["all"].result.costs)


def test_listeners_are_told_of_layers_that_are_computed_anew(chain, toys):  # noqa: F811
    toys["water"][3] = 1
    chain.compute_layers(CHAIN + [entry("new", "data")])
    assert told(chain) == [("water", 1), ("near", 1), ("all", 1), ("new", 64), (COMBINED_COSTS, 1)]
    chain.remove_listener(chain.told.append)
    chain.remove_listener(print)
    chain.set_layer_parameters("ground", {"scale": 3.0})
    assert not chain.told


def test_each_layer_is_given_as_soon_as_it_has_its_result(chain):  # noqa: F811
    seen = []

    def on_layer(layer):
        seen.append((layer.name, layer.result is not None, len(calls)))

    config = CHAIN[3:] + CHAIN[:3]
    chain.compute_layers(config, on_layer=on_layer)
    assert [name for name, _, _ in seen] == ["all", "ground", "water", "near"]
    assert all(result for _, result, _ in seen)


def test_stored_costs_are_reused_where_also_the_inputs_are_the_same(chain):  # noqa: F811
    store = {name: (layer.identity, layer.result.costs) for name, layer in chain.layers.items()}

    asked = {}

    def stored(name, fingerprint):
        assert name not in asked
        asked[name] = fingerprint
        identity, costs = store[name]
        return costs if identity == fingerprint else None

    other = MeshMap.of(chain.geometry)
    other.compute_layers(CHAIN, stored=stored)
    assert {name for name, method in calls if method == "compute"} == {"near"}  # has no reuse()
    assert calls["ground", "reuse"] == calls["water", "reuse"] == 1
    for name, layer in other.layers.items():
        assert layer.identity is asked[name] and asked[name] == store[name][0]
        assert np.array_equal(layer.result.costs, chain.layers[name].result.costs)
    calls.clear()
    asked.clear()
    config = [dict(CHAIN[0], params={"combination_weight": 0.5})] + CHAIN[1:]
    other.compute_layers(config, stored=stored)
    assert {name for name, method in calls if method == "compute"} == {"near", "all"}
    ground = other.layers["ground"].result.costs
    free = np.isfinite(other.costs)
    difference = chain.layers["all"].result.costs[free] - other.layers["all"].result.costs[free]
    assert np.allclose(difference, 0.5 * ground[free], atol=1e-6)


@pytest.mark.parametrize("name", ["water", "all"])
@pytest.mark.parametrize(
    "found", [np.zeros(3, np.float32), np.full(64, -1, np.float32), "costs", RuntimeError("broken")]
)
def test_stored_costs_that_cannot_be_used_are_computed(chain, caplog, name, found):  # noqa: F811
    def stored(asked, _fingerprint):
        if asked == name and isinstance(found, Exception):
            raise found
        return found if asked == name else None

    before = {each: layer.result.costs for each, layer in chain.layers.items()}
    other = MeshMap.of(chain.geometry)
    other.compute_layers(CHAIN, stored=stored)
    assert not other.layer_errors and calls[name, "compute"] == 1
    for each, layer in other.layers.items():
        assert np.array_equal(layer.result.costs, before[each])
    (line,) = caplog.messages
    assert line.startswith("layer %s is computed anew: " % name)


def test_two_maps_of_one_geometry(chain, monkeypatch):  # noqa: F811
    counted = []
    for name in ("Topology", "face_normals", "vertex_normals"):
        original = getattr(mesh_geometry, name, None)
        if original is not None:
            monkeypatch.setattr(
                mesh_geometry,
                name,
                lambda *a, _name=name, _original=original, **k: (
                    counted.append(_name),
                    _original(*a, **k),
                )[1],
            )
    shared = mesh_geometry.MeshGeometry(chain.vertices, chain.faces)
    first, second = MeshMap.of(shared), MeshMap.of(shared)
    first.compute_layers(CHAIN)
    second.compute_layers(CHAIN[:1])
    for each in (first, second):
        assert each.vertex_normals.shape == (64, 3) and len(each.planning_costs().edge_weights)
    assert sorted(set(counted)) == sorted(counted) and "Topology" in counted
    assert list(first.layers) != list(second.layers) and first.topology is second.topology
    first.set_layer_parameters("ground", {"scale": 0.0})
    assert second.layers["ground"].params["scale"] == 1.0 and second.costs.any()
