"""Poses between poses, and odometry that drifts."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from mesh_map.base.errors import MeshMapError
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.trajectory import Trajectory, quaternion_product, quaternions_of, rotations_of


def some(count=30, seed=0):
    random = np.random.default_rng(seed)
    times = np.cumsum(0.1 + random.random(count))
    turns = Rotation.random(count, random_state=seed).as_quat()
    return Trajectory(times, random.normal(size=(count, 3)), turns)


def level_loop(count=400):
    """A circle of 10 m around the origin, at a height of 2 m."""
    angle = np.linspace(0, 2 * math.pi, count)
    positions = np.stack([10 * np.cos(angle), 10 * np.sin(angle), np.full(count, 2.0)], axis=1)
    turned, zeros = (angle + math.pi / 2) / 2, np.zeros(count)
    turns = np.stack([zeros, zeros, np.sin(turned), np.cos(turned)], axis=1)
    return Trajectory(np.arange(count) * 0.1, positions, turns)


def test_between_poses_it_is_linear_and_slerp():
    path = some()
    times = np.linspace(path.times[0], path.times[-1], 501)
    positions, rotations = path.at(times)
    for axis in range(3):
        expected = np.interp(times, path.times, path.positions[:, axis])
        assert positions[:, axis] == pytest.approx(expected, abs=1e-12)
    slerp = Slerp(path.times, Rotation.from_quat(path.orientations))
    assert rotations == pytest.approx(slerp(times).as_matrix(), abs=1e-9)
    assert path.poses(path.times)[:, :3, 3] == pytest.approx(path.positions, abs=1e-14)


def test_before_and_behind_it_stands():
    path = some()
    ends = path.poses([path.times[0] - 5, path.times[-1] + 5])
    assert ends == pytest.approx(path.poses(path.times[[0, -1]]), abs=1e-12)
    one = Trajectory([3.0], path.positions[:1], path.orientations[:1])
    assert (one.poses([0.0, 9.0]) == one.poses([3.0])[0]).all()


def test_quaternions_and_rotations_are_each_others():
    turns = Rotation.random(200, random_state=1)
    quaternions = turns.as_quat()
    quaternions *= np.sign(quaternions[:, 3:])
    assert rotations_of(quaternions) == pytest.approx(turns.as_matrix(), abs=1e-12)
    assert quaternions_of(turns.as_matrix()) == pytest.approx(quaternions, abs=1e-9)
    other = Rotation.random(200, random_state=2)
    product = rotations_of(quaternion_product(quaternions, other.as_quat()))
    assert product == pytest.approx((turns * other).as_matrix(), abs=1e-12)
    path = Trajectory.of_matrices(some().poses(some().times), some().times)
    assert path.poses(path.times) == pytest.approx(some().poses(some().times), abs=1e-9)


def test_what_is_above_turns_with_it():
    path = some()
    raised = path.above(1.5)
    ups = raised.positions - path.positions
    expected = 1.5 * rotations_of(path.orientations)[:, :, 2]
    assert ups == pytest.approx(expected, abs=1e-12)
    assert raised.orientations == pytest.approx(path.orientations, abs=1e-15)


def test_resampled_it_goes_through_the_same_poses():
    path = some()
    fine = path.resampled(20.0)
    assert np.diff(fine.times) == pytest.approx(0.05) and fine.times[0] == path.times[0]
    assert fine.times[-1] <= path.times[-1] < fine.times[-1] + 0.05
    assert fine.poses(fine.times) == pytest.approx(path.poses(fine.times), abs=1e-9)


@pytest.mark.parametrize(
    "wrong, text",
    [
        ({"times": [0.0, 0.0]}, "1 of 2 poses of a trajectory cannot be used; the first is pose 1"),
        ({"times": [0.0, math.nan]}, "the first is pose 1"),
        ({"positions": [[0, 0, math.inf], [0, 0, 0]]}, "the first is pose 0"),
        ({"orientations": [[0, 0, 0, 1], [0, 0, 0, 0.5]]}, "the first is pose 1"),
        ({"times": []}, r"a trajectory of times \(0,\)"),
        ({"positions": [[0, 0]]}, r"positions \(1, 2\)"),
    ],
)
def test_what_is_no_trajectory_is_refused(wrong, text):
    good = {"times": [0, 1], "positions": np.zeros((2, 3)), "orientations": [[0, 0, 0, 1]] * 2}
    with pytest.raises(MeshMapError, match=text):
        Trajectory(**{**good, **wrong})


def test_what_are_no_poses_is_refused():
    with pytest.raises(MeshMapError, match=r"poses of the shape \(4, 4\)"):
        Trajectory.of_matrices(np.eye(4), [0.0])
    for wrong in (np.diag([1, 1, -1, 1.0]), np.diag([2, 1, 1, 1.0]), np.full((4, 4), np.nan)):
        with pytest.raises(MeshMapError, match="1 of 2 poses are no rotation .* pose 1"):
            Trajectory.of_matrices(np.stack([np.eye(4), wrong]), [0.0, 1.0])


def test_without_drift_odometry_is_the_truth():
    path = level_loop()
    assert OdometryDrift().of(path) is path


def test_slip_scales_and_yaw_turns():
    path = level_loop()
    slipped = OdometryDrift(slip=0.1).of(path)
    expected = path.positions[0] + 1.1 * (path.positions - path.positions[0])
    assert slipped.positions == pytest.approx(expected, abs=1e-9)
    assert slipped.orientations == pytest.approx(path.orientations)
    turned = OdometryDrift(yaw=0.01).of(path)
    # A circle with a heading that drifts is one of another radius: 1/r + 0.01 of curvature.
    steps = np.linalg.norm(np.diff(turned.positions, axis=0), axis=1)
    assert steps == pytest.approx(np.linalg.norm(np.diff(path.positions, axis=0), axis=1))
    headings = np.unwrap(2 * np.arctan2(turned.orientations[:, 2], turned.orientations[:, 3]))
    assert headings[-1] - headings[0] == pytest.approx(2 * math.pi + 0.01 * path.length)
    middle = turned.positions[0] - [1 / (0.1 + 0.01), 0, 0]
    assert np.linalg.norm(turned.positions - middle, axis=1) == pytest.approx(1 / 0.11, rel=1e-3)
    risen = OdometryDrift(height=0.02).of(path)
    assert risen.positions[-1, 2] - 2 == pytest.approx(0.02 * path.length)
    assert risen.positions[:, :2] == pytest.approx(path.positions[:, :2], abs=1e-9)


def test_noise_is_that_of_the_seed_and_grows_with_the_root_of_the_distance():
    count = 101
    line = np.stack([np.linspace(0, 100, count), np.zeros(count), np.zeros(count)], axis=1)
    straight = Trajectory(np.arange(count), line, np.tile([0, 0, 0, 1.0], (count, 1)))
    drift = OdometryDrift(noise=0.01)
    again = drift.of(straight, 5).positions
    assert again.tolist() == drift.of(straight, 5).positions.tolist()
    assert again.tolist() != drift.of(straight, 6).positions.tolist()
    drifted = [drift.of(straight, seed) for seed in range(300)]
    assert np.std([each.length for each in drifted]) == pytest.approx(0.1, rel=0.2)
    headings = [2 * np.arcsin(each.orientations[-1, 2]) for each in drifted]
    assert np.std(headings) == pytest.approx(0.1, rel=0.2)


@pytest.mark.parametrize("wrong", [{"slip": math.nan}, {"yaw": math.inf}, {"noise": -0.1}])
def test_impossible_drift_is_refused(wrong):
    with pytest.raises(MeshMapError, match="odometry that drifts by"):
        OdometryDrift(**wrong)
