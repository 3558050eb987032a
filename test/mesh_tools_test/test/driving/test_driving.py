"""Random trips with the shipped configuration: the robot arrives, rightly headed, never on lethal
ground nor nearer to it than its radius."""

from typing import Any, Iterable

import numpy as np
import pytest
from mesh_navigation.base.pose import Pose
from mesh_navigation.simulation.driving import drive
from mesh_tools_test.driving import shipped, worlds
from mesh_tools_test.driving.drives import driven
from mesh_tools_test.driving.verdicts import TOO_NEAR, Statistics, failures, table
from mesh_tools_test.driving.worlds import DrivingWorld

COUNT = 6  # drives; the benchmark drives more


def check_drives(
    world: DrivingWorld,
    planner: str = "",
    seeds: Iterable[int] = range(COUNT),
    **given: Any,
) -> Statistics:
    """Drive the trips of these seeds; AssertionError unless all of them arrive as they have to.

    Wheels slip and the ground is rough, yet nobody drives much farther than planned; around the
    corners of paths along edges it is shorter.
    """
    found = driven(world, list(seeds), planner, **given)
    told = failures([found]) + "\n" + table([found])
    assert not found.failed and found.planned, told
    least = min(verdict.lethal_distance for verdict in found.planned)
    assert least >= shipped.radius() - TOO_NEAR > 0.2, told
    assert np.median(found.detours) < 1.03 and found.detours.min() > 0.7, told
    return found


def test_outdoors():
    found = check_drives(worlds.outdoor(20_000))
    assert len(found.planned) == COUNT == 6


def test_in_a_building_of_large_faces():
    """Walls, pillars and furniture are surfaces of their own."""
    assert len(check_drives(worlds.building(), seeds=range(5)).planned) == 5


def test_on_rough_ground():
    assert len(check_drives(worlds.rough(15.0), seeds=range(8)).planned) >= 5


# Poses (position and orientation) on the rough terrain where straight on is, over its bumps, not
# quite where the robot's arcs lead, and goals a bit ahead.
BUMPY = [
    ((15.958, 5.555, -0.143, 0.08286, 0.26494, 0.06648, 0.95839), (16.716, 5.496, -0.217)),
    ((14.550, 19.882, -0.416, 0.40245, -0.08381, 0.61367, 0.67411), (14.684, 20.583, -0.227)),
]


# Where straight on over a steep bump leads too near to what is lethal, and to a nearer place of the
# way does not.
STEEP = (27.2938, 10.7683, -0.1439, 0.32937, -0.46590, 0.81266, -0.11851), (25.312, 11.523, 0.060)


@pytest.fixture(scope="module")
def bumps():
    return worlds.rough().mesh_map


@pytest.mark.parametrize("start, goal", [*BUMPY, STEEP])
def test_room_that_is_wished_for_does_not_stop_the_robot(bumps, start, goal):
    """Beside what is lethal, where the side_clearance would have it stand."""
    body = shipped.body(bumps)
    went = drive(
        bumps,
        shipped.planner(bumps, body),
        shipped.controller(bumps, body),
        start=Pose(np.array(start[:3]), np.array(start[3:])),
        goal=Pose.at(goal),
        values=shipped.server(),
    )
    assert went.arrived, went.result.message


def test_on_the_tray():
    path = worlds.tray_file()
    if path is None:
        pytest.skip("tray.ply is not there (environment variable MESH_TOOLS_DATA)")
    check_drives(worlds.tray(path))


@pytest.fixture(scope="module")
def park():
    return worlds.car_park(size=12.0)


def test_from_storey_to_storey(park):
    found = check_drives(park)
    assert min(verdict.planned for verdict in found.verdicts) > 8.0  # the ramp


@pytest.mark.parametrize("planner", ["dijkstra_mesh_planner", "mmp_planner"])
def test_paths_of_other_planners_are_driven_too(park, planner):
    check_drives(park, planner, seeds=range(2))
