"""Random trips: the robot arrives, rightly headed, never on lethal ground."""

from typing import Any, Iterable

import numpy as np
import pytest
from mesh_navigation.body.robot_shape import RobotShape
from mesh_tools_test.driving import worlds
from mesh_tools_test.driving.drives import driven
from mesh_tools_test.driving.verdicts import TOO_NEAR, Statistics, failures, table
from mesh_tools_test.driving.worlds import DrivingWorld

COUNT = 12  # drives


def check_drives(
    world: DrivingWorld,
    planner: str = "wave_front",
    seeds: Iterable[int] = range(COUNT),
    **given: Any,
) -> Statistics:
    """Drive the trips of these seeds; AssertionError unless all of them arrive as they have to.

    Wheels slip and the ground is rough, yet nobody drives much farther than planned; around the
    corners of paths along edges it is shorter.
    """
    found = driven(world, list(seeds), planner, **given)
    told = failures([found]) + "\n" + table([found])
    assert not found.failed, told
    assert np.median(found.detours) < 1.03 and found.detours.min() > 0.7, told
    return found


def test_outdoors():
    """A robot with a body, which keeps its radius from lethal ground."""
    found = check_drives(worlds.outdoor(20_000), shape=RobotShape(radius=0.25))
    assert len(found.verdicts) == COUNT == 12
    assert min(verdict.lethal_distance for verdict in found.verdicts) >= 0.25 - TOO_NEAR


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


@pytest.mark.parametrize("planner", ["dijkstra", "exact"])
def test_paths_of_other_planners_are_driven_too(park, planner):
    check_drives(park, planner, seeds=range(2))
