"""Something is put in the robot's way while it drives: it sees that, and drives around or stops."""

import numpy as np
import pytest
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.simulation.driving import drive
from mesh_tools_test.driving.obstacles import Watcher, column, distance, hall

START, GOAL = Pose.at((2.0, 6.0, 0.0)), Pose.at((10.0, 6.0, 0.0), np.pi / 2)
REPLAN = {"planner_frequency": 1.0}


def test_distances_are_those_of_the_column():
    obstacle = column(3.0, 6.0, radius=0.25)
    for point, expected in (((2.0, 6.0, 0.0), 0.75), ((3.0, 9.0, 5.0), 2.75), ((3, 6, 0), -0.25)):
        assert distance(obstacle, np.array(point)) == pytest.approx(expected)


def drive_to(watcher, start=START, goal=GOAL, values=REPLAN):
    return drive(watcher.mesh_map, start=start, goal=goal, values=values, on_step=watcher)


@pytest.mark.parametrize("ahead", [4.5, 2.5])
@pytest.mark.parametrize("aside", [0.0, 0.15, -0.2])
def test_a_column_on_the_way_is_driven_around(ahead, aside):
    watcher = Watcher(hall())
    obstacle = column(3.5 + ahead, 6.0 + aside)
    watcher.drop(obstacle, at_x=3.5)
    went = drive_to(watcher)
    assert went.arrived, went.result
    assert watcher.dropped_at is not None and watcher.dropped_at[0] < 3.6
    assert watcher.nearest > 0.05
    assert not len(went.blocked)
    # The straight way would have led through it.
    passing = np.argmin(np.abs(went.track[:, 0] - obstacle.pose.position[0]))
    assert abs(went.track[passing, 1] - obstacle.pose.position[1]) > 0.35


def test_what_is_beside_the_way_changes_nothing():
    """The same drive with and without a column that is 3 m aside."""
    tracks = []
    for aside in (None, 3.0):
        watcher = Watcher(hall())
        if aside is not None:
            watcher.drop(column(6.0, 6.0 + aside), at_x=3.5)
        tracks.append(drive_to(watcher, values={}).track)
    assert len(tracks[0]) == len(tracks[1])
    np.testing.assert_allclose(tracks[0], tracks[1], atol=0.01)


def test_without_a_new_plan_it_stops_before_a_wall_and_says_why():
    """Columns side by side; no plan comes that leads elsewhere."""
    watcher = Watcher(hall())
    for y in np.arange(0.3, 12.0, 0.55):
        watcher.drop(column(6.5, y), at_x=3.5)
    went = drive_to(watcher, values={"controller_patience": 2.0})
    assert went.result.outcome in (ExePathOutcome.BLOCKED_PATH, ExePathOutcome.PAT_EXCEEDED)
    assert "BLOCKED_PATH" in went.result.message or "blocked" in went.result.message
    assert 0.0 < watcher.nearest < 1.5 and not len(went.blocked)
    assert np.abs(went.velocities[-1]).max() < 1e-6


def test_one_that_goes_away_again_no_longer_counts():
    """The column stands there at first; later the robot drives nearer than it would."""
    watcher, column_there = Watcher(hall()), column(8.0, 6.0)
    present = []

    def watch(now, robot):
        watcher.present = [column_there] if now < 1.5 else []
        watcher(now, robot)
        present.append(np.isinf(watcher.mesh_map.planning_costs().costs).sum())

    went = drive(watcher.mesh_map, start=START, goal=GOAL, values=REPLAN, on_step=watch)
    assert went.arrived and max(present) > 5 and present[-1] == 0
    assert min(distance(column_there, position) for position in went.track[:, :3]) < 0.15
