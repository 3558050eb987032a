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
            cls.begun.release()
            assert cls.end.wait(WAIT)


class HangingLayer(DataLayer):
    """Hangs in the method that is set."""

    PARAMETERS = DataLayer.PARAMETERS + (Parameter("depth", 1.0),)

    def __init__(self, *args):
        Hang.at("__init__")
        super().__init__(*args)

    def announce(self, geometry):
        Hang.at("announce")

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
    assert mesh_map.costs[0] == 1 and thread.is_alive()
    Hang.end.set()
    thread.join(WAIT)
    assert mesh_map.costs[0] == 4


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
    assert not mesh_map.fault
    for name, layer in fresh.layers.items():
        assert np.array_equal(
            mesh_map.layers[name].result.costs, layer.result.costs, equal_nan=True
        )
        assert np.array_equal(mesh_map.layers[name].result.lethal, layer.result.lethal)
    assert np.array_equal(mesh_map.costs, fresh.costs, equal_nan=True)
