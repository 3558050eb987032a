"""Whole drives: they arrive, keep to free ground and to the limits, and fail as they should."""

import math

import numpy as np
import pytest
from maps_with_costs import MapWithCosts, lethal_where, lifted, random_place
from mesh_map.base.plugins import find_class
from mesh_msgs import zoo
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, RobotState
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.plugins.controller import ControlFailure, ControllerPlan
from mesh_navigation.simulation.driving import drive, make_controller

from example_mesh_navigation.pure_pursuit_controller import PurePursuitController

TYPE = "example_mesh_navigation/PurePursuitController"
STRAIGHT = "example_mesh_navigation/StraightPlanner"
PERIOD = 0.05  # s
PLANE = zoo.jittered_plane(cells=30)
HILLS = lifted(PLANE, lambda x, y: 0.5 * np.sin(x) * np.cos(0.7 * y))


def spots(mesh, share=0.04):
    return np.where(np.random.default_rng(1).random(len(mesh.vertices)) < share, np.inf, 0.0)


WORLDS = {
    "plane": (PLANE, None),
    "hills": (HILLS, None),
    "spots": (PLANE, spots(PLANE)),
    "hole": (zoo.hole(), None),
    "storeys": (zoo.two_storeys(), None),
}


def check_limits(went, values):
    """Speeds and accelerations of all commands up to the stop at the end."""
    commands = np.array([STOP] + [cycle.velocity for cycle in went.cycles])
    assert np.isfinite(commands).all() and not commands[:, 1].any()
    assert 0.0 <= commands[:, 0].min()
    assert commands[:, 0].max() <= values["max_lin_velocity"] + 1e-9
    assert np.abs(commands[:, 2]).max() <= values["max_ang_velocity"] + 1e-9
    steps = np.diff(commands[: max(len(commands) - 1, 2)], axis=0)
    assert steps[:, 0].max() <= values["max_lin_acceleration"] * PERIOD + 1e-6
    assert np.abs(steps[:, 2]).max() <= values["max_ang_acceleration"] * PERIOD + 1e-6


def check_arrived(went, tolerance=0.1, angle=math.pi / 18):
    assert went.arrived, went.result.message
    assert went.result.dist_to_goal <= tolerance and went.result.angle_to_goal <= angle + 1e-6
    assert len(went.blocked) == 0
    assert went.driven_length <= 1.1 * went.planned_length + 0.3


@pytest.mark.parametrize("planner", ["wave_front", "dijkstra", STRAIGHT])
@pytest.mark.parametrize("name", WORLDS)
def test_random_goals_are_reached(name, planner):
    mesh, costs = WORLDS[name]
    mesh_map, random = MapWithCosts(mesh, costs), np.random.default_rng(5)
    controller, planner = make_controller(mesh_map, TYPE), make_planner(mesh_map, planner)
    arrived = 0
    for _ in range(15):
        places = [random_place(mesh, random, costs) for _ in range(2)]
        start, goal = (Pose.at(place, random.uniform(-3, 3)) for place in places)
        if arrived < 3 and planner.make_plan(start, goal).succeeded:
            went = drive(mesh_map, planner, controller, start=start, goal=goal, max_time=300.0)
            arrived += 1
            check_arrived(went)
            check_limits(went, controller.values)
    assert arrived == 3


def test_a_slope_is_driven_to_the_next_storey():
    mesh = zoo.two_storeys()
    start, goal = Pose.at([0.5, 13, 0], 0.0), Pose.at([11.5, 13, 3], math.pi / 2)
    mesh_map = MapWithCosts(mesh)
    controller = make_controller(mesh_map, TYPE)
    went = drive(mesh_map, STRAIGHT, controller, start=start, goal=goal)
    check_arrived(went)
    check_limits(went, controller.values)
    length = 3.0 + math.hypot(8.0, 3.0)
    assert went.driven_length == pytest.approx(length, abs=0.15)
    assert np.abs(went.track[:, 1] - 13.0).max() < 0.1
    assert went.times[-1] > length / 0.8


def test_noise_slip_and_a_push_are_recovered_from():
    mesh_map, pushed = MapWithCosts(PLANE), []

    def push(time, robot):
        if time >= 3.0 and not pushed:
            pose = robot.body.pose
            pushed.append(pose)
            robot.put(Pose(pose.position + [-0.3, 0.4, 0.0], pose.orientation))

    start, goal = Pose.at([2, 2, 0], 2.0), Pose.at([8, 7, 0], -2.0)
    given = dict(start=start, goal=goal, slip=0.1, noise=0.05, seed=4)
    went = drive(mesh_map, STRAIGHT, TYPE, on_step=push, **given)
    assert pushed and went.arrived, went.result.message


def test_new_plans_do_not_stop_it():
    mesh_map = MapWithCosts(PLANE)
    start, goal = Pose.at([1, 1, 0], 0.7), Pose.at([8, 8, 0], 0.7)
    went = drive(
        mesh_map, STRAIGHT, TYPE, start=start, goal=goal, values={"planner_frequency": 2.0}
    )
    check_arrived(went)
    on_the_way = (went.times > 2.0) & (went.times < went.times[-1] - 2.0)
    assert went.commands[on_the_way, 0].min() > 0.75


def test_it_stops_before_ground_that_becomes_lethal():
    mesh_map = MapWithCosts(PLANE)
    wall = lethal_where(PLANE, lambda at: (at[:, 0] > 5.5) & (at[:, 0] < 6.5))

    def block(time, robot):
        if time >= 2.0 and not np.isinf(mesh_map.planning_costs().costs).any():
            mesh_map.set_costs(wall)

    start, goal = Pose.at([2, 5, 0]), Pose.at([9, 5, 0])
    controller = make_controller(mesh_map, TYPE, {"blocked_distance": 0.4})
    went = drive(mesh_map, STRAIGHT, controller, start=start, goal=goal, on_step=block)
    assert went.result.outcome == ExePathOutcome.PAT_EXCEEDED
    assert "BLOCKED_PATH (109), the way of the robot" in went.result.message
    assert len(went.blocked) == 0
    # Blocked ground begins within an edge of the lethal vertices.
    assert 0.4 < went.clearance < 0.4 + 0.5
    assert went.velocities[-1, 0] == 0.0
    check_limits(went, controller.values)


def test_it_drives_on_when_the_ground_is_free_again():
    wall = lethal_where(PLANE, lambda at: (at[:, 0] > 5.5) & (at[:, 0] < 6.5))
    mesh_map = MapWithCosts(PLANE)
    planner = make_planner(mesh_map, STRAIGHT)

    def block(time, robot):
        closed = np.isinf(mesh_map.planning_costs().costs).any()
        if closed != (2.0 <= time < 9.0):
            mesh_map.set_costs(0.0 * np.isinf(wall) if closed else wall)

    went = drive(
        mesh_map, planner, TYPE, start=Pose.at([2, 5, 0]), goal=Pose.at([9, 5, 0]), on_step=block
    )
    check_arrived(went)
    assert (np.abs(went.velocities[(went.times > 8.0) & (went.times < 8.9), 0]) < 1e-6).all()


def test_the_body_keeps_off_walls():
    walls = lethal_where(PLANE, lambda at: np.abs(at[:, 1] - 5.0) > 1.5)
    mesh_map = MapWithCosts(PLANE, walls)
    body = Body(mesh_map.geometry, RobotShape(radius=0.4))
    planner = make_planner(mesh_map, "wave_front", body=body)
    controller = make_controller(mesh_map, TYPE, body=body)
    start, goal = Pose.at([1, 4.5, 0], 3.0), Pose.at([9, 5.5, 0], 0.0)
    went = drive(mesh_map, planner, controller, start=start, goal=goal)
    check_arrived(went)
    assert went.clearance >= 0.4


def test_a_path_that_is_too_narrow_for_the_body_is_not_driven():
    walls = lethal_where(PLANE, lambda at: np.abs(at[:, 1] - 5.0) > 1.5)
    mesh_map = MapWithCosts(PLANE, walls)
    body = Body(mesh_map.geometry, RobotShape(radius=0.8))
    controller = make_controller(mesh_map, TYPE, body=body)
    start, goal = Pose.at([1, 5, 0], -0.1), Pose.at([9, 4.1, 0])  # of a planner without a body
    went = drive(mesh_map, STRAIGHT, controller, start=start, goal=goal)
    assert went.plan.succeeded and not went.arrived
    assert "BLOCKED_PATH" in went.result.message
    assert went.clearance >= 0.8 - 0.02 and went.driven_length > 2.0


def test_bends_are_driven_as_fast_as_the_side_allows():
    mesh_map = MapWithCosts(PLANE)
    turns = np.linspace(-math.pi / 2, math.pi / 2, 60)  # half a circle with a radius of 2 m
    poses = [[5 + 2 * math.cos(t), 5 + 2 * math.sin(t), 0, 0, 0, 0, 1] for t in turns]
    plan, exact = ControllerPlan(np.array(poses, np.float64)), {"side_clearance": 0.0}
    for side, expected in ((0.1, math.sqrt(0.1 * 2)), (0.05, math.sqrt(0.05 * 2)), (9.0, 0.8)):
        controller = make_controller(mesh_map, TYPE, {"max_lat_acceleration": side, **exact})
        controller.set_plan(plan)
        for cycle in range(40):
            pose = Pose.at([7.0, 5.0, 0.0], math.pi / 2)
            command = controller.compute_velocity(state_at(pose, cycle * PERIOD), Cancellation())
        assert command.velocity.x == pytest.approx(expected, rel=0.15)
        assert command.velocity.yaw == pytest.approx(command.velocity.x / 2, rel=0.15)


def state_at(pose, time=0.0):
    return RobotState(time, pose, STOP)


def following(poses, **parameters):
    controller = make_controller(MapWithCosts(PLANE), TYPE, parameters)
    controller.set_plan(ControllerPlan(np.array(poses, np.float64)))
    return controller


LINE = [[x, 5, 0, 0, 0, 0, 1] for x in np.arange(2.0, 8.1, 0.5)]


@pytest.mark.parametrize(
    "place, outcome",
    [
        ([5, 6.5, 0], ExePathOutcome.MISSED_PATH),
        ([5, 5, 1.0], ExePathOutcome.OUT_OF_MAP),
        ([5, -3, 0], ExePathOutcome.OUT_OF_MAP),
    ],
)
def test_a_robot_that_is_elsewhere(place, outcome):
    controller = following(LINE)
    state = state_at(Pose.at(place))
    assert not controller.is_goal_reached(state, 0.1, 0.1)
    with pytest.raises(ControlFailure) as failed:
        controller.compute_velocity(state, Cancellation())
    assert failed.value.outcome == outcome


def test_after_a_failure_it_starts_from_rest():
    controller = following(LINE)
    for cycle in range(10):
        on = controller.compute_velocity(
            state_at(Pose.at([4, 5, 0]), cycle * PERIOD), Cancellation()
        )
    assert on.velocity.x > 0.4
    with pytest.raises(ControlFailure):
        controller.compute_velocity(state_at(Pose.at([5, 8, 0]), 0.5), Cancellation())
    again = controller.compute_velocity(state_at(Pose.at([4, 5, 0]), 0.55), Cancellation())
    assert 0.0 < again.velocity.x <= 1.0 * PERIOD + 1e-9


def test_without_a_plan_or_with_a_wrong_one():
    controller = make_controller(MapWithCosts(PLANE), TYPE)
    with pytest.raises(ControlFailure) as failed:
        controller.compute_velocity(state_at(Pose.at([5, 5, 0])), Cancellation())
    assert failed.value.outcome == ExePathOutcome.NOT_INITIALIZED
    with pytest.raises(ControlFailure, match="pose 13 of 14 of the path") as failed:
        controller.set_plan(ControllerPlan(np.array(LINE + [[99, 5, 0, 0, 0, 0, 1]], float)))
    assert failed.value.outcome == ExePathOutcome.INVALID_PATH


def test_a_loop_is_driven_before_it_has_arrived():
    turns = np.linspace(0, 2 * math.pi, 60)
    loop = [[5 + 2 * math.cos(t), 5 + 2 * math.sin(t), 0, 0, 0, 0, 1] for t in turns]
    controller = following(loop)
    here = state_at(Pose.at([7, 5, 0], 0.0))
    assert not controller.is_goal_reached(here, 0.1, 3.2)
    assert controller.compute_velocity(here, Cancellation()).velocity.yaw > 0.0


def test_a_cancel_ends_the_drive():
    start, goal = Pose.at([1, 1, 0], 0.7), Pose.at([8, 8, 0])
    went = drive(MapWithCosts(PLANE), STRAIGHT, TYPE, start=start, goal=goal, max_time=3.0)
    assert went.result.outcome == ExePathOutcome.CANCELED
    assert went.cycles[-1].velocity == STOP


def test_parameters_count_at_once():
    mesh_map = MapWithCosts(PLANE)
    controller = make_controller(mesh_map, TYPE)  # a copy of it drives, with the same values

    def slow_down(time, robot):
        if time >= 4.0:
            controller.set_parameters({"max_lin_velocity": 0.3})

    start, goal = Pose.at([1, 1, 0], 0.7), Pose.at([8, 8, 0], 0.7)
    went = drive(mesh_map, STRAIGHT, controller, start=start, goal=goal, on_step=slow_down)
    check_arrived(went)
    assert went.commands[(went.times > 2.0) & (went.times < 4.0), 0].min() > 0.7
    assert went.commands[went.times > 4.0 + 0.6, 0].max() <= 0.3 + 1e-9
    complaints = controller.set_parameters({"max_lin_velocity": 99.0, "turn_angle": "wide"})
    assert len(complaints) == 2 and controller.values["max_lin_velocity"] == 5.0


def test_it_is_found_as_a_plugin():
    found = find_class("mesh_navigation", "mesh_navigation::MeshController", TYPE)
    assert found is PurePursuitController
