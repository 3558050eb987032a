"""Paths of the Dijkstra planner against SciPy, and the shape of their poses."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from mesh_msgs import zoo
from mesh_msgs_hdf5.formats.importer import read_mesh
from navigation_test_maps import (
    BY_NAME,
    PASSABLE,
    MapWithCosts,
    data_file,
    planner_on,
    random_pairs,
)

from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.surface.up_normals import turned_up


def edges_of(faces):
    pairs = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64), axis=1)
    return np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)


def oracle(mesh, start, goal, blocked=()):
    """Length of the shortest way over edges between points on two faces."""
    count = len(mesh.vertices)
    points = np.concatenate([mesh.vertices.astype(np.float64), [start[1], goal[1]]])
    ends = [[count + i, v] for i, (face, _) in enumerate((start, goal)) for v in mesh.faces[face]]
    a, b = np.concatenate([edges_of(mesh.faces), ends]).T
    open_ = ~(np.isin(a, blocked) | np.isin(b, blocked))
    lengths = np.linalg.norm(points[a] - points[b], axis=1)
    # SciPy takes an explicit zero for no edge at all.
    values = np.maximum(lengths[open_], 1e-300)
    graph = coo_matrix((values, (a[open_], b[open_])), shape=(count + 2, count + 2))
    return dijkstra(graph.tocsr(), directed=False, indices=count)[count + 1]


def check_poses(mesh, poses, goal):
    """What holds for the poses of every path."""
    assert np.isfinite(poses).all() and len(poses) >= 2
    assert np.allclose(np.linalg.norm(poses[:, 3:], axis=1), 1.0)
    axes = np.array([[rotate(q, axis) for axis in np.eye(3)] for q in poses[:, 3:]])
    assert (axes[:, 2, 2] > -1e-9).all()
    wished = np.concatenate([np.diff(poses[:, :3], axis=0), [goal.heading]])
    along = wished - np.sum(wished * axes[:, 2], axis=1)[:, None] * axes[:, 2]
    lengths = np.linalg.norm(along, axis=1)
    usable = lengths > 1e-2 * np.linalg.norm(wished, axis=1)
    assert np.allclose(axes[usable, 0], (along / lengths[:, None])[usable], atol=1e-6)
    used = {tuple(edge) for edge in edges_of(mesh.faces)}
    vertices = [
        np.flatnonzero((mesh.vertices == np.float32(p)).all(axis=1)) for p in poses[1:-1, :3]
    ]
    for first, second in zip(vertices, vertices[1:]):
        assert any((min(a, b), max(a, b)) in used for a in first for b in second)


@pytest.mark.parametrize("mesh", PASSABLE, **BY_NAME)
def test_cost_is_that_of_scipy(mesh):
    planner = planner_on(MapWithCosts(mesh))
    for start, goal in random_pairs(mesh, 20):
        expected = oracle(mesh, start, goal)
        result = planner.make_plan(Pose.at(start[1]), Pose.at(goal[1], 1.0))
        if start[0] == goal[0]:
            expected = np.linalg.norm(goal[1] - start[1])
        if not np.isfinite(expected):
            assert result.outcome == GetPathOutcome.NO_PATH_FOUND
            continue
        assert result.outcome == GetPathOutcome.SUCCESS, result.message
        assert f"{result.cost:.2f} m" in result.message
        scale = np.abs(mesh.vertices).max()
        assert result.cost == pytest.approx(expected, rel=1e-4, abs=1e-5 * scale)
        assert np.allclose(result.poses[0, :3], start[1], atol=1e-6 * scale)
        assert np.allclose(result.poses[-1, :3], goal[1], atol=1e-6 * scale)
        steps = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1)
        assert result.cost == pytest.approx(steps.sum())
        check_poses(mesh, result.poses, Pose.at(goal[1], 1.0))


@pytest.mark.parametrize("seed", range(5))
def test_blocked_vertices_are_never_passed(seed):
    mesh = zoo.jittered_plane(cells=14)
    rng = np.random.default_rng(seed)
    costs = rng.uniform(0, 1, len(mesh.vertices)).astype(np.float32)
    kinds = rng.permutation(len(costs))[:90]
    costs[kinds[:30]], costs[kinds[30:60]], costs[kinds[60:]] = np.inf, np.nan, 1.5
    planner = planner_on(MapWithCosts(mesh, costs))
    outcomes = set()
    for start, goal in random_pairs(mesh, 40, seed):
        result = planner.make_plan(Pose.at(start[1]), Pose.at(goal[1]))
        outcomes.add(result.outcome)
        corners = mesh.faces[[start[0], goal[0]]].astype(int)
        if result.outcome in (GetPathOutcome.INVALID_START, GetPathOutcome.INVALID_GOAL):
            assert np.isin(corners, kinds).any()
            continue
        if start[0] == goal[0] and result.succeeded:
            continue
        if "closed ground" in result.message:
            continue  # where it is left, test_out_of_closed_ground.py looks at it
        expected = oracle(mesh, start, goal, kinds)
        assert result.succeeded == np.isfinite(expected)
        if result.succeeded:
            assert result.cost == pytest.approx(expected, rel=1e-5)
            passed = (mesh.vertices[kinds][:, None] == np.float32(result.poses[1:-1, :3])).all(
                axis=2
            )
            assert not passed.any()
            assert np.isinf(result.potential[kinds]).all()
    assert {GetPathOutcome.SUCCESS, 52, 53} <= outcomes


def test_a_line_of_single_lethal_vertices_is_a_wall():
    mesh = zoo.grid(cells=10, size=10.0)
    costs = np.where(mesh.vertices[:, 0] == 5.0, np.inf, 0.0)
    result = planner_on(MapWithCosts(mesh, costs)).make_plan(Pose.at([2, 5, 0]), Pose.at([8, 5, 0]))
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    gap = np.where(mesh.vertices[:, 1] == 9.0, 0.0, costs)
    result = planner_on(MapWithCosts(mesh, gap)).make_plan(Pose.at([2, 5, 0]), Pose.at([8, 5, 0]))
    assert result.succeeded
    assert [5.0, 9.0, 0.0] in result.poses[:, :3].tolist()


def test_start_and_goal_at_one_vertex_of_different_faces():
    around = Pose.at([3.2, 3.1, 0]), Pose.at([2.8, 2.9, 0])
    result = planner_on(MapWithCosts(zoo.grid())).make_plan(*around)
    assert result.poses[:, :3] == pytest.approx(np.array([[3.2, 3.1, 0], [3, 3, 0], [2.8, 2.9, 0]]))


def test_tray_agrees_with_the_known_length():
    """17.9293 m from vertex 1002 to vertex 1023, measured with another program."""
    mesh, _ = read_mesh(str(data_file("tray.ply")))
    poses = [Pose.at(mesh.vertices[vertex]) for vertex in (1002, 1023)]
    result = planner_on(MapWithCosts(mesh)).make_plan(*poses)
    assert result.outcome == GetPathOutcome.SUCCESS, result.message
    assert result.cost == pytest.approx(17.9293, abs=5e-5)
    check_poses(mesh, result.poses, poses[1])


def test_vector_field_points_down_the_potential():
    mesh = zoo.jittered_plane()
    planner = planner_on(MapWithCosts(mesh), publish_vector_field=True, goal_dist_offset=1e9)
    result = planner.make_plan(Pose.at([1, 1, 0]), Pose.at([8.2, 8.1, 0]))
    assert result.face_vectors is None
    reached = np.isfinite(result.potential)
    lengths = np.linalg.norm(result.vector_field, axis=1)
    seeds = lengths == 0
    assert reached.all() and seeds.sum() == 3
    assert np.allclose(lengths[~seeds], 1.0, atol=1e-6)
    nearer = np.linalg.norm(mesh.vertices + 0.01 * result.vector_field - [8.2, 8.1, 0], axis=1)
    farther = nearer >= np.linalg.norm(mesh.vertices - [8.2, 8.1, 0], axis=1) + 0.008
    assert not farther[~seeds].any()
    assert np.array_equal(turned_up(result.vector_field), turned_up(-result.vector_field))


def test_face_vectors_lie_in_the_faces_and_point_to_the_goal():
    mesh = zoo.sphere(3)
    planner = planner_on(MapWithCosts(mesh), publish_face_vectors=True, goal_dist_offset=1e9)
    goal = mesh.vertices[0].astype(np.float64)
    result = planner.make_plan(Pose.at(-goal), Pose.at(goal))
    assert result.vector_field is None
    vectors, (a, b, c) = result.face_vectors, mesh.vertices[mesh.faces].transpose(1, 0, 2)
    lengths = np.linalg.norm(vectors, axis=1)
    normals = np.cross(b - a, c - a)
    assert np.abs(np.sum(vectors * normals, axis=1)).max() < 1e-5 * np.abs(normals).max()
    assert np.allclose(lengths[lengths > 0], 1.0, atol=1e-6) and (lengths > 0).mean() > 0.99
    middles = (a + b + c) / 3
    nearer = np.linalg.norm(middles + 0.01 * vectors - goal, axis=1)
    away = np.linalg.norm(middles - goal, axis=1)
    far = (away > 0.3) & (away < 1.7)
    assert ((nearer < away) | ~far).mean() > 0.99
