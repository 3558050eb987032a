"""Geometry of poses, against brute force."""

import numpy as np
import pytest

from mesh_navigation.base.path import STRAIGHT, path_length, path_poses, spaced_out, without_repeats
from mesh_navigation.base.pose import (
    Pose,
    multiply,
    quaternion_from_axes,
    quaternions_from_axes,
    rotate,
    transformed,
    vector_text,
)

UP = [0.0, 0.0, 1.0]


def axes_of(quaternions):
    """(N,3,3): rows are the x, y and z axes of the poses."""
    return np.array([[rotate(q, axis) for axis in np.eye(3)] for q in quaternions])


def random_quaternions(count):
    quaternions = np.random.default_rng(0).normal(size=(count, 4))
    return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)


def half_turns():
    """Rotations by 180 degrees, where naive formulas divide by zero, and none at all."""
    return np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0.6, 0, 0.8, 0]])


@pytest.mark.parametrize("quaternions", [random_quaternions(200), half_turns()])
def test_axes_to_quaternions_and_back(quaternions):
    axes = axes_of(quaternions)
    found = quaternions_from_axes(axes[:, 0], axes[:, 1], axes[:, 2])
    assert np.allclose(np.linalg.norm(found, axis=1), 1.0)
    assert np.allclose(np.abs(np.sum(found * quaternions, axis=1)), 1.0)
    alone = [quaternion_from_axes(*frame.tolist()) for frame in axes]
    assert np.array_equal(alone, found)


def test_product_turns_first_by_the_second():
    for first, second in zip(random_quaternions(20), random_quaternions(40)[20:]):
        vector = np.array([0.3, -2.0, 1.0])
        assert np.allclose(
            rotate(multiply(first, second), vector), rotate(first, rotate(second, vector))
        )


def test_transformed_pose():
    child = Pose.at([1.0, 0.0, 0.5], yaw=0.25)
    moved = transformed(child, Pose.at([10.0, 0.0, 0.0], np.pi / 2))
    expected = Pose.at([10.0, 1.0, 0.5], np.pi / 2 + 0.25)
    assert np.allclose(moved.position, expected.position)
    assert np.allclose(moved.orientation, expected.orientation)


@pytest.mark.parametrize(
    "position, orientation, word",
    [
        ([0, np.nan, 0], [0, 0, 0, 1], "position (0.00, nan, 0.00) is not finite"),
        ([0, 0, np.inf], [0, 0, 0, 1], "not finite"),
        ([0, 0, 0], [0, 0, np.nan, 1], "orientation (0.00, 0.00, nan, 1.00) is not finite"),
        ([0, 0, 0], [0, 0, 0, 0], "no rotation"),
        ([0, 0], [0, 0, 0, 1], "shapes (2,) and (4,), not (3,), (4,)"),
        ([0, 0, 0], [0, 0, 1], "shapes (3,) and (3,), not"),
        ([0, 0, 0], [0, 0, 1e200, 0], "no rotation"),
    ],
)
def test_faults_of_poses(position, orientation, word):
    assert word in Pose(np.array(position, float), np.array(orientation, float)).fault()


def test_numbers_of_any_size_in_messages():
    assert vector_text([1, -2.5, np.nan]) == "(1.00, -2.50, nan)"
    assert vector_text([1e300, -np.inf, 123456.789]) == "(1e+300, -inf, 123456.79)"


def test_pose_without_fault():
    assert Pose.at([1, 2, 3]).fault() is None
    assert Pose(np.zeros(3), np.array([0, 0, 0, 3.0])).fault() is None


def test_length_of_a_square():
    assert path_length(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]])) == 6.0


def test_repeated_points_go_but_the_ends_stay():
    points = np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0], [2, 0, 0.0]])
    normals = np.arange(18.0).reshape(6, 3)
    kept, kept_normals = without_repeats(points, normals)
    assert kept.tolist() == [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    assert kept_normals.tolist() == normals[[0, 2, 5]].tolist()


def test_two_equal_points_stay_two():
    points, _ = without_repeats(np.ones((2, 3)), np.ones((2, 3)))
    assert points.tolist() == [[1, 1, 1], [1, 1, 1]]


def test_x_looks_at_the_next_point_and_z_along_the_normal():
    rng = np.random.default_rng(1)
    points = np.cumsum(rng.normal(size=(50, 3)), axis=0)
    normals = rng.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    goal_heading = np.array([0.0, 1.0, 0.0])
    poses = path_poses(points, normals, goal_heading)
    assert np.array_equal(poses[:, :3], points)
    axes = axes_of(poses[:, 3:])
    assert np.allclose(axes[:, 2], normals)
    for index in range(50):
        wished = points[index + 1] - points[index] if index < 49 else goal_heading
        flat = wished - np.dot(wished, normals[index]) * normals[index]
        assert np.allclose(axes[index, 0], flat / np.linalg.norm(flat))


def test_steps_straight_up_take_over_the_heading_before():
    points = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [1, 1, 1.0]])
    poses = path_poses(points, np.array([UP] * 4), np.array(UP))
    headings = axes_of(poses[:, 3:])[:, 0]
    assert np.allclose(headings, [[0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 0, 0]])


def test_a_path_that_goes_nowhere_still_has_rotations():
    poses = path_poses(np.zeros((2, 3)), np.array([UP] * 2), np.array([0, 1.0, 0]))
    assert np.allclose(axes_of(poses[:, 3:])[:, 0], [[0, 1, 0], [0, 1, 0]])
    poses = path_poses(np.zeros((2, 3)), np.array([UP] * 2), np.array(UP))
    assert np.allclose(np.linalg.norm(poses[:, 3:], axis=1), 1.0)
    assert np.allclose(axes_of(poses[:, 3:])[:, 2], UP)


def distances_from_segments(points, begins, ends):
    """Of each point (...,3) from the segment of its row."""
    along, offsets = ends - begins, points - begins
    squared = np.sum(along * along, axis=-1)
    share = np.clip(np.sum(offsets * along, axis=-1) / np.where(squared > 0, squared, 1), 0, 1)
    return np.linalg.norm(offsets - share[..., None] * along, axis=-1)


def distances_from_polyline(points, polyline):
    """(N,) of points from the nearest segment, by brute force."""
    return distances_from_segments(points[:, None], polyline[:-1], polyline[1:]).min(axis=1)


def turns(count, noise=0.0):
    """A polyline on a wide spiral, each step a few centimeters."""
    t = np.linspace(0, 8, count)
    points = np.stack([t * np.cos(t), t * np.sin(t), 0.2 * t], axis=1)
    return points + np.random.default_rng(3).normal(0, noise, points.shape)


POLYLINES = {
    "straight": np.linspace([0, 0, 0], [7, 1, 2], 90),
    "two points": np.array([[0, 0, 0], [3.3, 0, 0.0]]),
    "coarse": np.array([[0, 0, 0], [5, 0, 0], [5, 3, 0], [5.1, 3, 0.0]]),
    "fine spiral": turns(1000),
    "coarse spiral": turns(200),
    "rough": turns(500, 0.01),
    "nearly smooth": turns(500, STRAIGHT),
    "with repeats": np.repeat(turns(100), 3, axis=0),
    "there and back": np.array([[0, 0, 0], [1, 0, 0], [0.2, 0, 0], [2, 0, 0.0]]),
    "no way at all": np.ones((2, 3)),
}


@pytest.mark.parametrize("step", [0.01, 0.1, 0.4, 1.0])
@pytest.mark.parametrize("name", POLYLINES)
def test_spaced_out(name, step):
    points = POLYLINES[name]
    spaced, segments = spaced_out(points, step)
    assert np.array_equal(spaced[[0, -1]], points[[0, -1]])
    assert np.linalg.norm(np.diff(spaced, axis=0), axis=1).max() <= step * (1 + 1e-9)
    assert distances_from_polyline(points, spaced).max() <= STRAIGHT * (1 + 1e-9)
    # Each point lies in the segment that is named with it.
    assert len(segments) == len(spaced) and np.all(np.diff(segments) >= 0)
    beside = distances_from_segments(spaced, points[segments], points[segments + 1])
    assert np.all(beside < 1e-12 * (1 + np.abs(spaced).max(axis=1)))


def test_spaced_out_leaves_out_what_is_straight():
    spaced, segments = spaced_out(POLYLINES["straight"], 0.4)
    assert 19 <= len(spaced) <= 25
    assert len(spaced_out(turns(4000), 0.4)[0]) < 1000
    corner = spaced_out(POLYLINES["coarse"], 1.0)[0]
    assert corner.tolist()[4:7] == [[4, 0, 0], [5, 0, 0], [5, 1, 0]]
    assert segments[-1] == len(POLYLINES["straight"]) - 2
