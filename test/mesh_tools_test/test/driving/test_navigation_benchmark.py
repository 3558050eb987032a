"""The benchmark of navigation gives all its figures, and they are of what it says."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_tools_test.driving import cycles, server_ros
from mesh_tools_test.driving.server_ros import Control, control_figures
from mesh_tools_test.driving.trips import trip

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/navigation.py"


def run(folder, *arguments):
    """Text and JSON of the benchmark."""
    output = folder / "found.json"
    command = [str(SCRIPT), *arguments, "--json", str(output)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    text = done.stdout.decode()
    assert done.returncode == 0, text + done.stderr.decode()
    return text, json.loads(output.read_text())


def test_a_drive_can_be_repeated_by_its_seed(tmp_path):
    text, found = run(tmp_path, "--seed", "3", "--only", "drives")
    for name, verdicts in found["drives"].items():
        assert len(verdicts) == 1 and verdicts[0]["seed"] == 3
        assert "%-12s 1 of 1 " % name in text
    assert set(found["drives"]) >= {"outdoor", "two storeys"} and found["figures"] == []


def test_cycles_are_timed_while_costs_change_and_plans_come():
    world = cycles.large_world(10_000)
    quiet, busy = (cycles.timed_drive(world, trip(world, 0), busy) for busy in (False, True))
    for each in (quiet, busy):
        assert len(each.milliseconds) == pytest.approx(20 * each.seconds, abs=3)
        assert (each.milliseconds > 0).all()
    assert quiet.changes == 0
    assert busy.changes == pytest.approx(10 * busy.seconds, abs=2)
    assert np.isfinite(world.mesh_map.layers["obstacle"].result.costs).all()  # nothing is left


def test_the_server_is_measured_while_it_drives(tmp_path):
    arguments = ["--only", "server", "--faces", "12000", "--minutes", "0.1", "--plans", "8"]
    text, found = run(tmp_path, *arguments)
    figures = {figure["name"].strip(): figure["value"] for figure in found["figures"]}
    assert 5 < figures["driving for 6 s: cycles"] < 140
    assert 0 < figures["median"] <= figures["99 %"] <= figures["longest"]
    assert figures["memory of the server, ready"] > 10
    assert figures["at most"] >= figures["after 8 plans"] - 1
    assert figures["get_path, goal to result: median"] > 0
    assert "MISSED" not in text.split("driving")[1].split("memory")[0]  # too short for a verdict


def test_late_commands_are_counted():
    gaps = np.array([0.05] * 97 + [0.074, 0.076, 0.5])
    taken = np.linspace(1.0, 2.0, 101)
    ends = [(0, "arrived"), (108, "lost")]
    figures = {each.name.strip(): each for each in control_figures(Control(taken, gaps, ends), 60)}
    assert figures["commands late by half a cycle"].value == pytest.approx(2.0)
    assert not figures["commands late by half a cycle"].keeps_floor
    assert figures["99 %"].value == pytest.approx(1.99) and figures["99 %"].keeps_floor
    assert figures["longest time between two"].value == pytest.approx(500.0)
    assert figures["drives that arrived"].value == 1
    with pytest.raises(RuntimeError, match="nothing was driven"):
        control_figures(Control(taken[:0], gaps[:0], ends), 60)
    assert server_ros.LATE_SHARE == 0.1 and server_ros.CYCLE == 5.0  # what the project promises
