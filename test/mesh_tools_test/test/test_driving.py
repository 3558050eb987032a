"""Random trips on three worlds: the robot arrives, rightly headed, never on lethal ground."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_tools_test.driving import cycles, worlds
from mesh_tools_test.driving.drives import driven
from mesh_tools_test.driving.trips import trip
from mesh_tools_test.driving.verdicts import failures, table

SCRIPT = Path(__file__).resolve().parents[1] / "benchmark/navigation.py"
COUNT = 20


def check(world, planner, seeds=range(COUNT), **body):
    """All of these drives succeed."""
    found = driven(world, list(seeds), planner, **body)
    assert not found.failed, failures([found]) + "\n" + table([found])
    # Wheels slip and the ground is rough, yet the way that was planned is the way that is driven.
    assert np.median(found.detours) == pytest.approx(1.0, abs=0.05), table([found])
    return found


@pytest.fixture(scope="module")
def outdoor():
    return worlds.outdoor(20_000)


@pytest.fixture(scope="module")
def park():
    return worlds.car_park()


def test_outdoors(outdoor):
    check(outdoor, "wave_front")


def test_from_storey_to_storey(park):
    found = check(park, "wave_front")
    assert min(verdict.planned for verdict in found.verdicts) > 12.0  # the ramp


def test_on_the_tray():
    path = worlds.tray_file()
    if path is None:
        pytest.skip("tray.ply is not there (environment variable MESH_TOOLS_DATA)")
    check(worlds.tray(path), "wave_front")


@pytest.mark.parametrize("planner", ["dijkstra", "exact"])
def test_paths_of_other_planners_are_driven_too(park, planner):
    check(park, planner, seeds=range(3))


def test_cycles_are_timed_while_costs_change_and_plans_come():
    world = cycles.large_world(10_000)
    lengths = [cycles.timed_drive(world, trip(world, 0), busy) for busy in (False, True)]
    quiet, busy = lengths
    for each in lengths:
        assert len(each.milliseconds) == pytest.approx(20 * each.seconds, abs=3)
        assert (each.milliseconds > 0).all()
    assert quiet.changes == 0
    assert busy.changes == pytest.approx(10 * busy.seconds, abs=2)
    assert np.isfinite(world.mesh_map.layers["obstacle"].result.costs).all()  # nothing is left


def test_the_benchmark_prints_what_it_found(tmp_path):
    output = tmp_path / "found.json"
    command = [str(SCRIPT), "--seed", "3", "--only", "drives", "--json", str(output)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    text = done.stdout.decode()
    assert done.returncode == 0, text + done.stderr.decode()
    for name, verdicts in json.loads(output.read_text())["drives"].items():
        assert len(verdicts) == 1 and verdicts[0]["seed"] == 3
        assert "%-12s 1 of 1 " % name in text
