"""Where a robot has been."""

import numpy as np

from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import JUMP, LENGTH, SPACING, Trail


def trail_of(*xs):
    trail = Trail()
    for x in xs:
        trail.add(Pose.at((x, 0, 0)))
    return trail


def places(trail):
    return [round(float(pose.position[0]), 3) for pose in trail.back()]


def test_poses_are_apart():
    assert places(trail_of(0, 0.04, 0.06, 0.1, 0.12)) == [0.12, 0.06, 0.0]


def test_a_robot_that_was_put_elsewhere_did_not_drive_there():
    assert places(trail_of(0, 0.5, 0.5 + 1.1 * JUMP)) == [0.5 + 1.1 * JUMP]
    assert places(trail_of(0, 0.5, 0.5 + 0.9 * JUMP)) == [0.5 + 0.9 * JUMP, 0.5, 0.0]


def test_what_is_too_old_is_forgotten():
    trail = trail_of(*np.arange(0, 2 * LENGTH, 1.01 * SPACING))
    assert len(places(trail)) == int(LENGTH / SPACING)


def test_the_last_poses_can_be_forgotten():
    trail = trail_of(0, 1, 2, 3)
    trail.forget_last(0)
    assert places(trail) == [3, 2, 1, 0]
    trail.forget_last(2)
    assert places(trail) == [1, 0]
    trail.forget_last(9)
    assert places(trail) == []
    trail.clear()
    assert places(trail) == []
