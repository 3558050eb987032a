"""Random trips on three worlds: the robot arrives, rightly headed, never on lethal ground."""

import numpy as np
import pytest
from mesh_tools_test.driving import worlds
from mesh_tools_test.driving.drives import driven
from mesh_tools_test.driving.verdicts import failures, table

COUNT = 20


def check(world, planner, seeds=range(COUNT), **body):
    """All of these drives succeed."""
    found = driven(world, list(seeds), planner, **body)
    assert not found.failed, failures([found]) + "\n" + table([found])
    # Wheels slip and the ground is rough, yet nobody drives much farther than planned; around the
    # corners of paths along edges it is shorter.
    assert np.median(found.detours) < 1.03 and found.detours.min() > 0.85, table([found])
    return found


@pytest.fixture(scope="module")
def outdoor():
    return worlds.outdoor(20_000)


@pytest.fixture(scope="module")
def park():
    return worlds.car_park(size=12.0)


def test_outdoors(outdoor):
    check(outdoor, "wave_front")


def test_from_storey_to_storey(park):
    found = check(park, "wave_front")
    assert min(verdict.planned for verdict in found.verdicts) > 8.0  # the ramp


def test_on_the_tray():
    path = worlds.tray_file()
    if path is None:
        pytest.skip("tray.ply is not there (environment variable MESH_TOOLS_DATA)")
    check(worlds.tray(path), "wave_front")


@pytest.mark.parametrize("planner", ["dijkstra", "exact"])
def test_paths_of_other_planners_are_driven_too(park, planner):
    check(park, planner, seeds=range(3))
