"""The guard's limits in config/controllers.yaml are for faults: they leave the controller alone."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from controller_drives import random_drives

from mesh_msgs import zoo
from mesh_navigation.base.robot import STOP
from mesh_navigation.velocity_guard.velocity_bounds import VelocityBounds, VelocityLimits

FILE = Path(__file__).resolve().parents[2] / "config/controllers.yaml"
SHIPPED = yaml.safe_load(FILE.read_text())
LIMITS = VelocityLimits(**SHIPPED["guard"])
CONTROLLER = SHIPPED["mesh_controller"]


@pytest.mark.parametrize("name", VelocityLimits._fields)
def test_about_twice_what_the_controller_commands(name):
    assert 1.5 * CONTROLLER[name] <= getattr(LIMITS, name) <= 2.5 * CONTROLLER[name]


@pytest.mark.parametrize("trouble", [{}, {"slip": 0.3, "noise": 0.05}])
def test_what_the_controller_commands_passes_as_it_is(trouble):
    mesh, period = zoo.jittered_plane(cells=30), 1.0 / SHIPPED["controller_frequency"]
    costs = np.zeros(len(mesh.vertices))
    costs[np.random.default_rng(1).uniform(size=len(costs)) < 0.03] = np.inf
    values = {"controller_frequency": SHIPPED["controller_frequency"]}
    count = 0
    for went in random_drives(mesh, costs, 4, given=CONTROLLER, values=values, **trouble):
        bounds = VelocityBounds(LIMITS)
        for index, cycle in enumerate(went.cycles):
            count += cycle.velocity != STOP
            assert bounds.bounded(cycle.velocity, index * period, period) == cycle.velocity
    assert count > 100
