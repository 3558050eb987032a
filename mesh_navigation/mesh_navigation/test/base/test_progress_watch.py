"""Getting on by a way or a turn, and times that jump."""

import math

import numpy as np
import pytest

from mesh_navigation.base.pose import Pose, multiply
from mesh_navigation.base.progress_watch import ProgressWatch, angle_between


def at(x, yaw=0.0):
    return Pose.at((x, 0.0, 0.0), yaw)


def test_before_the_first_pose():
    assert ProgressWatch().seconds(100.0) == 0.0


def test_a_way_is_measured_from_where_it_last_got_on():
    watch = ProgressWatch()
    found = [watch.got_on(at(0.1 * n), float(n), 0.35, 9.0) for n in range(13)]
    assert [n for n, got_on in enumerate(found) if got_on] == [4, 8, 12]
    assert watch.seconds(20.0) == 8.0


def test_to_and_fro_is_no_way():
    watch = ProgressWatch()
    assert not any(watch.got_on(at(0.3 * (n % 2)), float(n), 0.35, 9.0) for n in range(50))
    assert watch.seconds(50.0) == 50.0


def test_a_turn_counts_too():
    watch = ProgressWatch()
    found = [watch.got_on(at(0.0, 0.3 * n), float(n), 0.5, 1.0) for n in range(9)]
    assert [n for n, got_on in enumerate(found) if got_on] == [4, 8]


def test_time_that_jumps_back_begins_anew():
    watch = ProgressWatch()
    watch.got_on(at(0.0), 100.0, 0.5, 9.0)
    assert not watch.got_on(at(9.0), 10.0, 0.5, 9.0)
    assert (watch.seconds(12.0), watch.seconds(5.0)) == (2.0, 0.0)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, 2.5, math.pi - 1e-9, math.pi])
def test_angles(angle):
    first = at(0.0, 0.7)
    for sign in (1, -1):
        # The negative of a quaternion is the same orientation.
        second = Pose(first.position, sign * at(0.0, 0.7 + angle).orientation)
        assert angle_between(first, second) == pytest.approx(angle, abs=1e-12)
        assert angle_between(second, first) == pytest.approx(angle, abs=1e-12)


def test_angles_of_random_turns():
    rng = np.random.default_rng(0)
    for _ in range(100):
        axis, angle = rng.normal(size=3), rng.uniform(0, math.pi)
        axis /= np.linalg.norm(axis)
        turn = np.array([*(axis * math.sin(angle / 2)), math.cos(angle / 2)])
        base = rng.normal(size=4)
        base /= np.linalg.norm(base)
        poses = [Pose(np.zeros(3), q) for q in (base, multiply(base, turn))]
        assert angle_between(*poses) == pytest.approx(angle, abs=1e-9)
