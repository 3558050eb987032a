"""The ground that a robot covers."""

import numpy as np
import pytest

from mesh_map.base.errors import MeshMapError
from mesh_navigation.body.robot_shape import RobotShape

SQUARE = [[0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5]]


def area(polygon):
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_a_point():
    assert RobotShape().footprint(0.0) is None
    assert area(RobotShape().footprint(0.5).polygon) == pytest.approx(np.pi * 0.25, rel=0.03)


def test_a_circle():
    shape = RobotShape(radius=0.3)
    for distance in (0.0, 0.2):
        polygon = shape.footprint(distance).polygon
        radii = np.linalg.norm(polygon, axis=1)
        assert (radii >= 0.3 + distance).all() and radii.max() < 1.04 * (0.3 + distance)


@pytest.mark.parametrize(
    "corners", [SQUARE, SQUARE[::-1], SQUARE + [[0, 0], [0.5, 0.0], SQUARE[0]]]
)
def test_a_polygon(corners):
    polygon = RobotShape(corners, radius=9.0).footprint(0.0).polygon
    assert sorted(polygon.tolist()) == sorted(SQUARE) and area(polygon) == 1.0


def test_a_polygon_with_a_distance():
    polygon = RobotShape(SQUARE).footprint(0.2).polygon
    assert area(polygon) == pytest.approx(1 + 4 * 0.2 + np.pi * 0.04, rel=0.005)
    assert np.abs(polygon).max() == pytest.approx(0.7, rel=0.01)
    # Nothing that is nearer than the distance is left out.
    angles = np.linspace(0, 2 * np.pi, 100)
    rim = [0.5, 0.5] + 0.2 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    sides = np.roll(polygon, -1, axis=0) - polygon
    gaps = rim[:, None] - polygon
    assert (sides[:, 0] * gaps[..., 1] - sides[:, 1] * gaps[..., 0] >= -1e-12).all()


@pytest.mark.parametrize(
    "corners, words",
    [
        ([[0, 0], [1, 0]], "the 2 corners have no area"),
        ([[0, 0], [1, 1], [2, 2]], "the 3 corners have no area"),
        ([[1, 1]], "the 1 corners have no area"),
        ([[0, 0], [1, float("nan")], [1, 1]], "are no corners"),
        ([1, 2, 3], "are no corners"),
        ([[1, 2, 3]] * 3, "are no corners"),
        ([["a", "b"]] * 3, "are no corners"),
        ([[1, 2], [3]], "are no corners"),
    ],
)
def test_what_is_no_polygon(corners, words):
    with pytest.raises(MeshMapError, match=words):
        RobotShape(corners)
    with pytest.raises(MeshMapError, match="^footprint"):
        RobotShape.of_parameters({"footprint": corners, "robot_radius": 0.4})


def test_parameters():
    for given in (SQUARE, str(SQUARE)):
        shape = RobotShape.of_parameters({"footprint": given, "other": 1})
        assert area(shape.footprint(0.0).polygon) == 1.0
    for given in ("", "[]", []):
        shape = RobotShape.of_parameters({"footprint": given, "robot_radius": 0.4})
        assert shape.is_round and shape.inscribed_radius == 0.4
    assert RobotShape.of_parameters({}).is_point


@pytest.mark.parametrize(
    "given, words",
    [
        ({"robot_radius": -0.1}, "robot_radius is -0.1, not from 0 to 100 m"),
        ({"robot_radius": "0.3"}, "it has to be a number"),
        ({"robot_radius": float("nan")}, "robot_radius is nan"),
        ({"robot_radius": True}, "it has to be a number"),
        ({"footprint": "[[1, 2]]"}, "the 1 corners have no area"),
        ({"footprint": "square"}, "footprint is 'square', no corners"),
        ({"footprint": "[[1, 2"}, "no corners"),
        ({"footprint": None}, "footprint is None"),
    ],
)
def test_no_robot_is_taken_for_smaller_than_it_is(given, words):
    with pytest.raises(MeshMapError, match=words):
        RobotShape.of_parameters(given)


def test_corners_that_are_no_list():
    for corners in (None, 5, True):
        with pytest.raises(MeshMapError, match="no corners"):
            RobotShape(corners)
