"""Random trips from storey to storey, along paths of all planners."""

import pytest
from mesh_tools_test.driving import worlds
from mesh_tools_test.driving.checks import check_drives


@pytest.fixture(scope="module")
def park():
    return worlds.car_park(size=12.0)


def test_from_storey_to_storey(park):
    found = check_drives(park)
    assert min(verdict.planned for verdict in found.verdicts) > 8.0  # the ramp


@pytest.mark.parametrize("planner", ["dijkstra", "exact"])
def test_paths_of_other_planners_are_driven_too(park, planner):
    check_drives(park, planner, seeds=range(2))
