"""Layers that do not answer: they count as failed, and nobody else waits for them."""

import threading

import numpy as np
import pytest
from mesh_map import MeshMap, MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer_worker import seconds_for
from mesh_msgs.testing import wait_until
from toy_layers import TYPES, DataLayer, NeighborLayer, calls, entry, grid_map
from toy_layers import toys  # noqa: F401

SHORT = 3.0  # seconds; far more than any call that does not hang takes
WAIT = 60.0
FAULT = "it hangs: no answer within %g s (layer_timeout); load the map anew" % SHORT


class Hang:
    """Where layers hang, and until when."""

    where = ""
    begun, end = threading.Semaphore(0), threading.Event()

    @classmethod
    def at(cls, where):
        if where == cls.where:
            end = cls.end  # of this test
            cls.begun.release()
            assert end.wait(WAIT)


class HangingLayer(DataLayer):
    """Hangs in the method that is set."""

    PARAMETERS = DataLayer.PARAMETERS + (Parameter("depth", 1.0),)

    def __init__(self, *args):
        Hang.at("__init__")
        super().__init__(*args)

    def announce(self, geometry):
        Hang.at("announce")

    def checked_changes(self, values):
        Hang.at("checked_changes")
        return super().checked_changes(values)

    def fingerprint(self, mesh_map, inputs):
        Hang.at("fingerprint")
        return super().fingerprint(mesh_map, inputs)

    def compute(self, mesh_map, inputs):
        Hang.at("compute")
        return super().compute(mesh_map, inputs)

    def update(self, *args):
        Hang.at("update")
        return super().update(*args)

    def reuse(self, *args):
        Hang.at("reuse")
        return super().reuse(*args)

    def clear(self):
        Hang.at("clear")
        return 1


class HangingReader(NeighborLayer):
    def update(self, *args):
        Hang.at("read")
        return super().update(*args)


@pytest.fixture(autouse=True)
def hang(toys, monkeypatch):  # noqa: F811
    monkeypatch.setitem(TYPES, "hanging", HangingLayer)
    monkeypatch.setitem(TYPES, "hanging reader", HangingReader)
    monkeypatch.setattr(Hang, "where", "")
    monkeypatch.setattr(Hang, "begun", threading.Semaphore(0))
    monkeypatch.setattr(Hang, "end", threading.Event())
    yield
    Hang.end.set()


CONFIG = [entry("ground", "data"), entry("deep", "hanging"), entry("all", "sum")]


def made(config=CONFIG, timeout=SHORT):
    mesh_map = grid_map()
    mesh_map.layer_timeout = timeout
    mesh_map.compute_layers(config)
    return mesh_map


def in_thread(work, *args):
    thread = threading.Thread(target=work, args=args, daemon=True)
    thread.start()
    assert Hang.begun.acquire(timeout=WAIT)
    return thread


def no_call_is_left():
    """Whether the calls of the layer deep that were left behind have ended."""
    return "layer deep" not in [thread.name for thread in threading.enumerate()]


def test_time_goes_by_started_millions_of_faces():
    assert [seconds_for(count, 60.0) for count in (1, 100, 1000000, 1000001, 1500000)] == [
        60.0,
        60.0,
        60.0,
        120.0,
        120.0,
    ]
    assert seconds_for(5, None) is None


@pytest.mark.parametrize("where", ["__init__", "announce", "compute", "fingerprint"])
def test_a_layer_that_hangs_at_the_start(where):
    Hang.where = where
    mesh_map = grid_map()
    mesh_map.layer_timeout = SHORT
    mesh_map.compute_layers(CONFIG, stored=lambda *_: None)
    assert mesh_map.fault == "layer deep: " + FAULT
    assert list(mesh_map.layers) == ["ground", "all"]
    Hang.where = ""
    Hang.end.set()  # what it gives now comes too late
    wait_until(no_call_is_left, "the end of the call")
    mesh_map.set_layer_parameters("ground", {"scale": 2.0})
    assert list(mesh_map.layers) == ["ground", "all"] and "it hangs" in mesh_map.fault
    mesh_map.compute_layers(CONFIG)
    assert mesh_map.fault == "" and "deep" in mesh_map.layers


@pytest.mark.parametrize(
    "where, change",
    [
        ("compute", lambda mesh_map: mesh_map.set_layer_parameters("deep", {"depth": 2.0})),
        ("announce", lambda mesh_map: mesh_map.set_layer_parameters("deep", {"depth": 2.0})),
        ("reuse", lambda mesh_map: mesh_map.set_layer_parameters("deep", {"threshold": 2.0})),
        ("update", lambda mesh_map: mesh_map.refresh_layer("deep")),
        ("clear", lambda mesh_map: mesh_map.clear_layers()),
        ("checked_changes", lambda mesh_map: mesh_map.set_layer_parameters("deep", {"depth": 2})),
        ("fingerprint", lambda mesh_map: mesh_map.layers_to_store()),
    ],
)
def test_a_layer_that_hangs_later_is_left_behind(where, change, toys):  # noqa: F811
    mesh_map = made()
    before = mesh_map.layers["deep"].result
    toys["deep"] = np.full(64, 3, np.float32)
    Hang.where = where
    try:
        change(mesh_map)
    except MeshMapError as error:
        assert str(error) == FAULT
    assert mesh_map.fault == "layer deep: " + FAULT
    Hang.where = ""
    Hang.end.set()  # what it gives now comes too late
    wait_until(no_call_is_left, "the end of the call")
    calls.clear()
    mesh_map.refresh_layer("deep")
    with pytest.raises(MeshMapError, match="it hangs"):
        mesh_map.set_layer_parameters("deep", {"depth": 3.0})
    assert mesh_map.layers["deep"].result is before and not calls["deep", "update"]
    mesh_map.set_layer_parameters("ground", {"scale": 2.0})
    mesh_map.set_layer_parameters("deep", {"enabled": False})
    assert mesh_map.fault == ""
    with pytest.raises(MeshMapError, match="it hangs"):
        mesh_map.set_layer_parameters("deep", {"enabled": True})


def test_a_layer_that_hangs_as_it_is_to_be_stored_is_named_and_the_others_are_not_lost():
    mesh_map = made()
    before = mesh_map.layers["deep"].identity
    mesh_map.set_layer_parameters("deep", {"depth": 2.0})
    Hang.where = "fingerprint"
    layers, errors = mesh_map.layers_to_store()
    assert list(layers) == ["ground", "all"] and errors == {"deep": FAULT}
    assert mesh_map.fault == "layer deep: " + FAULT
    Hang.where = ""
    Hang.end.set()
    wait_until(no_call_is_left, "the end of the call")
    assert mesh_map.layers["deep"].identity["depth"] == 2.0 != before["depth"]
    assert list(mesh_map.layers_to_store()[0]) == ["ground", "all"]  # it is not asked any more


def test_others_change_while_a_layer_is_asked_what_is_to_be_stored(toys):  # noqa: F811
    """What is stored of each is of one moment."""
    toys.update(ground=np.ones(64, np.float32), deep=np.ones(64, np.float32))
    mesh_map, stored = made(timeout=WAIT), []
    Hang.where = "fingerprint"
    thread = in_thread(lambda: stored.append(mesh_map.layers_to_store()))
    mesh_map.set_layer_parameters("ground", {"scale": 5.0})
    assert mesh_map.costs[0] == 5 + 1 + 6 and thread.is_alive()
    Hang.where = ""
    Hang.end.set()
    thread.join(WAIT)
    ((layers, errors),) = stored
    assert not errors and list(layers) == ["ground", "deep", "all"]
    assert layers["ground"].identity["scale"] == layers["ground"].params["scale"] == 1.0
    assert layers["ground"].result.costs[0] == 1 and layers["all"].result.costs[0] == 6
    mesh_map.catch_up()
    assert layers["all"].identity == mesh_map.layers["all"].identity


def test_others_do_not_wait_for_a_layer_that_hangs(toys):  # noqa: F811
    toys.update(ground=np.ones(64, np.float32), deep=np.ones(64, np.float32))
    mesh_map = made(timeout=WAIT)
    Hang.where = "compute"
    thread = in_thread(mesh_map.set_layer_parameters, "deep", {"scale": 3.0})
    mesh_map.set_layer_parameters("ground", {"scale": 5.0, "factor": 0.5})
    mesh_map.set_settings(combination="max")
    mesh_map.refresh_layer("ground")
    mesh_map.set_layer_parameters("all", {"factor": 0.25})
    assert thread.is_alive() and mesh_map.fault == ""
    assert mesh_map.layers["all"].result.costs[0] == 6 and mesh_map.costs[0] == 2.5
    Hang.end.set()
    thread.join(WAIT)
    assert mesh_map.layers["all"].result.costs[0] == 8 and mesh_map.costs[0] == 3


def test_others_do_not_wait_for_a_layer_that_hangs_as_it_reads(toys):  # noqa: F811
    config = [entry("water", "data"), entry("near", "hanging reader", ["water"])]
    mesh_map = made(config + [entry("ground", "data")], timeout=WAIT)
    Hang.where = "read"
    toys["water"] = np.full(64, 2, np.float32)
    thread = in_thread(mesh_map.refresh_layer, "water")
    toys["ground"] = np.ones(64, np.float32)
    mesh_map.refresh_layer("ground")
    assert mesh_map.costs[0] == 3 and thread.is_alive()
    assert mesh_map.stale_layers == ("near",)
    Hang.end.set()
    thread.join(WAIT)
    assert mesh_map.costs[0] == 4 and mesh_map.stale_layers == ()


BOTH = [
    entry("ground", "data"),
    entry("obstacles", "data"),
    entry("near", "hanging reader", ["ground", "obstacles"]),
    entry("all", "max"),
]


def see(mesh_map, toys, *vertices):  # noqa: F811
    """Obstacles there, as a cloud has them."""
    toys["obstacles"] = np.zeros(64, np.float32)
    toys["obstacles"][list(vertices)] = np.inf
    mesh_map.refresh_layer("obstacles")


def check_as_anew(mesh_map, config):
    fresh = MeshMap.of(mesh_map.geometry)
    fresh.compute_layers(config)
    assert mesh_map.stale_layers == () and mesh_map.fault == ""
    for name, layer in fresh.layers.items():
        for found, expected in list(zip(mesh_map.layers[name].result, layer.result))[:2]:
            assert np.array_equal(found, expected)
    assert np.array_equal(mesh_map.costs, fresh.costs, equal_nan=True)


def test_what_a_sensor_sees_does_not_wait_for_layers_that_are_computed(toys):  # noqa: F811
    """Another layer has changed, and one that reads both is computed: clouds are in the costs."""
    toys["ground"] = np.arange(64, dtype=np.float32) / 64
    mesh_map, told = made(BOTH, timeout=WAIT), []
    mesh_map.add_listener(told.append)
    Hang.where = "read"
    thread = in_thread(mesh_map.set_layer_parameters, "ground", {"scale": 2.0})
    for vertices in ((20,), (20, 21), (40,)):
        see(mesh_map, toys, *vertices)
        assert np.flatnonzero(np.isinf(mesh_map.planning_costs().costs)).tolist() == [*vertices]
        assert mesh_map.stale_layers == ("near",) and mesh_map.fault == "" and thread.is_alive()
        assert told[-1][-1].name == "Combined Costs" and vertices[-1] in told[-1][-1].vertices
    Hang.end.set()
    thread.join(WAIT)
    wait_until(lambda: not mesh_map.stale_layers, "the layer that reads both", WAIT)
    check_as_anew(mesh_map, [dict(BOTH[0], params={"scale": 2.0}), *BOTH[1:]])


def test_what_a_sensor_sees_does_not_wait_for_who_reads_it(toys):  # noqa: F811
    mesh_map = made(BOTH, timeout=WAIT)
    Hang.where = "read"
    thread = in_thread(see, mesh_map, toys, 20)
    assert np.isinf(mesh_map.costs[20]) and mesh_map.stale_layers == ("near", "all")
    Hang.end.set()
    thread.join(WAIT)
    check_as_anew(mesh_map, BOTH)


def test_who_changes_a_layer_does_not_wait_for_all_changes_by_others(toys):  # noqa: F811
    """One that reads it is behind again and again: a thread of its own goes on."""
    toys["ground"] = np.arange(64, dtype=np.float32) / 64
    mesh_map = made(BOTH, timeout=WAIT)
    Hang.where = "read"
    thread = in_thread(mesh_map.set_layer_parameters, "ground", {"scale": 2.0})
    see(mesh_map, toys, 20)  # leaves the layer "near" to that thread
    first, Hang.end = Hang.end, threading.Event()
    first.set()
    thread.join(WAIT)
    assert not thread.is_alive() and Hang.begun.acquire(timeout=WAIT)
    assert "near" in mesh_map.stale_layers
    Hang.end.set()
    wait_until(lambda: not mesh_map.stale_layers, "the layer that reads both", WAIT)
    check_as_anew(mesh_map, [dict(BOTH[0], params={"scale": 2.0}), *BOTH[1:]])


def test_who_keeps_changes_out_evaluates_what_was_left_to_it(toys):  # noqa: F811
    mesh_map = made(BOTH, timeout=WAIT)
    entered, go_on = threading.Event(), threading.Event()

    def keep_out():
        with mesh_map.layer_set.locked(["near"]):
            entered.set()
            assert go_on.wait(WAIT)
        with mesh_map.unchanged():
            pass

    thread = threading.Thread(target=keep_out, daemon=True)
    thread.start()
    assert entered.wait(WAIT)
    see(mesh_map, toys, 20)
    assert "near" in mesh_map.stale_layers and np.isinf(mesh_map.costs[20])
    go_on.set()
    thread.join(WAIT)
    check_as_anew(mesh_map, BOTH)


def test_what_is_read_of_a_change_that_fails_is_as_before(toys):  # noqa: F811
    """Parameters that are being tried count for nobody else."""
    toys.update(ground=np.ones(64, np.float32), deep=np.ones(64, np.float32))
    mesh_map = made(CONFIG[:2] + [entry("all", "sum")], timeout=WAIT)
    Hang.where = "compute"
    values = {"depth": 2.0, "factor": 0.0, "combination_weight": 0.0, "fails": True}
    refusals = []

    def change():
        try:
            mesh_map.set_layer_parameters("deep", values)
        except MeshMapError as error:
            refusals.append(str(error))

    thread = in_thread(change)
    mesh_map.set_layer_parameters("ground", {"scale": 2.0})
    assert mesh_map.layers["all"].result.costs[0] == 3 and mesh_map.costs[0] == 6
    Hang.end.set()
    thread.join(WAIT)
    assert refusals == ["layer deep: RuntimeError: it was told to fail"]
    assert mesh_map.costs[0] == 6


@pytest.mark.parametrize("timeout", [None, WAIT])
def test_changes_from_many_threads_are_as_if_computed_anew(timeout):
    names = ["a", "b", "c", "d"]
    config = [entry(name, "data") for name in names]
    config += [entry("ab", "neighbors", ["a", "b"]), entry("cd", "sum", ["c", "d"])]
    config += [entry("all", "mean"), entry("again", "neighbors", ["cd", "ab"])]
    for number, name in enumerate(names):
        DataLayer.ALL[name] = np.random.default_rng(number).uniform(0, 6, 64).astype(np.float32)
    mesh_map = made(config, timeout)
    last = {}

    def change(seed):
        random = np.random.default_rng(seed)
        name = names[seed]
        for _ in range(40):
            last[name] = {
                "scale": float(random.uniform(0, 2)),
                "factor": float(random.uniform(0, 1)),
                "combination_weight": float(random.uniform(0, 1)),
                "enabled": bool(random.integers(4)),
            }
            mesh_map.set_layer_parameters(name, last[name])
            mesh_map.refresh_layer(names[random.integers(4)])
            mesh_map.set_settings(combination=("sum", "max", "normalized")[random.integers(3)])

    threads = [threading.Thread(target=change, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(WAIT)
    mesh_map.set_settings(combination="sum")
    wait_until(lambda: not any(thread.is_alive() for thread in threads), "the end of all changes")
    fresh = MeshMap.of(mesh_map.geometry)
    fresh.compute_layers(
        [dict(one, params={**one["params"], **last.get(one["name"], {})}) for one in config]
    )
    wait_until(lambda: not mesh_map.stale_layers, "what was left to other threads", WAIT)
    assert not mesh_map.fault
    for name, layer in fresh.layers.items():
        assert np.array_equal(
            mesh_map.layers[name].result.costs, layer.result.costs, equal_nan=True
        )
        assert np.array_equal(mesh_map.layers[name].result.lethal, layer.result.lethal)
    assert np.array_equal(mesh_map.costs, fresh.costs, equal_nan=True)
