"""Drives of the mesh controller in simulated time, for tests."""

import numpy as np

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, RobotState, Velocity
from mesh_navigation.controllers.mesh_controller import MeshController
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.plugins.controller import ControllerPlan
from mesh_navigation.simulation.driving import drive
from navigation_test_maps import MapWithCosts, random_pairs


def controller_on(mesh_map, **parameters):
    """A controller, ready."""
    controller = MeshController()
    assert controller.initialize("controller", mesh_map, parameters) == []
    return controller


def planned(mesh_map, start, goal, planner="wave_front"):
    """A plan as a controller gets it."""
    result = make_planner(mesh_map, planner).make_plan(start, goal)
    assert result.succeeded, result.message
    return ControllerPlan(result.poses, result.plan_field)


def following(mesh_map, plan, **parameters):
    """A controller that follows a plan."""
    controller = controller_on(mesh_map, **parameters)
    controller.set_plan(plan)
    return controller


def command_at(controller, pose, time=0.0, velocity=STOP):
    """What a controller wants at a pose."""
    return controller.compute_velocity(RobotState(time, pose, velocity), Cancellation())


def random_drives(mesh, costs, count, seed=0, planner="wave_front", given={}, values={}, **body):
    """Drives from random places to random goals, both with random headings, that have a plan."""
    mesh_map = MapWithCosts(mesh, costs)
    controller, planner = controller_on(mesh_map, **given), make_planner(mesh_map, planner)
    rng = np.random.default_rng(seed)
    for index, (start, goal) in enumerate(random_pairs(mesh, count, seed)):
        yaws = rng.uniform(-np.pi, np.pi, 2)
        ends = Pose.at(start[1], yaws[0]), Pose.at(goal[1], yaws[1])
        went = drive(
            mesh_map,
            planner,
            controller,
            start=ends[0],
            goal=ends[1],
            values=values,
            seed=index,
            max_time=300.0,
            **body,
        )
        if went.plan.succeeded:
            yield went


def check_commands(went, values, period):
    """Limits of speeds and accelerations hold in every cycle, up to the stop at the end."""
    driving = [cycle.velocity for cycle in went.cycles if cycle.outcome == 0]
    commands = np.array([STOP] + driving)
    assert np.isfinite(commands).all() and not commands[:, 1].any()
    assert commands[:, 0].min() >= 0.0
    assert commands[:, 0].max() <= values["max_lin_velocity"] + 1e-9
    assert np.abs(commands[:, 2]).max() <= values["max_ang_velocity"] + 1e-9
    steps = np.abs(np.diff(commands, axis=0))
    # The result's cycle is the stop, after all of them.
    steps = steps[: -1 if driving and driving[-1] == Velocity() else None]
    assert steps[:, 0].max() <= values["max_lin_acceleration"] * period + 1e-6
    assert steps[:, 2].max() <= values["max_ang_acceleration"] * period + 1e-6
