"""Changes of layers by several threads: who waits for whom, and what all are told, put together."""

import contextlib
import logging
import threading

import numpy as np
import pytest
from mesh_map import MeshMap, MeshMapError
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.settings import MapSettings
from mesh_map.map.mesh_map import COMBINED_COSTS
from toy_layers import CHAIN, told
from toy_layers import chain, toys  # noqa: F401

NO_WAIT = {"wait": False}
pytestmark = pytest.mark.usefixtures("toys")


@contextlib.contextmanager
def held(mesh_map, name, change):
    """Within, another thread makes the change, and has come to the evaluation of a layer that
    reads what it changes; afterwards that goes on to its end."""
    started, go_on = threading.Event(), threading.Event()
    layer = mesh_map.layers[name]
    update = layer.update

    def slow(*arguments):
        started.set()
        assert go_on.wait(20)
        return update(*arguments)

    layer.update = slow
    thread = threading.Thread(target=change)
    thread.start()
    try:
        assert started.wait(20)
        yield
    finally:
        go_on.set()
        thread.join(20)
        layer.update = update


def settle():
    """Waits for the threads that go on where others left layers behind them, and have told it."""
    for thread in threading.enumerate():
        if thread.name == "layers":
            thread.join(20)
            assert not thread.is_alive()


class Follower:
    """Has copies of all costs, which it keeps by what it is told: only at vertices told of."""

    def __init__(self, mesh_map):
        self.costs = {name: layer.result.costs for name, layer in mesh_map.layers.items()}
        self.costs[COMBINED_COSTS] = mesh_map.costs
        self.costs = {name: costs.copy() for name, costs in self.costs.items()}
        self.missed = []
        """What differed where it was not told of."""
        mesh_map.add_listener(self._listen)

    def _listen(self, changes):
        for change in changes:
            known = self.costs[change.name]
            known[change.vertices] = change.costs[change.vertices]
            self.missed += [(change.name, v) for v in np.flatnonzero(known != change.costs)]

    def check(self, mesh_map):
        """It has missed nothing, and has what the map has."""
        assert not self.missed
        for name, layer in mesh_map.layers.items():
            assert np.array_equal(self.costs[name], layer.result.costs), name
        assert np.array_equal(self.costs[COMBINED_COSTS], mesh_map.costs)


def test_a_change_beside_one_that_nobody_was_told_of_is_told_with_it(chain, toys):  # noqa: F811
    follower = Follower(chain)
    toys["water"] = np.where(np.arange(64) == 20, 3, toys["water"]).astype(np.float32)
    with held(chain, "near", lambda: chain.refresh_layer("water")):
        assert chain.layers["water"].result.costs[20] == 3 and not chain.told
        toys["ground"] = np.where(np.arange(64) == 50, 1, toys["ground"]).astype(np.float32)
        chain.refresh_layer("ground")
        assert chain.told
        follower.check(chain)
    follower.check(chain)


def test_nothing_changes_the_map_from_within_a_change(chain):  # noqa: F811
    for callback in ("progress", "on_layer"):

        def change(*_):
            chain.set_settings(combination="max")

        with pytest.raises(MeshMapError, match="cannot be changed by what a change"):
            chain.compute_layers(CHAIN, **{callback: change})
    assert chain.settings == MapSettings() and not chain.told


def test_readers_never_wait_for_a_change(chain):  # noqa: F811
    """While a layer is evaluated, what reads it is as before, and said to be stale."""
    planning, near = chain.planning_costs(), chain.layers["near"].result
    with held(chain, "near", lambda: chain.set_layer_parameters("water", {"scale": 0.5})):
        seen = (chain.planning_costs(), chain.costs, len(chain.planning_costs().edge_weights))
        assert chain.layers["water"].result.costs[10] == 4.5 and not chain.told
        assert "near" in chain.stale_layers and chain.layers["near"].result is near
    assert np.array_equal(seen[0].costs, seen[1]) and seen[2] == chain.topology.edge_count
    assert chain.planning_costs() is not planning and told(chain)[0] == ("water", 1)
    assert chain.stale_layers == ()


def test_what_is_saved_belongs_together(chain):  # noqa: F811
    """unchanged() keeps changes out, so that costs and fingerprints fit."""
    with chain.unchanged():
        thread = threading.Thread(target=chain.set_layer_parameters, args=("water", {"scale": 2.0}))
        thread.start()
        thread.join(0.1)
        assert thread.is_alive() and chain.layers["water"].identity["scale"] == 1.0
    thread.join(20)
    assert chain.layers["water"].identity["scale"] == 2.0


def test_changes_from_many_threads_are_told_in_order(chain, toys):  # noqa: F811
    """What listeners are told, put together, is what the map says in the end."""
    logging.disable(logging.CRITICAL)
    follower = Follower(chain)

    def work(seed):
        random = np.random.default_rng(seed)
        for _ in range(40):
            name = ("ground", "water")[random.integers(2)]
            chain.set_layer_parameters(name, {"scale": float(random.uniform(0, 2))})

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    settle()
    logging.disable(logging.NOTSET)
    assert chain.stale_layers == ()
    follower.check(chain)


def going_on():
    return [one.name for one in threading.enumerate()].count("layers")


def test_clouds_beside_changes_are_told_in_order_and_none_is_lost(chain, toys):  # noqa: F811
    """Sensors do not wait for layers that read theirs; one thread goes on for all of them."""
    follower, most = Follower(chain), []

    def see(name, seed):
        random = np.random.default_rng(seed)
        for _ in range(60):
            toys[name] = random.integers(0, 9, 64).astype(np.float32)
            chain.refresh_layer(name, wait=False)
            most.append(going_on())

    def change():
        random = np.random.default_rng(3)
        for _ in range(40):
            chain.set_layer_parameters("near", {"share": float(random.uniform(0, 1))})

    threads = [threading.Thread(target=see, args=job) for job in (("ground", 1), ("water", 2))]
    threads.append(threading.Thread(target=change))
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    chain.catch_up()
    assert chain.stale_layers == () and max(most) == 1
    settle()
    follower.check(chain)
    fresh = MeshMap.of(chain.geometry)
    fresh.compute_layers(CHAIN)
    fresh.set_layer_parameters("near", {"share": chain.layers["near"].params["share"]})
    assert np.array_equal(chain.costs, fresh.costs)


def test_all_who_read_have_their_turn_while_clouds_come(chain, toys):  # noqa: F811
    """One that is behind again as soon as it is evaluated does not keep others from it."""
    turns, clouds = [], 5
    near, all_of_them = chain.layers["near"], chain.layers["all"]
    updates = near.update, all_of_them.update

    def see():
        toys["water"] = np.roll(toys["water"], 1)
        thread = threading.Thread(target=chain.refresh_layer, args=("water",), kwargs=NO_WAIT)
        thread.start()
        thread.join(20)
        assert not thread.is_alive()

    def update_near(*arguments):
        turns.append("near")
        if turns.count("near") < clouds:
            see()
        return updates[0](*arguments)

    def update_all(*arguments):
        turns.append("all")
        return updates[1](*arguments)

    near.update, all_of_them.update = update_near, update_all
    see()
    settle()
    assert turns == ["near", "all"] * clouds
    fresh = MeshMap.of(chain.geometry)
    fresh.compute_layers(CHAIN)
    assert np.array_equal(chain.costs, fresh.costs)


def test_who_waits_for_what_is_behind(chain, toys):  # noqa: F811
    """catch_up() returns when others have evaluated what they hold, and not before."""
    toys["water"] = np.roll(toys["water"], 1)
    done = threading.Event()
    with held(chain, "near", lambda: chain.refresh_layer("water", wait=False)):
        thread = threading.Thread(target=lambda: (chain.catch_up(), done.set()))
        thread.start()
        assert not done.wait(0.2) and chain.stale_layers == ("near", "all")
    thread.join(20)
    assert done.is_set() and chain.stale_layers == ()


def test_what_planners_read_belongs_together_while_all_changes(chain, toys):  # noqa: F811
    """Clouds, parameters and settings from threads of their own; weights are of the same costs."""
    done, seen = threading.Event(), []

    def plan():
        last = -1
        while not done.is_set():
            planning = chain.planning_costs()
            weights = planning.edge_weights
            fresh = PlanningCosts(
                0, planning.costs, chain.geometry, planning._settings
            ).edge_weights
            assert np.array_equal(weights.view(np.uint32), fresh.view(np.uint32))
            assert planning.version >= last and planning.costs.shape == (64,)
            last = planning.version
        seen.append(last)

    def clouds():
        random = np.random.default_rng(1)
        for _ in range(150):
            water = toys["water"].copy()
            water[random.integers(0, 64, 3)] = random.choice([0, 1, 9])
            toys["water"] = water
            chain.refresh_layer("water")

    def reconfigure():
        random = np.random.default_rng(2)
        for _ in range(60):
            chain.set_layer_parameters("ground", {"factor": float(random.uniform())})
            chain.set_settings(edge_cost_factor=float(random.integers(3)))
            chain.set_settings(edge_weight=("mean", "difference")[random.integers(2)])

    planners = [threading.Thread(target=plan) for _ in range(2)]
    others = [threading.Thread(target=clouds), threading.Thread(target=reconfigure)]
    for thread in planners + others:
        thread.start()
    for thread in others:
        thread.join(60)
    done.set()
    for thread in planners:
        thread.join(60)
    assert len(seen) == 2 and max(seen) <= chain.planning_costs().version
    assert chain.planning_costs().version > 50
