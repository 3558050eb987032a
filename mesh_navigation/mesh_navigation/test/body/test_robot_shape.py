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
    shape, complaints = RobotShape.of_parameters({"footprint": corners, "robot_radius": 0.4})
    assert len(complaints) == 1 and words in complaints[0]
    assert complaints[0].endswith("robot_radius 0.4 m is used instead")
    assert shape.footprint(0.0).polygon.max() > 0.39


def test_parameters():
    shape, complaints = RobotShape.of_parameters({"footprint": SQUARE, "other": 1})
    assert not complaints and area(shape.footprint(0.0).polygon) == 1.0
    shape, complaints = RobotShape.of_parameters({"footprint": "[[1, 2]]", "robot_radius": -1})
    assert len(complaints) == 2 and shape.footprint(0.0) is None
