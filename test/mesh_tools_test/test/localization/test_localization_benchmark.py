"""The benchmark of localization measures what it says."""

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mesh_localization.tracking.localizer import TrackingState
from mesh_map.registration.rigid import motion, moved
from mesh_tools_test.localization import drives, following
from mesh_tools_test.localization.worlds import DRIFT, WORLDS

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/localization.py"


@pytest.fixture(scope="module")
def world():
    return WORLDS["outdoor"](60_000)


def test_a_map_that_is_shifted_is_an_error_of_that_size(world):
    """Poses are compared with the truth, not with themselves."""
    shift = motion([0.05, 0.0, 0.0, 0.0, 0.0, 0.0])
    vertices = np.float32(moved(shift, world.geometry.vertices))
    target = type(world.target).of(vertices, world.geometry.faces)
    found = following.follow(replace(world, target=target), 20)
    assert np.median(found.errors[3:]) == pytest.approx(0.05, abs=0.01)
    assert np.median(following.follow(world, 20).errors) < 0.01


def test_people_hide_the_share_that_is_promised(world):
    found = following.follow(world, 20, following.people())
    assert 0.2 < found.before.mean() < 0.4


def test_the_odometry_beside_it_is_off_as_it_is_said(world):
    found = following.follow(world, 30)
    driven = DRIFT.of(world.sensor).positions
    assert np.linalg.norm(driven[-1] - world.sensor.positions[-1]) > 1.0
    assert found.odometry[-1] > found.odometry[5] > 0
    assert (found.states[3:] == TrackingState.OK).mean() > 0.8


def test_a_drive_by_localization_stands_beside_one_by_the_truth(world):
    figures = {figure.name.strip(): figure for figure in drives.measure(world, 1)}
    assert figures["not arrived"].value == 0 and figures["not arrived"].floor == 0
    assert figures["driven while lost"].value == 0
    assert abs(figures["farther from the goal than by the truth, at most"].value) < 100  # mm


def test_floors_stand_for_the_usual_world_alone(tmp_path):
    file = tmp_path / "figures.json"
    options = ["--faces", "20000", "--scans", "12", "--starts", "2", "--worlds", "outdoor"]
    subprocess.run(
        [SCRIPT, *options, "--only", "follow", "starts", "--json", file], check=True, timeout=200
    )
    found = json.loads(file.read_text())
    assert len(found) > 8 and all(figure["floor"] is None for figure in found)
    errors = [figure for figure in found if "error, median" in figure["name"]]
    assert errors[0]["peer"] == "odometry" and errors[0]["peer_value"] > errors[0]["value"]


def test_a_corridor_has_bounds_across_it_and_along_it():
    found = following.measure(WORLDS["corridor"](0), 60)
    bounded = {figure.name.strip() for figure in found if figure.floor is not None}
    assert {"across it, at most", "along it, of what odometry is off"} <= bounded
    assert all(figure.keeps_floor for figure in found if "across" in figure.name)
