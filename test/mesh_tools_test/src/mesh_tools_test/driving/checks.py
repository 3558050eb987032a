"""What tests of drives have in common."""

from typing import Any, Iterable

import numpy as np

from mesh_tools_test.driving.drives import driven
from mesh_tools_test.driving.verdicts import Statistics, failures, table
from mesh_tools_test.driving.worlds import DrivingWorld

COUNT = 20  # drives


def check_drives(
    world: DrivingWorld,
    planner: str = "wave_front",
    seeds: Iterable[int] = range(COUNT),
    **body: Any,
) -> Statistics:
    """Drive the trips of these seeds; AssertionError unless all of them arrive as they have to.

    Wheels slip and the ground is rough, yet nobody drives much farther than planned; around the
    corners of paths along edges it is shorter.
    """
    found = driven(world, list(seeds), planner, **body)
    told = failures([found]) + "\n" + table([found])
    assert not found.failed, told
    assert np.median(found.detours) < 1.03 and found.detours.min() > 0.7, told
    return found
