"""Paths of the planners that cross faces: on the surface, short, and around what is blocked."""

import numpy as np
import pytest

from mesh_msgs import zoo
from mesh_msgs_hdf5.formats.importer import read_mesh
from navigation_test_maps import (
    BY_NAME,
    FRONT_PLANNERS,
    PASSABLE,
    MapWithCosts,
    data_file,
    distances_from_surface,
    planner_on,
    random_pairs,
)

from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.planners.mmp import MMPPlanner
from mesh_navigation.planners.wave_front import CVPMeshPlanner, WaveFrontPlanner

EACH_PLANNER = pytest.mark.parametrize("cls", FRONT_PLANNERS, ids=lambda cls: cls.__name__)


def length_of(result):
    return np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum()


def exactness(cls):
    """Behind corners a front on a coarse mesh comes a little late; what is pulled taut does not."""
    return 1e-5 if cls is MMPPlanner else 0.02


def check_poses(mesh_map, result, start, goal, step=0.4):
    """What holds for the poses of every path."""
    poses, scale = result.poses, 1 + np.abs(mesh_map.vertices).max()
    assert np.isfinite(poses).all() and len(poses) >= 2
    assert np.allclose(poses[[0, -1], :3], [start, goal.position], atol=1e-6 * scale)
    assert np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).max() <= step * (1 + 1e-9)
    assert distances_from_surface(mesh_map, poses[:, :3], 0.05).max() < 1e-3
    axes = np.array([[rotate(q, axis) for axis in np.eye(3)] for q in poses[:, 3:]])
    assert (axes[:, 2, 2] > -1e-9).all()
    wished = np.concatenate([np.diff(poses[:, :3], axis=0), [goal.heading]])
    along = wished - np.sum(wished * axes[:, 2], axis=1)[:, None] * axes[:, 2]
    usable = np.linalg.norm(along, axis=1) > 1e-2 * np.linalg.norm(wished, axis=1)
    usable &= np.linalg.norm(wished, axis=1) > 1e-6
    units = along[usable] / np.linalg.norm(along[usable], axis=1, keepdims=True)
    assert np.allclose(axes[usable, 0], units, atol=1e-5)


@EACH_PLANNER
@pytest.mark.parametrize("mesh", PASSABLE, **BY_NAME)
def test_not_longer_than_along_edges(cls, mesh):
    mesh_map = MapWithCosts(mesh)
    planner, edges = planner_on(mesh_map, cls, step_width=1.0), planner_on(mesh_map)
    scale = np.abs(mesh.vertices).max()
    for start, goal in random_pairs(mesh, 10):
        ends = Pose.at(start[1]), Pose.at(goal[1], 1.0)
        result, along_edges = planner.make_plan(*ends), edges.make_plan(*ends)
        assert result.outcome == along_edges.outcome, result.message
        if result.succeeded:
            assert f"path of {length_of(result):.2f} m" in result.message
            check_poses(mesh_map, result, start[1], ends[1], 1.0)
            slack = 1e-5 * scale + 1e-3 * len(result.poses)
            assert length_of(result) <= along_edges.cost * (1 + 1e-6) + slack
            assert result.cost <= along_edges.cost * (1 + 1e-5) + 1e-5 * scale
            straight = np.linalg.norm(start[1] - goal[1])
            assert result.cost >= straight * (1 - 1e-5) - 1e-5 * scale


@EACH_PLANNER
@pytest.mark.parametrize("step", [0.01, 0.4, 1.0])
def test_on_a_plane_the_path_is_straight(cls, step):
    mesh_map = MapWithCosts(zoo.jittered_plane(cells=20))
    planner = planner_on(mesh_map, cls, step_width=step)
    for start, goal in random_pairs(mesh_map._map, 10):
        result = planner.make_plan(Pose.at(start[1]), Pose.at(goal[1]))
        straight = np.linalg.norm(goal[1] - start[1])
        assert length_of(result) == pytest.approx(straight, rel=1e-5)
        assert result.cost == pytest.approx(straight, rel=1e-5)
        assert np.ceil(straight / step) < len(result.poses) <= 2.5 * straight / step + 2
        check_poses(mesh_map, result, start[1], Pose.at(goal[1]), step)


@EACH_PLANNER
def test_tray_agrees_with_the_known_length(cls):
    """16.9702 m from vertex 1002 to vertex 1023: the exact geodesic, of another program."""
    mesh, _ = read_mesh(str(data_file("tray.ply")))
    poses = [Pose.at(mesh.vertices[vertex]) for vertex in (1002, 1023)]
    result = planner_on(MapWithCosts(mesh), cls).make_plan(*poses)
    assert result.outcome == GetPathOutcome.SUCCESS, result.message
    assert length_of(result) == pytest.approx(16.9702, abs=2e-3)
    assert result.cost == pytest.approx(16.9702, rel=1e-4)


@EACH_PLANNER
def test_a_line_of_single_lethal_vertices_is_a_wall(cls):
    mesh = zoo.grid(cells=10, size=10.0)
    start, goal = Pose.at([2, 5, 0]), Pose.at([8, 5, 0])
    wall = np.where(mesh.vertices[:, 0] == 5.0, np.inf, 0.0)
    result = planner_on(MapWithCosts(mesh, wall), cls).make_plan(start, goal)
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    gap = np.where(mesh.vertices[:, 1] == 9.0, 0.0, wall)
    result = planner_on(MapWithCosts(mesh, gap), cls).make_plan(start, goal)
    assert result.succeeded
    # Along the only two edges to the one vertex of the gap, (4, 8) to (5, 9) to (6, 9).
    assert [5.0, 9.0, 0.0] in result.poses[:, :3].round(9).tolist()
    shortest = np.hypot(2, 3) + np.sqrt(2) + 1 + np.hypot(2, 4)
    assert length_of(result) == pytest.approx(shortest, rel=exactness(cls))


def faces_crossed(mesh_map, result):
    """Faces that hold the middles of the path's segments, away from its ends."""
    middles = (result.poses[1:-2, :3] + result.poses[2:-1, :3]) / 2
    return mesh_map.spatial_index.closest_batch(points=middles)


@EACH_PLANNER
@pytest.mark.parametrize("seed", range(4))
def test_faces_with_a_blocked_corner_are_not_crossed(cls, seed):
    mesh = zoo.jittered_plane(cells=20)
    rng = np.random.default_rng(seed)
    costs = rng.uniform(0, 1, len(mesh.vertices)).astype(np.float32)
    odd = rng.permutation(len(costs))[:60]
    costs[odd] = np.resize(np.float32([np.inf, np.nan, 1.5]), 60)
    mesh_map = MapWithCosts(mesh, costs)
    planner, edges = planner_on(mesh_map, cls, step_width=0.05), planner_on(mesh_map)
    outcomes = []
    for start, goal in random_pairs(mesh, 25, seed):
        ends = Pose.at(start[1]), Pose.at(goal[1])
        result = planner.make_plan(*ends)
        assert result.outcome == edges.make_plan(*ends).outcome
        outcomes.append(int(result.outcome))
        if not result.succeeded:
            continue
        check_poses(mesh_map, result, start[1], ends[1], 0.05)
        assert np.isinf(result.potential[odd]).all()
        found = faces_crossed(mesh_map, result)
        inside = found.barycentric.min(axis=1) > 1e-3
        ends_in = np.isin(found.faces, [start[0], goal[0]])
        crossed = mesh.faces[found.faces[inside & ~ends_in]]
        assert not np.isin(crossed, odd).any()
    assert 0 in outcomes and len(set(outcomes)) > 1


GRID = zoo.grid(cells=50)
OVER, BESIDE = [2, 5, 0], [8, 5, 0]


def hill(height):
    """Costs that are high in the middle between OVER and BESIDE."""
    return height * np.exp(-((GRID.vertices[:, :2] - 5) ** 2).sum(axis=1))


@pytest.mark.parametrize(
    "cls, factor, around",
    [
        (WaveFrontPlanner, None, True),
        (WaveFrontPlanner, 0.0, False),
        (WaveFrontPlanner, 50.0, True),
        (CVPMeshPlanner, None, False),
        (CVPMeshPlanner, 50.0, True),
        (MMPPlanner, None, False),
    ],
)
def test_costs_are_gone_around_as_far_as_they_count(cls, factor, around):
    given = {} if factor is None else {"cost_factor": factor}
    planner = planner_on(MapWithCosts(GRID, hill(0.9)), cls, **given)
    result = planner.make_plan(Pose.at(OVER), Pose.at(BESIDE))
    assert result.succeeded
    aside = np.abs(result.poses[:, 1] - 5).max()
    if not around:
        assert aside < 1e-6 and result.cost == pytest.approx(6.0)
        return
    assert aside > 0.3
    # Nothing is as cheap: not the straight way, and no arc on the same side.
    used = planner.values["cost_factor"]

    def time_of(points):
        middles = (points[1:] + points[:-1]) / 2
        slow = 1 + used * 0.9 * np.exp(-((middles[:, :2] - 5) ** 2).sum(axis=1))
        return np.sum(slow * np.linalg.norm(np.diff(points, axis=0), axis=1))

    x = np.linspace(2, 8, 2001)
    for bulge in np.linspace(0, 3, 31):
        arc = np.stack([x, 5 + bulge * np.sin(np.pi * (x - 2) / 6), 0 * x], axis=1)
        assert result.cost < 1.02 * time_of(arc)
    assert time_of(result.poses[:, :3]) == pytest.approx(result.cost, rel=0.05)
    assert f"cost {result.cost:.2f}" in result.message


@EACH_PLANNER
def test_from_storey_to_storey_over_the_ramp(cls):
    mesh_map = MapWithCosts(zoo.two_storeys())
    result = planner_on(mesh_map, cls).make_plan(Pose.at([6, 6, 0.1]), Pose.at([6, 6, 3.1]))
    assert result.succeeded
    check_poses(mesh_map, result, [6, 6, 0], Pose.at([6, 6, 3]))
    assert result.poses[:, 1].max() >= 12 and length_of(result) > 20


@EACH_PLANNER
def test_around_a_hole(cls):
    mesh_map = MapWithCosts(zoo.hole())
    result = planner_on(mesh_map, cls).make_plan(Pose.at([2, 4.4, 0]), Pose.at([7, 4.4, 0]))
    check_poses(mesh_map, result, [2, 4.4, 0], Pose.at([7, 4.4, 0]))
    # Past the two lower corners of the hole, which is from 3 to 6.
    assert length_of(result) == pytest.approx(3 + 2 * np.hypot(1, 1.4), rel=exactness(cls))


@pytest.fixture(scope="module")
def world():
    return zoo.outdoor_world(faces=20_000)


@EACH_PLANNER
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_on_rough_ground_every_goal_is_reached(cls, noise, world):
    rng = np.random.default_rng(5)
    vertices = world.vertices + np.float32([0, 0, noise]) * rng.normal(
        size=(len(world.vertices), 1)
    )
    mesh_map = MapWithCosts(world._replace(vertices=vertices.astype(np.float32)))
    planner, labels = planner_on(mesh_map, cls), mesh_map.topology.components
    usable = np.flatnonzero(labels == np.bincount(labels).argmax())
    for goal in mesh_map.vertices[rng.choice(usable, 3)]:
        for start in mesh_map.vertices[rng.choice(usable, 6)]:
            result = planner.make_plan(Pose.at(start), Pose.at(goal))
            assert result.succeeded, result.message
            check_poses(mesh_map, result, start, Pose.at(goal))
            assert length_of(result) <= 1.05 * result.cost + 0.01


@EACH_PLANNER
def test_vector_fields_point_down_the_potential(cls):
    mesh = zoo.jittered_plane()
    asked = {"publish_vector_field": True, "publish_face_vectors": True, "goal_dist_offset": 1e9}
    goal = np.array([8.2, 8.1, 0])
    planner = planner_on(MapWithCosts(mesh), cls, **asked)
    result = planner.make_plan(Pose.at([1, 1, 0]), Pose.at(goal))
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    for vectors, points in ((result.vector_field, mesh.vertices), (result.face_vectors, middles)):
        to_goal = goal - points
        distances = np.linalg.norm(to_goal, axis=1, keepdims=True)
        assert vectors.dtype == np.float32 and vectors.shape == points.shape
        far = distances[:, 0] > 1.5
        assert np.sum(vectors * to_goal / distances, axis=1)[far].min() > 0.95
    assert planner_on(MapWithCosts(mesh), cls).make_plan(*[Pose.at(goal)] * 2).face_vectors is None
