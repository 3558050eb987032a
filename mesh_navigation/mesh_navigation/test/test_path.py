"""Geometry of poses, against brute force."""

import numpy as np
import pytest

from mesh_navigation.path import path_length, path_poses, without_repeats
from mesh_navigation.pose import Pose, multiply, quaternions_from_axes, rotate, transformed

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


def test_product_turns_first_by_the_second():
    for first, second in zip(random_quaternions(20), random_quaternions(40)[20:]):
        vector = np.array([0.3, -2.0, 1.0])
        assert np.allclose(
            rotate(multiply(first, second), vector), rotate(first, rotate(second, vector))
        )


def test_transformed_pose():
    child = Pose.at([1.0, 0.0, 0.5], yaw=0.25)
    moved = transformed(
        child, np.array([10.0, 0.0, 0.0]), Pose.at([0, 0, 0], np.pi / 2).orientation
    )
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
        ([0, 0, 0], [0, 0, 1e200, 0], "no rotation"),
    ],
)
def test_faults_of_poses(position, orientation, word):
    assert word in Pose(np.array(position, float), np.array(orientation, float)).fault()


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
