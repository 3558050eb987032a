"""Straight plans against lengths that are known, brute force, and the contract of planners."""

import math
import re

import numpy as np
import pytest
from maps_with_costs import MapWithCosts, lethal_where, lifted, random_place
from mesh_map.base.plugins import find_class
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.plan_execution import checked_result
from mesh_navigation.execution.planning import make_planner

from example_mesh_navigation import straight_planner
from example_mesh_navigation.straight_planner import StraightPlanner

TYPE = "example_mesh_navigation/StraightPlanner"
MESHES = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
meshes = pytest.mark.parametrize("mesh", MESHES, ids=[mesh.name for mesh in MESHES])
GRID = zoo.grid(cells=20)
WALL = lethal_where(GRID, lambda at: (at[:, 0] > 4.9) & (at[:, 0] < 5.1) & (at[:, 1] < 7.0))


def planned(mesh_map, start, goal, tolerance=0.0, cancellation=None, body=None, **parameters):
    planner = StraightPlanner()
    if body is not None:
        planner.body = body
    assert planner.initialize("straight", mesh_map, parameters) == []
    result = planner.make_plan(Pose.at(start), Pose.at(goal, 1.0), tolerance, cancellation)
    return checked_result(result)


def length_of(result):
    return float(np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum())


def check_straight(mesh_map, result, start, goal, step=0.4):
    """From start to goal, on the surface, straight as seen from above, in steps."""
    points = result.poses[:, :3]
    np.testing.assert_allclose(points[0], start, atol=1e-5)
    np.testing.assert_allclose(points[-1], goal, atol=0.011)
    scale = 1.0 + np.abs(goal).max()
    assert mesh_map.spatial_index.closest_batch(points=points).distances.max() <= 1e-6 * scale
    ahead = (np.subtract(goal, start))[:2]
    if np.linalg.norm(ahead) > 1e-3:
        ahead = ahead / np.linalg.norm(ahead)
        offsets = points[:, :2] - np.asarray(start)[:2]
        assert np.abs(offsets @ [-ahead[1], ahead[0]]).max() <= 1e-5 * scale
        assert (np.diff(offsets @ ahead) > -1e-6 * scale).all()
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() <= step + 1e-6
    assert result.cost == pytest.approx(length_of(result), abs=1e-3)


@pytest.mark.parametrize("rise", [0.0, 0.3, -0.6])
def test_on_a_slope_it_is_as_long_as_the_formula_says(rise):
    mesh = lifted(zoo.jittered_plane(cells=15), lambda x, y: rise * x)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    start, goal = [1.0, 2.0, rise], [8.0, 5.5, 8.0 * rise]
    result = planned(mesh_map, start, goal, step_width=1.0)
    assert result.outcome == GetPathOutcome.SUCCESS
    assert length_of(result) == pytest.approx(math.sqrt(49 + 12.25 + 49 * rise * rise), abs=1e-4)
    check_straight(mesh_map, result, start, goal, 1.0)
    normal = np.array([-rise, 0.0, 1.0]) / math.hypot(rise, 1.0)
    for pose in result.poses:
        np.testing.assert_allclose(rotate(pose[3:], [0, 0, 1]), normal, atol=1e-4)
    for pose, step in zip(result.poses[:-1], np.diff(result.poses[:, :3], axis=0)):
        ahead = step / np.linalg.norm(step)
        np.testing.assert_allclose(rotate(pose[3:], [1, 0, 0]), ahead, atol=1e-4)
    heading = rotate(result.poses[-1, 3:], [1, 0, 0])
    assert np.cross(heading, [math.cos(1.0), math.sin(1.0), 0]) @ [0, 0, 1] == pytest.approx(
        0.0, abs=0.2
    )


def test_from_storey_to_storey_up_the_ramp():
    mesh = zoo.two_storeys()  # landings of 2 m, between them 8 m that rise by 3 m
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    start, goal = [0.5, 13.0, 0.0], [11.5, 13.0, 3.0]
    result = planned(mesh_map, start, goal)
    assert length_of(result) == pytest.approx(1.5 + math.hypot(8.0, 3.0) + 1.5, abs=1e-3)
    check_straight(mesh_map, result, start, goal)


@pytest.mark.parametrize(
    "start, goal, said",
    [
        ([1, 1, 0], [1, 1, 3], "leads above or below it"),
        ([1, 1, 0], [9, 2, 3], "leads above or below it"),
        ([1, 13, 0], [1, 5, 3], "leads above or below it"),
        ([6, 13, 1.5], [6, 1, 3], r"ends at \(6.00, 12.00, 1.50\), where the surface ends"),
    ],
)
def test_the_edge_of_a_storey_is_not_left(start, goal, said):
    mesh = zoo.two_storeys()
    result = planned(MeshMap(mesh.vertices, mesh.faces), start, goal)
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    assert re.search(said, result.message), result.message
    assert result.lasting  # nobody has to try again


def test_the_border_of_a_hole():
    mesh = zoo.hole()
    result = planned(MeshMap(mesh.vertices, mesh.faces), [1, 4, 0], [8, 4, 0])
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    assert "ends at (3.00, 4.00, 0.00), where the surface ends" in result.message


@meshes
def test_plans_of_the_zoo(mesh):
    mesh_map, random = MeshMap(mesh.vertices, mesh.faces), np.random.default_rng(3)
    planner = make_planner(mesh_map, TYPE)
    found = 0
    for _ in range(20):
        start, goal = random_place(mesh, random), random_place(mesh, random)
        result = checked_result(planner.make_plan(Pose.at(start), Pose.at(goal)))
        assert result.outcome in (GetPathOutcome.SUCCESS, GetPathOutcome.NO_PATH_FOUND)
        if result.succeeded:
            found += 1
            check_straight(mesh_map, result, result.poses[0, :3], goal)
    if mesh.name in ("grid", "jittered_plane", "flipped_face", "duplicate_face"):
        assert found == 20
    if mesh.name == "two_components":
        assert 0 < found < 20


def test_only_open_faces_are_crossed():
    mesh, random = zoo.jittered_plane(cells=25), np.random.default_rng(8)
    costs = np.where(random.random(len(mesh.vertices)) < 0.05, np.inf, 0.0)
    costs[random.random(len(mesh.vertices)) < 0.02] = np.nan
    mesh_map = MapWithCosts(mesh, costs)
    is_open = np.isfinite(costs)[mesh.faces].all(axis=1)
    planner, ends = make_planner(mesh_map, TYPE), {}
    for _ in range(200):
        start, goal = random_place(mesh, random), random_place(mesh, random)
        result = planner.make_plan(Pose.at(start), Pose.at(goal), tolerance=100.0)
        ends[result.outcome] = ends.get(result.outcome, 0) + 1
        if not result.succeeded:
            continue
        points, ahead = result.poses[:, :3], (goal - start) / np.linalg.norm(goal - start)
        gone = np.linalg.norm(points[-1] - start)
        places = start + np.linspace(0.0, gone, 1000)[1:-1, None] * ahead
        faces = mesh_map.spatial_index.closest_batch(points=places).faces
        first = mesh_map.closest_face(start, 0.1).face
        assert is_open[faces[faces != first]].all()
        if "it ends" in result.message:
            beyond = mesh_map.closest_face(start + (gone + 1e-4) * ahead, 0.1).face
            assert not is_open[beyond] and gone < np.linalg.norm(goal - start)
            fails = planner.make_plan(Pose.at(start), Pose.at(goal))
            assert fails.outcome in (GetPathOutcome.NO_PATH_FOUND, GetPathOutcome.INVALID_GOAL)
        else:
            np.testing.assert_allclose(points[-1], goal, atol=1e-5)
    assert ends[GetPathOutcome.SUCCESS] > 100 and ends[GetPathOutcome.INVALID_START] > 5


@pytest.mark.parametrize(
    "start, goal, outcome, said",
    [
        ([5, 2, 0], [8, 2, 0], GetPathOutcome.INVALID_START, "start (5.00, 2.00, 0.00) is blocked"),
        ([2, 2, 0], [5, 2, 0], GetPathOutcome.INVALID_GOAL, "the ground there is lethal"),
        ([2, 2, 0], [8, 2, 0], GetPathOutcome.NO_PATH_FOUND, "is blocked after 2.50 m, at (4.50"),
        ([2, 2, 9], [8, 2, 0], GetPathOutcome.INVALID_START, "farther than 0.40 m from the map"),
        ([2, 2, 0], [8, 99, 0], GetPathOutcome.INVALID_GOAL, "farther than 0.40 m from the map"),
        ([2, 8, 0], [8, 8, 0], GetPathOutcome.SUCCESS, "straight path of 6.00 m"),
    ],
)
def test_outcomes(start, goal, outcome, said):
    result = planned(MapWithCosts(GRID, WALL), start, goal)
    assert (result.outcome, len(result.poses) > 1) == (outcome, outcome == 0)
    assert said in result.message and not result.lasting


def test_a_robot_beside_a_lethal_vertex_may_leave():
    costs = lethal_where(GRID, lambda at: (at[:, 0] == 5.0) & (at[:, 1] == 5.0))
    mesh_map = MapWithCosts(GRID, costs)
    start = [4.6, 4.9, 0.0]  # in a face of which that is a corner, but not the nearest one
    face = mesh_map.faces[mesh_map.closest_face(start, 0.1).face]
    assert np.isinf(costs[face]).any()
    assert planned(mesh_map, start, [2, 4.0, 0]).succeeded
    towards = planned(mesh_map, start, [8, 6.0, 0])
    assert towards.outcome == GetPathOutcome.NO_PATH_FOUND
    assert "is blocked after 0.00 m" in towards.message


@pytest.mark.parametrize(
    "cost, limit, passes", [(0.9, 1.0, True), (1.1, 1.0, False), (1.1, 2, True)]
)
def test_the_cost_limit(cost, limit, passes):
    mesh_map = MapWithCosts(GRID, np.where(np.isinf(WALL), cost, 0.0))
    result = planned(mesh_map, [2, 2, 0], [8, 2, 0], cost_limit=limit)
    assert result.succeeded == passes
    assert passes or "of cost 1.1, over the cost limit 1" in result.message


def test_the_tolerance():
    mesh_map = MapWithCosts(GRID, WALL)
    near = planned(mesh_map, [2, 2, 0], [5.2, 2, 0], tolerance=0.71)
    assert near.succeeded and "it ends 0.70 m before it: goal" in near.message
    np.testing.assert_allclose(near.poses[-1, :3], [4.5, 2, 0], atol=1e-6)
    assert planned(mesh_map, [2, 2, 0], [5.2, 2, 0], tolerance=0.69).outcome == 53
    assert planned(mesh_map, [2, 2, 0], [5.7, 2, 0], tolerance=1.21).succeeded
    assert planned(mesh_map, [2, 2, 0], [5.7, 2, 0], tolerance=1.19).outcome == 54


def test_layers_are_named():
    mesh = lifted(GRID, lambda x, y: np.where(x > 5.2, 3.0, 0.0))
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers([{"name": "cliff", "type": "mesh_layers/SteepnessLayer"}])
    result = planned(mesh_map, [2, 2, 0], [8, 2, 3])
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    assert "the ground there is lethal in layer cliff" in result.message


def test_the_body_keeps_its_radius():
    mesh_map = MapWithCosts(GRID, WALL)
    lethal = GRID.vertices[np.isinf(WALL)]
    results = {}
    for y in (6.9, 7.2, 7.9):
        body = Body(mesh_map.geometry, RobotShape(radius=0.8))
        result = planned(mesh_map, [2, y, 0], [8, y, 0], body=body, step_width=0.05)
        results[y] = result
        if result.succeeded:
            gaps = np.linalg.norm(result.poses[:, None, :3] - lethal, axis=2)
            assert gaps.min() >= 0.8
    assert [results[y].succeeded for y in results] == [False, False, True]
    assert "nearer than the robot's radius" in results[7.2].message
    assert planned(mesh_map, [2, 7.2, 0], [8, 7.2, 0]).succeeded  # as a point


def test_start_and_goal_at_one_place():
    result = planned(MapWithCosts(GRID), [2, 2, 0], [2, 2, 0])
    assert result.succeeded and len(result.poses) == 2 and length_of(result) == 0.0


class CanceledLater(Cancellation):
    """Is canceled when somebody has looked so often."""

    def __init__(self, looks):
        super().__init__()
        self.left = looks

    @property
    def canceled(self):
        self.left -= 1
        if self.left < 0:
            self.cancel("enough")
        return super().canceled


def test_a_cancel_ends_a_long_walk(monkeypatch):
    mesh_map = MapWithCosts(GRID)
    at_once = planned(mesh_map, [1, 1, 0], [9, 6, 0])
    monkeypatch.setattr(straight_planner, "_AT_ONCE", 5)
    in_pieces = planned(mesh_map, [1, 1, 0], [9, 6, 0])
    np.testing.assert_allclose(in_pieces.poses, at_once.poses, atol=1e-6)
    for looks in (0, 1, 4):
        cancellation = CanceledLater(looks)
        result = planned(mesh_map, [1, 1, 0], [9, 6, 0], cancellation=cancellation)
        assert result.outcome == GetPathOutcome.CANCELED and "enough" in result.message
        assert cancellation.left == -1


def test_parameters():
    planner = make_planner(MapWithCosts(GRID), TYPE)
    coarse = len(planner.make_plan(Pose.at([1, 1, 0]), Pose.at([9, 1, 0])).poses)
    assert planner.set_parameters({"step_width": 0.05}) == []
    assert len(planner.make_plan(Pose.at([1, 1, 0]), Pose.at([9, 1, 0])).poses) > 2 * coarse
    (complaint,) = planner.set_parameters({"step_width": 0.0})
    assert "step_width" in complaint and planner.values["step_width"] == 0.01


def test_it_is_found_as_a_plugin():
    assert find_class("mesh_navigation", "mesh_navigation::MeshPlanner", TYPE) is StraightPlanner
