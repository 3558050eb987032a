"""Poses of all planners: headings, upright normals, and start and goal close together."""

import numpy as np
import pytest

from mesh_msgs import zoo
from navigation_test_maps import (
    ALL_PLANNERS,
    BY_NAME,
    PASSABLE,
    MapWithCosts,
    planner_on,
    random_pairs,
)

from mesh_navigation.base.pose import Pose, rotate

pytestmark = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)


@pytest.mark.parametrize("mesh", PASSABLE, **BY_NAME)
def test_winding_and_rolled_poses_make_no_difference(cls, mesh):
    down = mesh._replace(faces=mesh.faces[:, [0, 2, 1]])
    planners = [planner_on(MapWithCosts(which), cls) for which in (mesh, down)]
    upside_down = np.array([1.0, 0.0, 0.0, 0.0])
    for start, goal in random_pairs(mesh, 5, seed=1):
        ends = Pose.at(start[1], 0.3), Pose.at(goal[1], 2.0)
        rolled = [
            Pose(p.position, np.array([p.orientation[3], p.orientation[2], 0.0, 0.0])) for p in ends
        ]
        assert np.allclose([p.heading for p in rolled], [p.heading for p in ends])
        assert rotate(rolled[0].orientation, np.array([0, 0, 1.0]))[2] == pytest.approx(-1)
        results = [planner.make_plan(*pair) for planner in planners for pair in (ends, rolled)]
        for result in results[1:]:
            assert result.outcome == results[0].outcome
            assert np.allclose(result.poses, results[0].poses)
    assert rotate(upside_down, np.array([0, 0, 1.0]))[2] == -1


def test_goal_heading_is_kept_on_a_slope(cls):
    mesh = zoo.grid()
    slope = mesh._replace(vertices=(mesh.vertices * [1, 1, 0] + mesh.vertices[:, :1] * [0, 0, 0.5]))
    slope = slope._replace(vertices=slope.vertices.astype(np.float32))
    for yaw in np.linspace(-3, 3, 7):
        goal = Pose.at([7.3, 7.2, 3.65], yaw)
        planner = planner_on(MapWithCosts(slope), cls)
        poses = planner.make_plan(Pose.at([2.1, 2.6, 1.05]), goal).poses
        x, z = (rotate(poses[-1, 3:], axis) for axis in np.eye(3)[[0, 2]])
        normal = np.array([-0.5, 0, 1]) / np.hypot(1, 0.5)
        assert np.allclose(z, normal, atol=1e-6)
        flat = goal.heading - np.dot(goal.heading, normal) * normal
        assert np.allclose(x, flat / np.linalg.norm(flat), atol=1e-6)


def test_start_and_goal_within_a_face_give_a_straight_path(cls):
    result = planner_on(MapWithCosts(zoo.grid()), cls).make_plan(
        Pose.at([2.6, 2.1, 0]), Pose.at([2.81, 2.38, 0])
    )
    assert result.poses[:, :3] == pytest.approx(np.array([[2.6, 2.1, 0], [2.81, 2.38, 0]]))
    assert result.cost == pytest.approx(0.35)
    assert result.potential[np.argmin(np.abs(result.potential))] < 1.0


@pytest.mark.parametrize("point", [[3.0, 3.0, 0.0], [2.6, 2.1, 0.0]])
def test_start_at_the_goal_gives_two_poses(cls, point):
    result = planner_on(MapWithCosts(zoo.grid()), cls).make_plan(
        Pose.at(point, 1.0), Pose.at(point, 2.0)
    )
    assert result.succeeded and result.cost == 0.0
    assert result.poses[:, :3].tolist() == pytest.approx(np.array([point, point]))
    assert np.allclose(result.poses[-1, 3:], Pose.at(point, 2.0).orientation)
