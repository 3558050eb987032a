"""No plan leads through what stands on the floor as a surface of its own, on maps with a
CollisionLayer; what is in the way is known here from how it was made alone."""

from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world import solids
from mesh_msgs.world.solids import box, floor, joined, sheet
from navigation_test_maps import ALL_PLANNERS

from mesh_navigation.base.outcomes import GetPathOutcome as Outcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape

EDGE, STEP, HEIGHT = 0.1, 0.15, 1.0
FLOOR = floor((0, 0), (8, 6), EDGE)
START, GOAL = [2.0, 2.0, 0.0], [6.0, 2.2, 0.0]
EACH_PLANNER = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)


def wall(bottom=0.0, far=4.5, tilt=0.0, inner=None):
    """A box across the direct way, from y = -0.5 to `far`; and samples of it, (N, 3)."""
    lower, upper = np.array([3.93, -0.5, bottom]), np.array([4.26, far, 1.8])
    spots = [np.arange(a, b, 0.04) for a, b in zip(lower, upper)]
    parts = [box(lower, upper), (np.stack(np.meshgrid(*spots), -1).reshape(-1, 3), FLOOR[1][:0])]
    thing, samples = (solids.turned(part, tilt, 1, (4.1, 0, 0.5)) for part in parts)
    return thing, samples[0]


def thin(far=4.5):
    spots = np.stack(np.meshgrid([4.03], np.arange(-0.5, far, 0.01), [0.2, 0.9]), -1)
    return sheet((4.03, -0.5), (4.03, far), 0.0, 1.8), spots.reshape(-1, 3)


def hollow(far=4.5):
    """Of an outer and an inner surface, both open to nowhere."""
    thing, samples = wall(far=far)
    inner = solids.flipped(box((4.0, -0.4, 0.02), (4.2, far - 0.1, 1.7)))
    return joined(thing, inner), samples


def table(far=4.5):
    """Too low for the robot: a top on two walls along it."""
    sides = [box((3.6, -0.5, 0), (3.7, far, 0.7)), box((4.5, -0.5, 0), (4.6, far, 0.7))]
    spots = np.meshgrid(np.arange(3.6, 4.6, 0.04), np.arange(-0.5, far, 0.04), [0.72])
    thing = joined(box((3.6, -0.5, 0.7), (4.6, far, 0.74)), *sides)
    return thing, np.stack(spots, -1).reshape(-1, 3)


THINGS = {
    "standing": wall,
    "sunk": lambda **where: wall(bottom=-0.05, **where),
    "floating": lambda **where: wall(bottom=0.03, **where),
    "tilted": lambda **where: wall(bottom=-0.3, tilt=0.35, **where),
    "sheet": thin,
    "hollow": hollow,
    "table": table,
}
each_thing = pytest.mark.parametrize("name", THINGS)


@lru_cache(maxsize=None)
def map_with(name, far, layer_radius):
    """A floor with a thing on it, for all planners; and samples of the thing."""
    thing, samples = THINGS[name](far=far)
    return collision_map(thing, layer_radius), samples


def collision_map(thing, layer_radius):
    mesh_map = MeshMap(*joined(FLOOR, thing))
    mesh_map.compute_layers(
        [
            {
                "name": "collision",
                "type": "mesh_layers/CollisionLayer",
                "params": {
                    "robot_radius": layer_radius,
                    "step_height": STEP,
                    "robot_height": HEIGHT,
                },
            }
        ]
    )
    assert not mesh_map.fault
    return mesh_map


def planned(cls, mesh_map, shape):
    planner = cls()
    planner.body = Body(mesh_map.geometry, shape)
    assert planner.initialize("planner", mesh_map, {}) == []
    return planner.make_plan(Pose.at(START), Pose.at(GOAL))


def least_distance(found, samples):
    """m in plan from the path, on its pieces too, to what of the thing the body may meet."""
    ends = found.poses[:, :2]
    shares = np.linspace(0, 1, 40)[:, None, None]
    points = (ends[:-1] + shares * np.diff(ends, axis=0)).reshape(-1, 2)
    spots = samples[(samples[:, 2] > STEP) & (samples[:, 2] < HEIGHT), :2]
    return cKDTree(spots).query(points)[0].min()


@EACH_PLANNER
@each_thing
def test_the_way_leads_around(cls, name):
    """With no radius, the path stays out of it (samples are 4 cm apart); with one it stays away by
    that, whoever keeps it, less what a vertex stands for."""
    for layer_radius, shape in (
        (0.0, RobotShape()),
        (0.0, RobotShape(radius=0.25)),
        (0.25, RobotShape()),
    ):
        mesh_map, samples = map_with(name, 4.5, layer_radius)
        found = planned(cls, mesh_map, shape)
        assert found.succeeded, found.message
        assert np.abs(found.poses[:, 2]).max() < 1e-6
        assert found.poses[:, 1].max() > 4.4  # by the end of the wall
        radius = max(layer_radius, shape.inscribed_radius)
        assert least_distance(found, samples) > max(radius - EDGE / 2 - 0.03, 0.03)


@EACH_PLANNER
@each_thing
def test_nothing_leads_through(cls, name):
    """Where it parts the floor, there is no way."""
    found = planned(cls, map_with(name, 6.5, 0.0)[0], RobotShape())
    assert found.outcome == Outcome.NO_PATH_FOUND, found.message


@EACH_PLANNER
def test_under_and_over_a_bridge(cls):
    """Two meters below a closed deck are room enough, and a table that is higher than the robot."""
    deck = box((3.5, -0.5, 2.0), (4.5, 6.5, 2.3))
    high = joined(box((3.5, 1, 1.1), (4.5, 3, 1.15)), box((3.5, 1, 0), (3.6, 1.1, 1.1)))
    for thing in (deck, high):
        found = planned(cls, collision_map(thing, 0.0), RobotShape(radius=0.25))
        assert found.succeeded, found.message
        assert found.cost < 1.03 * np.linalg.norm(np.subtract(GOAL, START))
