"""The Dijkstra kernel: the same bits as a plain heap Dijkstra in float32, and SciPy's distances."""

import heapq
import threading
import time

import numpy as np
import pytest
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.geometry.topology import Topology, edge_lengths
from meshes import BOTANICAL, SMALL, TestMesh, data_mesh, real, small, soup, terrain
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

INF = np.float32(np.inf)


class Graph:
    def __init__(self, mesh, lengths=None):
        self.topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
        self.lengths = lengths
        if lengths is None:
            self.lengths = edge_lengths(mesh.vertices, self.topology.edges)
        self.solver = DijkstraSolver(topology=self.topology, edge_lengths=self.lengths)

    def heap_dijkstra(self, sources, blocked=()):
        """Plain Dijkstra with sums in float32."""
        blocked = set(blocked)
        neighbors, edges = self.topology.neighbors.tolist(), self.topology.neighbor_edges.tolist()
        offsets = self.topology.neighbor_offsets.tolist()
        potential = np.full(self.topology.vertex_count, INF)
        queue = []
        for vertex, distance in sources:
            if vertex not in blocked and distance < potential[vertex]:
                potential[vertex] = distance
                heapq.heappush(queue, (np.float32(distance), vertex))
        while queue:
            distance, vertex = heapq.heappop(queue)
            if distance > potential[vertex]:
                continue
            for k in range(offsets[vertex], offsets[vertex + 1]):
                to = neighbors[k]
                longer = np.float32(distance + self.lengths[edges[k]])
                if to not in blocked and longer < potential[to]:
                    potential[to] = longer
                    heapq.heappush(queue, (longer, to))
        return potential

    def check_ways(self, result, sources):
        """Each predecessor is a neighbor, and its distance plus the edge is the distance."""
        t = self.topology
        starts = dict(sources)
        reached = np.isfinite(result.potential)
        own = result.predecessors == np.arange(t.vertex_count)
        assert own[~reached].all()
        for vertex in np.flatnonzero(reached):
            before = result.predecessors[vertex]
            if own[vertex]:
                assert result.potential[vertex] == np.float32(starts[vertex])
                continue
            row = slice(t.neighbor_offsets[vertex], t.neighbor_offsets[vertex + 1])
            edge = t.neighbor_edges[row][t.neighbors[row].tolist().index(before)]
            length = np.float32(result.potential[before] + self.lengths[edge])
            assert length == result.potential[vertex]
            way = result.way_from(vertex)
            assert len(set(way.tolist())) == len(way) and int(way[-1]) in starts


def same_bits(a, b):
    return a.dtype == b.dtype == np.float32 and a.tobytes() == b.tobytes()


@small
def test_same_bits_as_a_heap(mesh):
    graph = Graph(mesh)
    for source in {0, len(mesh.vertices) // 2}:
        result = graph.solver.solve(source)
        assert same_bits(result.potential, graph.heap_dijkstra([(source, 0.0)]))
        graph.check_ways(result, [(source, 0.0)])


@real
def test_same_bits_as_a_heap_on_real_meshes(name):
    graph = Graph(data_mesh(name))
    source = 1000
    result = graph.solver.solve(source)
    assert same_bits(result.potential, graph.heap_dijkstra([(source, 0.0)]))
    graph.check_ways(result, [(source, 0.0)])
    component = graph.topology.components
    reached = np.isfinite(result.potential)
    assert np.array_equal(reached, component == component[source])


def test_scipy_finds_the_same_distances():
    graph = Graph(data_mesh(BOTANICAL))
    t = graph.topology
    matrix = csr_matrix(
        (graph.lengths[t.neighbor_edges].astype(np.float64), t.neighbors, t.neighbor_offsets),
        (t.vertex_count, t.vertex_count),
    )
    for source in (0, 12_345):
        expected = dijkstra(matrix, indices=source)
        np.testing.assert_allclose(graph.solver.solve(source).potential, expected, rtol=2e-5)


def test_known_distance_on_the_tray():
    """The sheet of the released software: 17.9293 m from vertex 1002 to 1023."""
    graph = Graph(data_mesh("tray.ply"))
    assert graph.solver.solve(1002).potential[1023] == pytest.approx(17.9293, abs=1e-4)


@pytest.mark.parametrize("seed", range(40))
def test_random_weights_with_ties_and_zeros(seed):
    """Few different lengths, some of them 0: many ways of the same length."""
    mesh = soup(seed, 30, 40)
    random = np.random.default_rng(seed)
    edges = Topology(faces=mesh.faces, vertex_count=30).edge_count
    lengths = random.choice(np.array([0, 0.1, 0.2, 0.3, 7], np.float32), edges)
    graph = Graph(mesh, lengths)
    sources = [(int(v), float(d)) for v, d in zip(random.integers(0, 30, 3), (0.0, 0.25, 3.5))]
    blocked = random.integers(0, 30, 5).tolist()
    costs = np.zeros(30, np.float32)
    costs[blocked] = random.choice(np.array([np.inf, np.nan, 1.5], np.float32), 5)
    result = graph.solver.solve(sources, vertex_costs=costs, cost_limit=1.0)
    expected = graph.heap_dijkstra(sources, blocked)
    assert same_bits(result.potential, expected)
    least = {v: min(d for w, d in sources if w == v) for v, _ in sources}
    graph.check_ways(result, list(least.items()))


def test_lengths_far_too_different_for_one_round_of_buckets():
    mesh = soup(3, 40, 60)
    count = Topology(faces=mesh.faces, vertex_count=40).edge_count
    lengths = (10.0 ** np.random.default_rng(0).uniform(-30, 30, count)).astype(np.float32)
    lengths[:3] = 0, 1e-45, np.inf
    graph = Graph(mesh, lengths)
    sources = [(0, 0.0), (7, 1e20)]
    assert same_bits(graph.solver.solve(sources).potential, graph.heap_dijkstra(sources))
    # A start so far out that adding an edge does not change the sum, or jumps by many edges.
    graph = Graph(mesh, np.full(count, 0.75, np.float32))
    for start in (1.0, 1e6, 2e7, 5e8, 1e38):
        sources = [(0, start)]
        assert same_bits(graph.solver.solve(sources).potential, graph.heap_dijkstra(sources))


def test_rounding_beyond_the_last_bucket():
    """At 2e7, float32 has steps of 2: an edge of 1.2 adds 2, the width of 20 buckets of 16."""
    mesh = terrain(30)
    count = Topology(faces=mesh.faces, vertex_count=900).edge_count
    lengths = np.full(count, 0.1, np.float32)
    lengths[np.random.default_rng(0).permutation(count)[:20]] = 1.2
    lengths[:30] = 1.2
    graph = Graph(mesh, lengths)
    sources = [(0, 2e7)]
    expected = graph.heap_dijkstra(sources)
    assert len(np.unique(expected)) > 1
    assert same_bits(graph.solver.solve(sources).potential, expected)


def test_blocked_vertices_are_never_passed():
    """A wall of lethal, unknown or expensive vertices with a gap: the way leads through the gap."""
    size = 30
    mesh = terrain(size)
    graph = Graph(mesh)
    for blocking, limit in ((np.inf, np.inf), (np.nan, np.inf), (0.8, 0.7), (np.inf, 5.0)):
        costs = np.zeros(len(mesh.vertices), np.float32)
        wall = size * 15 + np.arange(size - 1)
        costs[wall] = blocking
        result = graph.solver.solve(0, costs, limit)
        assert np.isinf(result.potential[wall]).all()
        assert np.array_equal(result.predecessors[wall], wall)
        assert np.isfinite(np.delete(result.potential, wall)).all()
        way = result.way_from(len(mesh.vertices) - size)
        assert size * 15 + size - 1 in way and not set(way.tolist()) & set(wall.tolist())
        costs[size * 15 + size - 1] = blocking
        closed = graph.solver.solve(0, costs, limit)
        assert np.isfinite(closed.potential).sum() == size * 15
        assert len(closed.way_from(len(mesh.vertices) - 1)) == 0
    assert same_bits(
        graph.solver.solve(0, np.full_like(costs, 0.7), 0.7).potential,
        graph.solver.solve(0).potential,
    )


def test_a_blocked_source_starts_nothing():
    graph = Graph(terrain(5))
    costs = np.zeros(25, np.float32)
    costs[3] = np.inf
    result = graph.solver.solve(3, costs)
    assert np.isinf(result.potential).all() and len(result.way_from(3)) == 0
    for vertex in (-1, 25, 1 << 80):
        for ask in (result.way_from, lambda vertex: result.reaches([3, vertex])):
            with pytest.raises(ValueError, match="^vertex %d does not exist: there are" % vertex):
                ask(vertex)


@pytest.mark.parametrize("offset", [0.0, 0.2, 1.0, np.inf])
def test_early_stop(offset):
    graph = Graph(terrain(50))
    full = graph.solver.solve(0).potential
    for targets in ([1], [0], [505, 1010], [2499]):
        result = graph.solver.solve(0, targets=targets, offset=offset)
        limit = np.float32(full[targets].max() + np.float32(offset))
        expected = np.where(full <= limit, full, INF)
        assert same_bits(result.potential, expected)
        graph.check_ways(result, [(0, 0.0)])


def test_targets_that_cannot_be_reached_give_the_whole_field():
    mesh = next(m for m in SMALL if m.name == "two_components")
    graph = Graph(mesh)
    other = int(np.flatnonzero(graph.topology.components)[0])
    full = graph.solver.solve(0).potential
    assert same_bits(graph.solver.solve(0, targets=[1, other]).potential, full)
    costs = np.zeros(len(mesh.vertices), np.float32)
    costs[1] = np.inf
    blocked = graph.solver.solve(0, costs, targets=[1]).potential
    assert same_bits(blocked, graph.heap_dijkstra([(0, 0.0)], [1]))


def test_cancel():
    graph = Graph(terrain(100))
    flag = CancelFlag()
    field = graph.solver.solve(0, max_distance=1.0, cancel_flag=flag)
    before = field.potential
    flag.set()
    with pytest.raises(Canceled):
        graph.solver.solve(0, cancel_flag=flag)
    with pytest.raises(Canceled):
        field.extend(cancel=flag)
    assert 1 < field.limit < np.inf
    expected = graph.solver.solve(0).potential
    assert same_bits(field.potential, np.where(expected <= field.limit, expected, INF))
    assert not same_bits(field.potential, before)
    field.extend()
    assert same_bits(field.potential, expected) and field.limit == np.inf


def test_cancel_while_solving():
    """Whenever that happens, in two solves that run at once."""
    graph = Graph(terrain(200))
    for attempt in range(10):
        flag, results = CancelFlag(), []

        def solve():
            try:
                results.append(np.isfinite(graph.solver.solve(0, cancel_flag=flag).potential).all())
            except Canceled:
                results.append(flag.is_set())

        threads = [threading.Thread(target=solve) for _ in range(2)]
        for thread in threads:
            thread.start()
        time.sleep(0.001 * attempt)
        flag.set()
        for thread in threads:
            thread.join()
        assert results == [True, True]


def test_solves_in_parallel_do_not_mix():
    graph = Graph(terrain(100))
    expected = {v: graph.solver.solve(v).potential for v in (0, 5000)}
    results = {}

    def solve(vertex):
        results[vertex] = [graph.solver.solve(vertex).potential for _ in range(10)]

    threads = [threading.Thread(target=solve, args=(vertex,)) for vertex in expected]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for vertex, potentials in results.items():
        assert len(potentials) == 10
        assert all(same_bits(potential, expected[vertex]) for potential in potentials)


@pytest.mark.parametrize(
    "arguments, message",
    [
        (dict(source=25), "source vertex 25 does not exist: there are 25 vertices"),
        (dict(source=-1), "source vertex -1 does not exist"),
        (dict(source=[]), "there is no source"),
        (dict(source=3.5), "the source has to be a vertex, or pairs of a vertex and a distance"),
        (dict(source=[3]), "the source has to be a vertex, or pairs of a vertex and a distance"),
        (dict(source=[(1.5, 0)]), "the source has to be a vertex, or pairs"),
        (dict(source="vertex"), "the source has to be a vertex, or pairs"),
        (dict(source=[(0, 1e39)]), "distance of source 0 has to be finite and 0 or more"),
        (dict(source=[(0, -1.0)]), "distance of source 0 has to be finite and 0 or more"),
        (dict(source=[(0, float("nan"))]), "distance of source 0"),
        (dict(source=[(0, 0.0), (1, float("inf"))]), "distance of source 1"),
        (dict(source=0, vertex_costs=np.zeros(24)), r"vertex_costs has to have the shape \(25\)"),
        (dict(source=0, cost_limit=float("nan")), "the cost limit is not a number"),
        (dict(source=0, targets=[25]), "target vertex 25 does not exist"),
        (dict(source=0, targets=np.array([3, -1])), "target vertex -1 does not exist"),
        (dict(source=0, targets=np.ones(1)), "target vertices have to be a row of whole numbers"),
        (dict(source=0, max_distance=-1.0), "the maximum distance has to be 0 or more"),
        (dict(source=0, targets=[1], offset=-0.1), "the offset has to be 0 or more"),
        (dict(source=0, targets=[1], offset=float("nan")), "the offset has to be 0 or more"),
    ],
)
def test_bad_questions_are_refused(arguments, message):
    graph = Graph(terrain(5))
    with pytest.raises(ValueError, match=message):
        graph.solver.solve(**arguments)


def test_bad_lengths_are_refused():
    mesh = TestMesh("face", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32))
    for lengths, message in (
        ([1, 1], r"edge_lengths has to have the shape \(3,\), one for each edge, not \(2,\)"),
        ([1, -1, 1], "edge 1 has the length -1"),
        ([1, 1, float("nan")], "edge 2 has the length nan"),
    ):
        lengths = np.array(lengths, np.float32)
        with pytest.raises(ValueError, match=message):
            Graph(mesh, lengths)
        with pytest.raises(ValueError, match=message):
            Graph(mesh).solver.with_weights(lengths)
