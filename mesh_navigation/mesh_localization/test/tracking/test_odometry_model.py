"""How sure a pose is after a drive."""

import numpy as np
import pytest
from mesh_map.registration.rigid import inverse, motion, numbers_of

from mesh_localization.tracking.odometry_model import OdometryModel, OdometryMotion, turn_of

STILL = 0.0, 0.0
MODEL = OdometryModel(0.01, 0.0009, 0.0025, 0.0004, STILL)
SURE = np.zeros((6, 6))
TILTED = motion([0, 0, 0, 0.1, 0.0, 0.0])  # odometry that knows what is level


def test_a_motion_is_what_lies_between_poses():
    begin = motion([1, 2, 3, 0.1, -0.2, 2.0])
    way = OdometryMotion(begin)
    steps = [motion([0.5, 0, 0, 0, 0, 0.3]), motion([-0.25, 0, 0.1, 0, 0.05, 0])]
    pose = begin
    for step in steps:
        pose = pose @ step
        way.add(pose)
    assert np.allclose(way.step, steps[0] @ steps[1])
    assert way.driven == pytest.approx(0.5 + np.hypot(0.25, 0.1))
    assert way.turned == pytest.approx(0.35)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 3.0, np.pi])
def test_the_turn_of_a_pose(angle):
    axis = np.array([0.6, -0.48, 0.64])
    assert turn_of(motion(np.r_[5, 6, 7, angle * axis])) == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize("pieces", [1, 10, 200])
def test_deviations_grow_with_the_distance_however_often_one_looks(pieces):
    way = OdometryMotion(TILTED)
    for number in range(pieces):
        way.add(TILTED @ motion([8.0 * (number + 1) / pieces, 0, 0, 0, 0, 0]))
    covariance = way.grown(SURE, MODEL)
    assert np.allclose(np.sqrt(np.diag(covariance)), [0.4] * 3 + [0.24] * 3)


def test_errors_that_scans_did_not_see_go_on_growing():
    """Step by step with the way before each, as in one."""
    whole, covariance, driven = 8.0, SURE, 0.0
    for number in range(1, 81):
        before = TILTED @ motion([whole * (number - 1) / 80, 0, 0, 0, 0, 0])
        way = OdometryMotion(before, driven, 0.0)
        way.add(TILTED @ motion([whole * number / 80, 0, 0, 0, 0, 0]))
        covariance, driven = way.grown(covariance, MODEL), way.driven
    # The heading that is not sure adds to what is across and above alone.
    assert np.sqrt(covariance[0, 0]) == pytest.approx(0.4)
    assert np.sqrt(covariance[1, 1]) > 0.4 and np.sqrt(covariance[2, 2]) > 0.4


def test_a_covariance_is_told_in_the_frame_of_the_robot_that_moved():
    """Who is not sure of the heading is not sure where it is across, once it went on."""
    heading = np.diag([0, 0, 0, 0, 0, 0.01])
    way = OdometryMotion(TILTED)
    way.add(TILTED @ motion([10.0, 0, 0, 0, 0, 0]))
    covariance = way.grown(heading, OdometryModel(0, 0, 0, 0, STILL))
    assert np.sqrt(covariance[1, 1]) == pytest.approx(1.0)
    assert covariance[0, 0] == pytest.approx(0, abs=1e-12)
    random = np.random.default_rng(1)
    off = random.multivariate_normal(np.zeros(6), heading, 4000)
    begin, step = TILTED @ motion([3, 1, 0, 0, 0, 0.7]), motion([10.0, 0, 0, 0, 0, 0.4])
    way = OdometryMotion(begin)
    way.add(begin @ step)
    expected = way.grown(heading, OdometryModel(0, 0, 0, 0, STILL))
    found = np.array([numbers_of(inverse(step) @ motion(0.1 * one) @ step) for one in off])
    assert np.allclose(100 * np.cov(found.T), expected, atol=0.05)


def test_odometry_of_a_plane_does_not_know_height_and_tilt():
    for is_planar, slope in ((True, 0.0), (False, 0.01)):
        way = OdometryMotion(np.eye(4))
        way.add(motion([2.0, 1.0, slope, 0, 0, 0.5]))
        assert way.is_planar == is_planar
        deviations = np.sqrt(np.diag(way.grown(SURE, MODEL)))
        assert (deviations[2:5].min() > 0.8) == is_planar
        assert deviations[:2].max() < 0.4 and deviations[5] < 0.1


def test_errors_that_differ_from_step_to_step_grow_with_the_root():
    for length, deviation in ((1.0, 0.02), (4.0, 0.04)):
        way = OdometryMotion(TILTED)
        way.add(TILTED @ motion([length, 0, 0, 0, 0, 0]))
        covariance = way.grown(SURE, OdometryModel(0, 0, 0, 0, (0.0004, 0.0001)))
        found = np.sqrt(np.diag(covariance))
        assert np.allclose(found, np.repeat([deviation, deviation / 2], 3))
