"""Boxes, cylinders and balls, against marching along rays."""

import math

import numpy as np
import pytest

from mesh_map.base.errors import MeshMapError
from mesh_navigation.base.pose import Pose
from mesh_navigation.simulation.obstacles import (
    SHAPES,
    Obstacle,
    is_within,
    ray_distances,
    read_obstacles,
)


def random_obstacle(shape, random):
    pose = Pose(random.normal(size=3), random.normal(size=4))
    return Obstacle.checked(shape, pose, random.uniform(0.2, 2.0, 3))


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_enter_where_points_of_them_do(shape):
    random = np.random.default_rng(7)
    marks = np.linspace(0, 8, 4001)
    hits = 0
    for _ in range(150):
        obstacle = random_obstacle(shape, random)
        origin = obstacle.pose.position + random.normal(size=3) * random.choice([0.1, 2.0])
        direction = random.normal(size=3)
        direction /= np.linalg.norm(direction)
        inside = obstacle.contains(origin + marks[:, None] * direction)
        changes = np.flatnonzero(inside[1:] != inside[:-1])
        found = obstacle.ray_distances(origin, direction[None])[0]
        if len(changes):
            hits += 1
            assert marks[changes[0]] - 1e-9 <= found <= marks[changes[0] + 1] + 1e-9
        elif np.isfinite(found):
            # It only grazes the hull, between two marks.
            point = (origin + found * direction)[None]
            assert obstacle._replace(size=obstacle.size * (1 + 1e-6)).contains(point)[0]
            assert not obstacle.contains(point + 0.004 * direction)[0]
    assert hits > 50


@pytest.mark.parametrize(
    "shape, origin, direction, distance",
    [
        ("box", (-5, 0, 0), (1, 0, 0), 4.0),
        ("box", (-5, 1, 2), (1, 0, 0), 4.0),  # along two of its faces
        ("box", (-5, 1.001, 0), (1, 0, 0), math.inf),
        ("box", (5, 0, 0), (1, 0, 0), math.inf),  # behind
        ("box", (0, 0, 0), (0, 0, 1), 2.0),  # from within
        ("cylinder", (0, 0, 9), (0, 0, -1), 7.0),
        ("cylinder", (0.8, 0.8, 9), (0, 0, -1), math.inf),  # beside the circle
        ("cylinder", (0, -5, 1.9), (0, 1, 0), 4.0),
        ("cylinder", (0, -5, 2.1), (0, 1, 0), math.inf),
        ("cylinder", (0, 0, 0), (1, 0, 0), 1.0),
        ("sphere", (0, 0, 9), (0, 0, -1), 7.0),
        ("sphere", (-1e6, 0, 0), (1, 0, 0), 1e6 - 1),
        ("sphere", (-5, 1.001, 0), (1, 0, 0), math.inf),
    ],
)
def test_known_distances(shape, origin, direction, distance):
    obstacle = Obstacle.checked(shape, Pose.at((0, 0, 0)), (2, 2, 4))
    found = obstacle.ray_distances(np.array(origin, float), np.array([direction], float))
    assert found == pytest.approx([distance], abs=1e-6)


def test_the_first_of_many_counts():
    random = np.random.default_rng(3)
    many = [random_obstacle(shape, random) for shape in SHAPES * 4]
    directions = random.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    origin = np.array([-3.0, 0, 0])
    each = [obstacle.ray_distances(origin, directions) for obstacle in many]
    assert ray_distances(many, origin, directions).tolist() == np.min(each, axis=0).tolist()
    assert np.isinf(ray_distances([], origin, directions)).all()
    assert is_within(many, many[5].pose.position)
    assert not is_within(many, np.array([50.0, 0, 0]))


def test_parameters_make_obstacles():
    found, complaints = read_obstacles(
        [
            {"type": "cylinder", "position": [1, 2, 3], "size": [1, 1, 2]},
            {"position": [0, 0, 0], "size": [2, 4, 6], "yaw": math.pi / 2},
        ]
    )
    assert complaints == []
    assert [obstacle.shape for obstacle in found] == ["cylinder", "box"]
    assert found[0].pose.position.tolist() == [1, 2, 3]
    assert found[1].contains(np.array([[1.9, 0, 0], [0, 1.9, 0]])).tolist() == [True, False]


@pytest.mark.parametrize(
    "value, text",
    [
        ("box", "obstacles is no list but 'box'"),
        ([7], r"obstacles\[0\] is skipped: it is 7"),
        ([{"type": "cone"}], r"its position is None"),
        ([{"type": "cone", "position": [0, 0, 0], "size": [1, 1, 1]}], "an obstacle is a 'cone'"),
        ([{"type": ["box"], "position": [0, 0, 0], "size": [1, 1, 1]}], "an obstacle is a "),
        ([{"position": [0, 0], "size": [1, 1, 1]}], r"its position is \[0, 0\]"),
        ([{"position": [0, 0, "x"], "size": [1, 1, 1]}], "its position is "),
        ([{"position": [0, 0, 0], "size": [1, 0, 1]}], "the size of a box is .*above 0"),
        ([{"position": [0, 0, math.inf], "size": [1, 1, 1]}], "its position is .*inf"),
        ([{"position": [0, 0, 0], "size": [1, 1, 1], "yaw": "north"}], "its yaw is"),
    ],
)
def test_what_is_no_obstacle_is_skipped_with_a_reason(value, text):
    good = {"position": [0, 0, 0], "size": [1, 1, 1]}
    found, complaints = read_obstacles(value + [good] if isinstance(value, list) else value)
    assert len(found) == isinstance(value, list)
    assert len(complaints) == 1
    with pytest.raises(AssertionError, match=text):
        raise AssertionError(complaints[0])


def test_poses_are_checked():
    with pytest.raises(MeshMapError, match="the pose of a box: orientation .* is no rotation"):
        Obstacle.checked("box", Pose(np.zeros(3), np.zeros(4)), (1, 1, 1))
