"""The wave front from Python: exactness, goals, limits, costs, cancelling, memory."""

import gc
import threading
import types

import numpy as np
import pytest
from front_oracles import faces_edges
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from meshes import small, terrain
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull, Delaunay


def geometry_of(vertices, faces):
    return MeshGeometry(np.asarray(vertices, np.float32), np.asarray(faces, np.uint32))


def plane(kind, count=5000, seed=0):
    """(V, 3) and faces of a unit square with its four corners, or a strip of slivers."""
    random = np.random.default_rng(seed)
    side = int(np.sqrt(count))
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, side)] * 2), -1).reshape(-1, 2)
    if kind == "random":
        grid = np.concatenate([random.uniform(0, 1, (count, 2)), grid[[0, side - 1, -side, -1]]])
    inside = ((grid > 0) & (grid < 1)).all(1)
    if kind in ("jittered", "slivers"):
        grid[inside] += random.uniform(-0.35, 0.35, (inside.sum(), 2)) / side
    faces = Delaunay(grid).simplices
    if kind == "slivers":
        grid = grid * [1, 1e-3]
    return np.c_[grid, np.zeros(len(grid))], faces


def cylinder(seed=0):
    """Points on half a cylinder of radius 1, triangulated unrolled; also unrolled."""
    flat, faces = plane("jittered", seed=seed)
    flat = flat[:, :2] * [np.pi, 2]
    return np.c_[np.cos(flat[:, 0]), np.sin(flat[:, 0]), flat[:, 1]], faces, flat


def worst_error(field, exact, edge):
    far = exact > 10 * edge
    return np.abs(field.labels[far] / exact[far] - 1).max()


@pytest.mark.parametrize("kind", ["random", "jittered", "regular", "slivers"])
def test_is_exact_on_planes(kind):
    vertices, faces = plane(kind)
    geometry = geometry_of(vertices, faces)
    points = geometry.vertices.astype(np.float64)
    solver, edge = WaveFrontSolver.of(geometry), float(geometry.edge_lengths.mean())
    random = np.random.default_rng(1)
    for vertex in [int(np.argmin(np.abs(points - 0.5).sum(1))), int(np.argmin(points.sum(1)))]:
        exact = np.linalg.norm(points - points[vertex], axis=1)
        assert worst_error(solver.solve(vertex), exact, edge) < 1e-4
    corners = points[geometry.faces[random.integers(len(faces), size=4)]]
    weights = [(1, 0, 0), (0, 0.3, 0.7), (0.2, 0.2, 0.6), (0.98, 0.01, 0.01)]
    for position in np.einsum("nij,ni->nj", corners, np.array(weights)):
        goal = geometry.closest_face(position, 0.1)
        exact = np.linalg.norm(points - goal.position, axis=1)
        field = solver.solve(goal)
        assert worst_error(field, exact, edge) < 1e-4
        assert field.goal_face == goal.face and np.array_equal(field.goal_position, goal.position)


def test_is_near_the_exact_on_cylinders_and_converges_on_spheres():
    vertices, faces, flat = cylinder()
    geometry = geometry_of(vertices, faces)
    exact = np.linalg.norm(flat - flat[7], axis=1)
    field = WaveFrontSolver.of(geometry).solve(7)
    assert worst_error(field, exact, float(geometry.edge_lengths.mean())) < 0.002
    random, errors = np.random.default_rng(4), []
    for count in (1000, 4000, 16000):
        points = random.normal(size=(count, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        geometry = geometry_of(points, ConvexHull(points).simplices)
        exact = np.arccos(np.clip(points @ points[0], -1, 1))
        labels = WaveFrontSolver.of(geometry).solve(0).labels
        far = exact > 0.7
        errors.append(np.abs(labels[far] / exact[far] - 1).mean())
    assert errors[0] > 1.4 * errors[1] and errors[1] > 1.4 * errors[2] and errors[2] < 0.002


@small
def test_lies_between_straight_lines_and_edges(mesh):
    geometry = geometry_of(mesh.vertices, mesh.faces)
    points, edges = geometry.vertices.astype(np.float64), faces_edges(geometry.faces).astype(int)
    source = int(geometry.faces[0, 0])
    random = np.random.default_rng(0)
    for slowness in (None, random.uniform(1, 3, len(points)).astype(np.float32)):
        slow = np.ones(len(points)) if slowness is None else slowness.astype(np.float64)
        lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        weights = np.maximum(lengths * slow[edges].mean(1), 1e-30)
        graph = coo_matrix((weights, edges.T), (len(points),) * 2)
        over_edges = dijkstra(graph, directed=False, indices=source)
        found = WaveFrontSolver.of(geometry).solve(source, slowness=slowness).labels
        reached = np.isfinite(over_edges)
        scale = 1e-5 * (1 + np.abs(points).max())
        assert np.array_equal(np.isfinite(found), reached)
        assert (found[reached] <= over_edges[reached] * (1 + 1e-5) + scale).all()
        straight = np.linalg.norm(points - points[source], axis=1)
        assert (found[reached] >= 0.9 * straight[reached] - scale).all()
        ends = found[edges[reached[edges].all(1)]]
        steps = np.abs(ends[:, 0] - ends[:, 1])
        assert (steps <= weights[reached[edges].all(1)] + 2e-6 * ends.max(1) + scale).all()


def fine_weighted(vertices, faces, slowness, source, pieces=6):
    """(V,) times over straight lines across faces between points that divide their edges."""
    points, slow = [vertices.astype(np.float64)], [slowness.astype(np.float64)]
    parts, on_edge, count = np.arange(1, pieces)[:, None] / pieces, {}, len(vertices)
    for a, b in faces_edges(faces):
        points.append(points[0][a] * (1 - parts) + points[0][b] * parts)
        slow.append(slow[0][a] * (1 - parts[:, 0]) + slow[0][b] * parts[:, 0])
        on_edge[a, b] = np.arange(count, count + pieces - 1)
        count += pieces - 1
    points, slow, pairs = np.concatenate(points), np.concatenate(slow), []
    for face in np.sort(faces, 1):
        sides = [on_edge[face[i], face[j]] for i, j in ((0, 1), (0, 2), (1, 2))]
        everything = np.concatenate([face] + sides)
        pairs.append(everything[np.stack(np.triu_indices(len(everything), 1), 1)])
    pairs = np.unique(np.sort(np.concatenate(pairs), 1), axis=0).astype(int)
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    graph = coo_matrix((lengths * slow[pairs].mean(1), pairs.T), (count, count)).tocsr()
    return dijkstra(graph, directed=False, indices=source)[: len(vertices)]


# Without costs, labels on this coarse mesh are 0.96 to 1.02 of exact distances. Where costs jump
# up, a front seems rounder than it is, within a few edges behind.
@pytest.mark.parametrize(
    "kind, low, high", [("smooth", 0.93, 1.04), ("noise", 0.97, 1.08), ("jumps", 0.85, 1.12)]
)
def test_with_costs_agrees_with_a_fine_graph(kind, low, high):
    mesh = terrain(30)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    slowness = {
        "smooth": 2 + np.sin(3 * x) * np.cos(2 * y),
        "noise": np.random.default_rng(0).uniform(1, 2, len(x)),
        "jumps": np.where((np.abs(x - 1.4) < 0.4) & (np.abs(y - 1.8) < 0.8), 20, 1),
    }[kind].astype(np.float32)
    source = 35
    exact = fine_weighted(mesh.vertices, mesh.faces, slowness, source)
    geometry = geometry_of(mesh.vertices, mesh.faces)
    labels = WaveFrontSolver.of(geometry).solve(source, slowness=slowness).labels
    ratio = labels[exact > 0.5] / exact[exact > 0.5]
    assert low < ratio.min() and ratio.max() < high, (ratio.min(), ratio.max())
    assert abs(np.median(ratio) - 1) < 0.02


@pytest.fixture(scope="module")
def solver():
    mesh = terrain()
    return WaveFrontSolver.of(geometry_of(mesh.vertices, mesh.faces))


def test_one_solver_for_a_geometry():
    mesh = terrain(10)
    geometry = geometry_of(mesh.vertices, mesh.faces)
    solver = WaveFrontSolver.of(geometry)
    assert WaveFrontSolver.of(geometry) is solver
    assert WaveFrontSolver.of(geometry_of(mesh.vertices, mesh.faces)) is not solver
    del geometry
    gc.collect()
    assert np.isfinite(solver.solve(0).labels).all()


def test_goals_of_all_kinds(solver):
    one = solver.solve(5)
    assert one.labels[5] == 0 and one.limit == np.inf and one.labels.dtype == np.float64
    assert 5 in solver._faces[one.goal_face] and one.goal_position.shape == (3,)
    for goal in ([(5, 0.0)], np.array([[5, 0]])):
        field = solver.solve([(int(v), d) for v, d in goal])
        assert np.array_equal(field.labels, one.labels)
        assert field.goal_face is None and field.goal_position is None
    assert np.array_equal(one.potential, one.labels.astype(np.float32))
    assert one.potential is one.potential
    for array in (one.potential, one.labels):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert solver.solve([(5, 2.0), (5, 3.0)]).labels.min() == 2
    several = solver.solve([(5, 0.0), (900, 0.0)]).labels
    other = solver.solve(900).labels
    assert np.abs(several - np.minimum(one.labels, other)).max() < 0.05


def test_goals_in_closed_faces_start_only_where_they_lie(solver):
    class Goal:
        face = 100
        position = solver._vertices[solver._faces[100]].astype(np.float64).mean(0)

    slowness = np.full(1600, 2, np.float32)
    corners = solver._faces[100]
    points = solver._vertices[corners].astype(np.float64)
    labels = solver.solve(Goal, slowness=slowness).labels[corners]
    assert labels == pytest.approx(2 * np.linalg.norm(points - Goal.position, axis=1))
    slowness[corners[0]] = np.inf
    assert np.isinf(solver.solve(Goal, slowness=slowness).labels).all()
    Goal.position = points[1:].mean(0)  # on the edge that is open
    labels = solver.solve(Goal, slowness=slowness).labels
    assert np.isfinite(labels).sum() == 1599
    assert labels[corners[1:]] == pytest.approx(np.linalg.norm(points[1] - points[2]))
    slowness[corners] = np.nan
    assert np.isinf(solver.solve(Goal, slowness=slowness).labels).all()


def test_stops_at_targets_and_goes_on(solver):
    whole = solver.solve(820)
    field = solver.solve(820, targets=[830, 900], offset=0.1)
    wanted = whole.labels[[830, 900]].max() + 0.1
    assert wanted <= field.limit < wanted + 1
    assert field.reaches([830, 900, 0]).tolist() == [True, True, False]
    final = whole.labels <= field.limit
    assert np.array_equal(np.isfinite(field.potential), final)
    assert np.allclose(field.labels[final], whole.labels[final], rtol=2e-6)
    limit, before = field.limit, field.potential
    field.extend([830])
    assert field.limit == limit and field.potential is before
    field.extend([0])
    assert field.reaches([0]).all() and field.potential is not before
    field.extend()
    assert field.limit == np.inf and np.array_equal(field.labels, whole.labels)
    near = solver.solve(820, max_distance=0.5)
    assert near.limit == 0.5
    assert np.array_equal(near.potential, np.where(whole.labels <= 0.5, whole.potential, np.inf))


def test_updates(solver):
    random = np.random.default_rng(2)
    slowness = random.uniform(1, 2, 1600).astype(np.float32)
    field = solver.solve(solver_goal(solver, 400), slowness=slowness)
    for _ in range(8):
        changed = np.unique(random.integers(0, 1600, 4))
        slowness = slowness.copy()
        slowness[changed] = random.choice([1, 1.5, 3, np.inf, np.nan], len(changed))
        before = field.labels.copy()
        count = field.update(slowness, changed)
        fresh = solver.solve(solver_goal(solver, 400), slowness=slowness)
        reached = np.isfinite(fresh.labels)
        assert np.array_equal(np.isfinite(field.labels), reached) and field.limit == np.inf
        assert np.allclose(field.labels[reached], fresh.labels[reached], rtol=1e-5)
        assert np.array_equal(np.isfinite(field.potential), reached)
        assert count >= (before != field.labels).sum() and field.slowness is slowness
    assert field.update(slowness, []) == 0
    flag = CancelFlag()
    flag.set()
    changed = np.arange(0, 1600, 40)
    slowness = slowness.copy()
    slowness[changed] = 7
    with pytest.raises(Canceled):
        field.update(slowness, changed, cancel=flag)
    assert field.limit == -1 and np.isinf(field.potential).all()
    assert not field.reaches([400]).any()
    field.extend()
    fresh = solver.solve(solver_goal(solver, 400), slowness=slowness)
    assert np.allclose(field.labels, fresh.labels, rtol=1e-5)


def solver_goal(solver, face):
    class Goal:
        position = solver._vertices[solver._faces[face]].astype(np.float64).mean(0)

    Goal.face = face
    return Goal


def test_fields_keep_their_memory(solver):
    kept = solver.solve(3)
    labels, copy = kept.labels, kept.labels.copy()
    del kept
    gc.collect()
    for vertex in range(20):
        solver.solve(vertex + 100)
    assert np.array_equal(labels, copy)
    del labels
    assert np.array_equal(solver.solve(3).labels, copy)


def test_cancelling_and_threads():
    mesh = terrain(150)
    solver = WaveFrontSolver.of(geometry_of(mesh.vertices, mesh.faces))
    flag = CancelFlag()
    flag.set()
    with pytest.raises(Canceled):
        solver.solve(0, cancel=flag)
    field = solver.solve(0, max_distance=1.0)
    with pytest.raises(Canceled):
        field.extend(cancel=flag)
    assert field.limit == 1.0
    found = {}

    def work(source):
        flag = CancelFlag()
        timer = threading.Timer(0.002 * source, flag.set)
        timer.start()
        try:
            solver.solve(source, cancel=flag)
        except Canceled:
            pass
        timer.cancel()
        found[source] = solver.solve(source).labels

    threads = [threading.Thread(target=work, args=(source,)) for source in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for source in range(4):
        assert np.array_equal(found[source], solver.solve(source).labels)
    field.extend()
    assert np.array_equal(field.labels, found[0])


@pytest.mark.parametrize(
    "arguments, message",
    [
        (dict(goal=1600), "goal vertex 1600 does not exist: there are 1600 vertices"),
        (dict(goal=-1), "goal vertex -1 does not exist"),
        (dict(goal=[]), "there is no goal"),
        (dict(goal=[(1600, 0.0)]), "goal vertex 1600 does not exist"),
        (dict(goal=[(3, -1.0)]), "the distance of source 0 has to be finite and 0 or more"),
        (dict(goal=3, max_distance=-1.0), "the maximum distance has to be 0 or more"),
        (dict(goal=3, offset=-1.0), "the offset has to be finite and 0 or more"),
        (dict(goal=3, targets=[3, 1600]), "target vertex 1600 does not exist"),
        (dict(goal=3, targets=np.array([0.5])), "vertices have to be a row of whole numbers"),
        (dict(goal=3, slowness=[1.0]), "slowness has to have the shape"),
        (dict(goal=3, slowness=np.full(1600, -1.0)), "the slowness of vertex 0 is negative"),
        (dict(goal=3, cancel=True), "cancel has to be"),
    ],
)
def test_what_does_not_fit_is_refused(solver, arguments, message):
    with pytest.raises(ValueError, match=message):
        solver.solve(**arguments)


def test_points_that_do_not_fit_are_refused(solver):
    class Goal:
        face = 10**6
        position = (0, 0, 0)

    with pytest.raises(ValueError, match="goal face 1000000 does not exist: there are 3042 faces"):
        solver.solve(Goal)
    Goal.face, Goal.position = 0, (0, np.nan, 0)
    with pytest.raises(ValueError, match="the position of the goal has to be three finite numbers"):
        solver.solve(Goal)
    with pytest.raises(ValueError, match="changed vertex 1600 does not exist"):
        solver.solve(0).update(None, [1600])


@pytest.mark.parametrize("goal", [3.5, None, [3], "abc", [(1, "x")]])
def test_refuses_what_is_no_goal(solver, goal):
    with pytest.raises(ValueError, match="goal has to be a point with face and position"):
        solver.solve(goal)


@pytest.mark.parametrize("number", [1 << 80, -1])
def test_refuses_vertices_that_no_mesh_has(solver, number):
    with pytest.raises(ValueError, match="vertex %d does not exist" % number):
        solver.solve(number)
    with pytest.raises(ValueError, match="target vertex %d does not exist" % number):
        solver.solve(0, targets=[number])


def test_refuses_a_goal_off_its_face(solver):
    corners = solver._vertices[solver._faces[0]].astype(float)
    goal = types.SimpleNamespace(face=0, position=corners.mean(0) + [0.0, 0.0, 9.0])
    with pytest.raises(ValueError, match="m from its face 0"):
        solver.solve(goal)
