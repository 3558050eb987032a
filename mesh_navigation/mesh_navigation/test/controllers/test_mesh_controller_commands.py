"""What a command may be: free ground, periods of commands, bases that obey late."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_navigation.base.pose import Pose
from mesh_navigation.controllers.steering import turning_speed
from controller_drives import command_at, controller_on, following, planned
from navigation_test_maps import MapWithCosts

GRID = MapWithCosts(zoo.grid(cells=50))


def path_along(y, **given):
    """A controller with a path along x, straight on at this y."""
    plan = planned(GRID, Pose.at((2.0, y, 0.0)), Pose.at((9.0, y, 0.0)), "dijkstra")
    return following(GRID, plan, follow="path", **given)


def lowest_before_it_stands(velocity, heading, brakes):
    """How far to its right a robot gets on the arc that it was told to drive, if it brakes (m)."""
    lengths = np.linspace(0.0, velocity.x**2 / (2 * brakes), 100)
    sines = np.sin(heading + velocity.yaw / max(velocity.x, 1e-9) * lengths)
    return float((np.cumsum(sines) * lengths[1]).min())


def test_an_arc_that_leaves_free_ground_is_not_driven():
    """Headed across the border, with a path beside it: so slowly that it could stand before."""
    border, heading = float(GRID.vertices[:, 1].min()), -0.6
    for room in (2.0, 0.02):
        controller = path_along(border + room + 0.2, max_angle=90.0, max_lin_acceleration=0.2)
        pose = Pose.at((3.0, border + room, 0.0), heading)
        for cycle in range(60):
            velocity = command_at(controller, pose, 0.05 * cycle).velocity
        lowest = lowest_before_it_stands(velocity, heading, 0.2)
        assert velocity.yaw > 0.0 and lowest > -room
        assert lowest < -0.02 or room < 2.0  # which is what the border forbids


@pytest.mark.parametrize("jump", [-100.0, 100.0])
def test_a_time_that_jumps_is_no_period(jump):
    """Commands begin from standing then, with the period from before."""
    controller, pose = path_along(5.0), Pose.at((3.0, 5.0, 0.0))
    times = [0.1, 0.2, 0.3, 0.4, 0.4]
    speeds = [command_at(controller, pose, time).velocity.x for time in times]
    step = 0.1 * controller.values["max_lin_acceleration"]
    assert speeds[1:4] == pytest.approx([speeds[0] + step * k for k in (1, 2, 3)])
    assert speeds[4] == pytest.approx(speeds[3] + step)
    after = [command_at(controller, pose, 0.4 + jump + k * 0.1).velocity.x for k in range(3)]
    assert after == pytest.approx([step, 2 * step, 3 * step])


@pytest.mark.parametrize("period", [0.02, 0.2, 1.0])
def test_a_base_that_obeys_a_period_later_does_not_swing(period):
    values = controller_on(GRID, max_ang_acceleration=50.0, max_ang_velocity=2.0).values
    angle, obeyed, angles = 0.1, 0.0, []
    for _ in range(60):
        commanded = turning_speed(angle, values, period)
        angle -= obeyed * period
        obeyed = commanded
        angles.append(abs(angle))
    assert max(angles[30:]) < 0.01
