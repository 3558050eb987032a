"""All planners keep the robot's radius from lethal ground."""

import numpy as np
import pytest

from mesh_msgs import zoo
from navigation_test_maps import ALL_PLANNERS, MapWithCosts

from mesh_navigation.base.outcomes import GetPathOutcome as Outcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape

GRID = zoo.grid(cells=80, size=8.0)
X, Y, _ = GRID.vertices.T
SQUARE = RobotShape([[0.4, 0.3], [-0.4, 0.3], [-0.4, -0.3], [0.4, -0.3]])
EACH_PLANNER = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)


def wall(gap):
    """(V,): a wall across x = 4 with a gap of this width (m) around y = 4."""
    return np.where((np.abs(X - 4.0) < 0.15) & (np.abs(Y - 4.0) > gap / 2 - 0.01), np.inf, 0.0)


def planned(cls, costs, start, goal, shape=RobotShape(radius=0.3), **options):
    mesh_map, planner = MapWithCosts(GRID, costs), cls()
    planner.body = Body(mesh_map.geometry, shape)
    assert planner.initialize("planner", mesh_map, {}) == []
    return planner.make_plan(Pose.at(start), Pose.at(goal), **options)


def least_distance(poses, costs):
    """m, of the path, on its pieces too, from a lethal vertex."""
    shares = np.linspace(0.0, 1.0, 21)[:, None, None]
    points = (poses[:-1, :3] + shares * np.diff(poses[:, :3], axis=0)).reshape(-1, 3)
    lethal = GRID.vertices[np.isposinf(costs)]
    return min(np.linalg.norm(lethal - point, axis=1).min() for point in points)


@EACH_PLANNER
@pytest.mark.parametrize("shape", [RobotShape(radius=0.3), SQUARE], ids=["round", "square"])
def test_a_corridor(cls, shape):
    narrow, wide = wall(0.4), wall(1.0)
    assert planned(cls, narrow, [2, 4, 0], [6, 4, 0], RobotShape()).succeeded
    found = planned(cls, narrow, [2, 4, 0], [6, 4, 0], shape)
    assert found.outcome == Outcome.NO_PATH_FOUND
    for goal in ([6, 4, 0], [6, 1, 0], [4.5, 3.0, 0]):
        found = planned(cls, wide, [2, 2, 0], goal, shape)
        assert found.succeeded, found.message
        assert least_distance(found.poses, wide) > 0.3 - 0.005


@EACH_PLANNER
def test_goals_too_near_to_a_wall(cls):
    costs = wall(1.0)
    for x, outcome in ((3.64, Outcome.INVALID_GOAL), (3.75, Outcome.INVALID_GOAL), (3.5, 0)):
        found = planned(cls, costs, [2, 2, 0], [x, 2.03, 0])
        assert found.outcome == outcome, found.message
        assert found.succeeded or "lethal or unknown ground" in found.message
    found = planned(cls, costs, [2, 2, 0], [3.75, 2.03, 0], tolerance=0.4)
    assert found.succeeded and least_distance(found.poses, costs) > 0.3 - 0.005


@EACH_PLANNER
def test_a_start_on_closed_ground_is_left_away_from_the_wall(cls):
    costs = wall(1.0)
    found = planned(cls, costs, [3.72, 2.0, 0], [2, 4, 0])
    assert found.succeeded and "it begins on closed ground" in found.message
    lethal = GRID.vertices[np.isposinf(costs)]
    depths = [np.linalg.norm(lethal - pose[:3], axis=1).min() for pose in found.poses]
    inside = int(np.argmax(np.array(depths) > 0.3 - 0.005))
    assert inside and (np.diff(depths[: inside + 1]) > 0.0).all()
    assert min(depths[inside:]) > 0.3 - 0.005
    on_it = planned(cls, costs, [4.0, 2.0, 0], [2, 4, 0])
    assert on_it.outcome == Outcome.INVALID_START and "lethal" in on_it.message
