"""Fields that go on and follow changes are, bit for bit, what a new solve gives."""

import gc
import threading

import numpy as np
import pytest
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.distance.dijkstra import DijkstraSolver, is_lengths_or_closed
from mesh_map.geometry.topology import Topology, edge_lengths
from meshes import small, soup, terrain

INF = np.float32(np.inf)
LIMIT = 1.0


class Setting:
    """A mesh with weights and costs that change, and the solver that belongs to them."""

    def __init__(self, mesh, seed=0, weights=None):
        self.random = np.random.default_rng(seed)
        self.topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
        self.weights = weights
        if weights is None:
            self.weights = edge_lengths(mesh.vertices, self.topology.edges)
        self.solver = DijkstraSolver(topology=self.topology, edge_lengths=self.weights)
        self.costs = np.zeros(self.topology.vertex_count, np.float32)

    def solve(self, source=0, **arguments):
        return self.solver.solve(source, self.costs, LIMIT, **arguments)

    def change_costs(self, count):
        """Other costs at some vertices, which are returned, ascending."""
        size = min(count, len(self.costs))
        changed = np.sort(self.random.choice(len(self.costs), size, replace=False))
        self.costs = self.costs.copy()
        self.costs[changed] = self.random.choice([0, 0, 0.5, 1.5, np.inf, np.nan], size)
        return changed

    def change_weights(self, vertices):
        """Other weights at edges of these vertices, shorter and longer ones and closed ones."""
        edges = self.topology.edges
        ends = np.zeros(len(self.costs), bool)
        ends[vertices] = True
        touched = np.flatnonzero(ends[edges].any(axis=1))
        factors = self.random.choice(np.array([0.25, 1, 1, 3], np.float32), len(touched))
        self.weights = self.weights.copy()
        known = np.where(np.isfinite(self.weights[touched]), self.weights[touched], 1)
        self.weights[touched] = known * factors
        self.weights[self.random.choice(touched, len(touched) // 5)] = np.inf
        self.solver = self.solver.with_weights(self.weights)

    def check(self, field, source=0):
        """It says what a new solve says, up to its limit, and its ways are as long as it says."""
        fresh = self.solver.solve(source, self.costs, LIMIT)
        expected = np.where(fresh.potential <= field.limit, fresh.potential, INF)
        assert field.potential.tobytes() == expected.tobytes()
        vertices = np.arange(len(expected))
        assert np.array_equal(field.reaches(vertices), np.isfinite(expected))
        moving = np.flatnonzero(field.predecessors != vertices)
        assert np.isfinite(expected[moving]).all()
        weights = self.weights_between(moving, field.predecessors[moving])
        assert np.array_equal(expected[field.predecessors[moving]] + weights, expected[moving])

    def weights_between(self, a, b):
        edges = self.topology.edges.astype(np.int64)
        keys = edges.min(axis=1) * len(self.costs) + edges.max(axis=1)
        order = np.argsort(keys)
        wanted = np.minimum(a, b).astype(np.int64) * len(self.costs) + np.maximum(a, b)
        return self.weights[order[np.searchsorted(keys[order], wanted)]]


@small
def test_steps_give_the_whole_field(mesh):
    setting = Setting(mesh)
    last = len(mesh.vertices) - 1
    whole = setting.solve()
    field = setting.solve(targets=[0])
    for targets in ([0], [last // 2], [0, last], None):
        field.extend(targets, offset=0.1)
        setting.check(field)
        asked = [] if targets is None else targets
        reachable = np.isfinite(whole.potential[asked])
        assert np.array_equal(field.reaches(asked), reachable)
    assert field.limit == np.inf
    assert field.potential.tobytes() == whole.potential.tobytes()


def test_a_step_ends_where_it_shall():
    setting = Setting(terrain(40))
    whole = setting.solve().potential
    field = setting.solve(max_distance=1.0)
    assert field.limit == 1.0
    setting.check(field)
    field.extend([20 * 40], offset=0.25)
    assert field.limit == whole[20 * 40] + np.float32(0.25)
    setting.check(field)
    field.extend([1599], max_distance=3.0)
    assert field.limit == 3.0 and not field.reaches([1599])[0]
    setting.check(field)
    field.extend([1], max_distance=2.0)
    assert field.limit == 3.0
    before = field.potential
    assert field.potential is before and not before.flags.writeable
    field.extend([1599])
    assert field.reaches([1599])[0] and before[1599] == INF
    setting.check(field)


def test_what_is_known_is_not_searched_again():
    setting = Setting(terrain(40))
    field = setting.solve(targets=[800])
    canceled = CancelFlag()
    canceled.set()
    field.extend([800, 0], cancel=canceled)
    with pytest.raises(Canceled):
        field.extend(cancel=canceled)


def test_arrays_stay_where_nothing_was_learned():
    setting = Setting(terrain(40))
    for field in (setting.solve(), setting.solve(targets=[800])):
        potential, predecessors = field.potential, field.predecessors
        field.extend([800])
        field.update(setting.costs.copy())
        assert field.potential is potential and field.predecessors is predecessors
        closed = setting.costs.copy()
        closed[1] = np.inf
        field.update(closed)
        assert field.potential is not potential and field.potential[1] == INF
        assert field.predecessors is not predecessors


@small
def test_updates_on_any_mesh(mesh):
    setting = Setting(mesh)
    source = [(0, 0.5), (len(mesh.vertices) // 2, 0.0)]
    fields = [setting.solve(source), setting.solve(source, max_distance=1.0)]
    for _ in range(6):
        changed = setting.change_costs(3)
        for field in fields:
            limit = field.limit
            field.update(setting.costs, changed)
            assert field.limit >= limit
            setting.check(field, source)
        setting.change_weights(changed)
        for field in fields:
            field.update(setting.costs, changed, solver=setting.solver)
            assert field.solver is setting.solver
            setting.check(field, source)


@pytest.mark.parametrize("count", [1, 10, 100, 1000])
@pytest.mark.parametrize("seed", range(3))
def test_updates_on_terrain(seed, count):
    """Few changes and many, named or found out, with steps in between."""
    setting = Setting(terrain(60), seed)
    field = setting.solve(1830, max_distance=2.0)
    for step in range(8):
        changed = setting.change_costs(count)
        if step % 2:
            setting.change_weights(changed)
        field.update(setting.costs, changed if step % 3 else None, solver=setting.solver)
        setting.check(field, 1830)
        if step == 4:
            field.extend([int(changed[0])], offset=0.3)
            setting.check(field, 1830)
    field.extend()
    setting.check(field, 1830)


@pytest.mark.parametrize("seed", range(30))
def test_updates_with_ties_and_zeros(seed):
    mesh = soup(seed, 30, 40)
    random = np.random.default_rng(seed)
    choice = np.array([0, 0.1, 0.2, 0.3, 7, np.inf], np.float32)
    count = Topology(faces=mesh.faces, vertex_count=30).edge_count
    setting = Setting(mesh, seed, random.choice(choice, count))
    field = setting.solve()
    for _ in range(5):
        changed = setting.change_costs(4)
        setting.change_weights(changed)
        field.update(setting.costs, changed, solver=setting.solver)
        setting.check(field)


def test_closing_and_opening_the_source():
    setting = Setting(terrain(20))
    whole = setting.solve(5)
    field = setting.solve(5)
    closed = setting.costs.copy()
    closed[5] = np.inf
    assert field.update(closed, [5]) > 0
    assert not np.isfinite(field.potential).any() and len(field.way_from(5)) == 0
    field.update(setting.costs, [5])
    assert field.potential.tobytes() == whole.potential.tobytes()
    assert list(field.way_from(5)) == [5]


def test_an_update_without_a_change_does_nothing():
    setting = Setting(terrain(30))
    for field in (setting.solve(), setting.solve(max_distance=1.0)):
        costs = setting.costs.copy()
        costs[100:200] = 0.9  # all below the limit
        everywhere = np.arange(len(costs))
        assert field.update(costs, everywhere) == 0
        assert field.update(costs) == 0
        same = setting.solver.with_weights(setting.weights.copy())
        assert field.update(costs, everywhere, solver=same) == 0
        assert field.update(None) == 0
        setting.check(field)


def test_an_update_looks_at_little_where_little_depends_on_it():
    setting = Setting(terrain(60))
    field = setting.solve()
    setting.costs = setting.costs.copy()
    setting.costs[3590:3593] = np.inf  # far from the source
    assert 3 <= field.update(setting.costs, [3590, 3591, 3592]) < 200
    setting.check(field)


def test_a_cancelled_update_can_go_on():
    setting = Setting(terrain(80))
    field = setting.solve(0)
    changed = setting.change_costs(600)
    setting.costs[0] = 0
    flag = CancelFlag()
    flag.set()
    with pytest.raises(Canceled):
        field.update(setting.costs, changed, cancel=flag)
    assert field.limit < np.inf
    setting.check(field)
    field.extend()
    setting.check(field)


def test_the_arguments_are_copied_unless_they_are_read_only():
    setting = Setting(terrain(20))
    weights, costs = setting.weights.copy(), setting.costs.copy()
    solver = DijkstraSolver(topology=setting.topology, edge_lengths=weights)
    field = solver.solve(0, costs, LIMIT, max_distance=0.5)
    costs[:], weights[:] = np.inf, 1
    field.extend()
    assert np.isfinite(field.potential).all()
    setting.check(field)
    costs[:] = 0
    field.update(costs)
    costs[:] = np.inf
    setting.check(field)
    costs.flags.writeable = False
    assert solver.with_weights(solver.edge_lengths).edge_lengths is solver.edge_lengths


def test_a_field_is_its_own_while_others_come_and_go():
    setting = Setting(terrain(40))
    kept = setting.solve(targets=[500])
    before = kept.potential.copy()
    for round_ in range(20):
        field = setting.solve(round_, max_distance=0.1 * round_)
        setting.check(field, round_)
        del field
        gc.collect()
    assert kept.potential.tobytes() == before.tobytes()
    setting.check(kept)
    kept.extend()
    setting.check(kept)


def test_readers_and_a_writer_at_a_time():
    setting = Setting(terrain(80))
    closed = setting.costs.copy()
    closed[80 * 40 : 80 * 40 + 79] = np.inf
    expected = {setting.solve().potential.tobytes()}
    expected.add(setting.solver.solve(0, closed, LIMIT).potential.tobytes())
    field, seen, stop = setting.solve(), [], threading.Event()

    def read():
        while not stop.is_set():
            seen.append(field.potential.tobytes() in expected)
            field.way_from(6399)

    reader = threading.Thread(target=read)
    reader.start()
    try:
        for step in range(40):
            field.update(setting.costs if step % 2 else closed)
    finally:
        stop.set()
        reader.join()
    assert seen and all(seen)
    setting.check(field)


def test_an_update_of_costs_keeps_the_weights_that_another_thread_has_just_set():
    setting = Setting(terrain(20))
    field, costs = setting.solve(), setting.costs.copy()
    setting.change_weights(np.arange(100))
    heavier = setting.solver

    class Gate:
        """Lets the other update go first."""

        def __init__(self):
            self.lock, self.is_open = field._lock, False

        def __enter__(self):
            if not self.is_open:
                self.is_open = True
                field.update(costs, solver=heavier)
            self.lock.acquire()

        def __exit__(self, *error):
            self.lock.release()

    field._lock = Gate()
    field.update(costs)
    assert field.solver is heavier
    setting.check(field)


def test_wrong_updates_change_nothing():
    setting = Setting(terrain(5))
    field = setting.solve()
    other = Setting(terrain(5)).solver
    for arguments, message in (
        (dict(vertex_costs=np.zeros(24)), r"vertex_costs has to have the shape \(25\)"),
        (dict(vertex_costs=np.zeros(24), changed=[1]), r"vertex_costs has to have the shape"),
        (dict(vertex_costs=None, changed=[25]), "changed vertex 25 does not exist: there are 25"),
        (dict(vertex_costs=None, solver=other), "the solver is of another topology than the field"),
        (
            dict(vertex_costs=None, cancel=object()),
            "cancel has to be a mesh_map.base.cancel.CancelFlag",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            field.update(**arguments)
        setting.check(field)


def test_lengths_or_closed():
    lengths = np.arange(5000, dtype=np.float32)
    weights = lengths.copy()
    assert is_lengths_or_closed(lengths, lengths) and is_lengths_or_closed(weights, lengths)
    weights[[0, 4999]] = np.inf
    assert is_lengths_or_closed(weights, lengths)
    for wrong in (17, np.nan):
        weights[4000] = wrong
        assert not is_lengths_or_closed(weights, lengths)
