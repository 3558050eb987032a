"""The mesh controller arrives, in position and heading, and never drives on blocked ground."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_navigation.base.pose import Pose
from mesh_navigation.simulation.driving import drive
from controller_drives import (
    check_commands,
    command_at,
    controller_on,
    planned,
    random_drives,
)
from navigation_test_maps import MapWithCosts


def lethal_spots(mesh, share, seed=1):
    rng = np.random.default_rng(seed)
    return np.where(rng.uniform(size=len(mesh.vertices)) < share, np.inf, 0.0)


PLANE = zoo.jittered_plane(cells=30)
WORLDS = {
    "grid": (zoo.grid(cells=25), None),
    "spots": (PLANE, lethal_spots(PLANE, 0.05)),
    "hole": (zoo.hole(), None),
    "storeys": (zoo.two_storeys(), None),
}


def check_arrived(went):
    assert went.arrived, went.result.message
    assert went.result.dist_to_goal <= 0.1
    assert went.result.angle_to_goal <= np.pi / 18 + 1e-6
    assert len(went.blocked) == 0
    assert went.driven_length <= 1.15 * went.planned_length + 0.3


@pytest.mark.parametrize("follow", ["field", "path"])
@pytest.mark.parametrize("name", WORLDS)
def test_random_goals_are_reached(name, follow):
    drives = list(random_drives(*WORLDS[name], 4, seed=7, given={"follow": follow}))
    assert len(drives) >= 3
    for went in drives:
        check_arrived(went)
        check_commands(went, controller_on(MapWithCosts(PLANE)).values, 0.05)


@pytest.mark.parametrize("tolerance", [0.05, 0.4])
def test_headings_are_met_better_than_they_have_to_be(tolerance):
    values = {"angle_tolerance": tolerance}
    for went in random_drives(*WORLDS["grid"], 4, seed=5, values=values):
        assert went.arrived and went.result.angle_to_goal <= tolerance / 2


def test_who_wants_no_heading_does_not_turn():
    start, goal = Pose.at([5.0, 5.0, 0.0]), Pose.at([9.0, 5.0, 0.0], yaw=np.pi / 2)
    values = {"angle_tolerance": 3.1415}
    mesh_map = MapWithCosts(WORLDS["grid"][0])
    controller = controller_on(mesh_map)
    went = drive(mesh_map, "wave_front", controller, start=start, goal=goal, values=values)
    assert went.arrived and went.result.angle_to_goal == pytest.approx(np.pi / 2, abs=0.05)


@pytest.mark.parametrize("frequency", [5.0, 50.0])
@pytest.mark.parametrize("factor", [1.0, 7.0, 10.0])
def test_any_factor_and_frequency_arrives(frequency, factor):
    given = {"ang_vel_factor": factor, "max_ang_velocity": 2.0}
    values = {"controller_frequency": frequency}
    for went in random_drives(*WORLDS["spots"], 1, seed=3, given=given, values=values):
        check_arrived(went)
        settings = controller_on(MapWithCosts(PLANE), **given).values
        check_commands(went, settings, 1.0 / frequency)


def test_noise_slip_and_pushes_are_recovered_from():
    mesh, costs = WORLDS["grid"]
    pushes = {3.0: (0.3, 0.0, 0.17), 5.0: (0.0, -0.3, -0.17)}

    def push(time, robot):
        for moment in [moment for moment in due if time >= moment]:
            x, y, turn = pushes[moment]
            pose = robot.body.pose
            yaw = np.arctan2(pose.heading[1], pose.heading[0]) + turn
            robot.put(Pose.at(np.clip(pose.position + [x, y, 0.0], [0, 0, 0], [10, 10, 0]), yaw))
            due.remove(moment)

    for follow in ("field", "path"):
        due = list(pushes)
        mesh_map = MapWithCosts(mesh, costs)
        went = drive(
            mesh_map,
            "wave_front",
            controller_on(mesh_map, follow=follow),
            start=Pose.at([2.0, 2.0, 0.0], 2.0),
            goal=Pose.at([8.0, 7.0, 0.0], -2.0),
            on_step=push,
            slip=0.1,
            noise=0.05,
            seed=4,
        )
        assert not due and went.arrived, went.result.message
        assert went.driven_length < went.planned_length + 2.0


def mirrored(mesh):
    return mesh._replace(vertices=mesh.vertices * np.float32([1, -1, 1]))


def flipped(mesh):
    return mesh._replace(faces=np.ascontiguousarray(mesh.faces[:, ::-1]))


@pytest.mark.parametrize("changed, sign", [(mirrored, -1.0), (flipped, 1.0)])
def test_mirrored_worlds_and_flipped_faces_change_nothing(changed, sign):
    drives = []
    for mesh, side in ((PLANE, 1.0), (changed(PLANE), sign)):
        mesh_map = MapWithCosts(mesh)
        drives.append(
            drive(
                mesh_map,
                "wave_front",
                controller_on(mesh_map),
                start=Pose.at([2.0, 2.0 * side, 0.0], 2.0 * side),
                goal=Pose.at([7.0, 6.0 * side, 0.0], -1.0 * side),
            )
        )
    first, second = drives
    assert first.arrived and len(first.times) == len(second.times)
    track = second.track[:, :3] * [1.0, sign, 1.0]
    assert np.abs(first.track[:, :3] - track).max() < 1e-3
    assert np.abs(first.commands[:, 2] - sign * second.commands[:, 2]).max() < 0.02


@pytest.mark.parametrize("side", [0.0, np.pi])
def test_a_robot_on_the_goal_only_turns(side):
    mesh_map = MapWithCosts(PLANE)
    place = np.array([4.0, 4.0, 0.0])
    went = drive(
        mesh_map,
        "wave_front",
        controller_on(mesh_map),
        start=Pose.at(place, 0.3),
        goal=Pose.at(place, 0.3 + side),
    )
    assert went.arrived and went.driven_length < 0.01
    assert (went.times[-1] > 5.0) == (side > 0.0)


def test_an_obstacle_that_appears_is_stopped_before():
    mesh = zoo.grid(cells=50)
    mesh_map = MapWithCosts(mesh)
    wall = (np.abs(mesh.vertices[:, 0] - 6.0) < 0.15).astype(bool)

    def drop(time, robot):
        if time > 2.0:
            mesh_map.costs = np.where(wall, np.float32(np.inf), np.float32(0))

    went = drive(
        mesh_map,
        "wave_front",
        controller_on(mesh_map),
        start=Pose.at([2.0, 5.1, 0.0]),
        goal=Pose.at([9.0, 5.1, 0.0]),
        on_step=drop,
    )
    assert not went.arrived and "BLOCKED_PATH" in went.result.message
    assert "blocked_distance" in went.result.message and len(went.blocked) == 0
    stands = went.track[-1, 0]
    assert 5.3 < stands < 5.75 and 0.2 < went.clearance < 0.6


def test_plans_of_all_planners_can_be_followed():
    for planner in ("dijkstra", "cvp", "exact"):
        for went in random_drives(*WORLDS["spots"], 2, seed=5, planner=planner):
            check_arrived(went)


def test_a_newer_plan_is_taken_while_it_drives():
    mesh, costs = WORLDS["grid"]
    for went in random_drives(mesh, costs, 1, seed=9, values={"planner_frequency": 2.0}):
        check_arrived(went)
        check_commands(went, controller_on(MapWithCosts(mesh)).values, 0.05)


def test_a_plan_on_another_storey_is_not_reached_from_below():
    mesh_map = MapWithCosts(zoo.two_storeys())
    plan = planned(mesh_map, Pose.at([6, 6, 0.1]), Pose.at([6, 6, 3.1]))
    went = drive(
        mesh_map,
        "wave_front",
        controller_on(mesh_map),
        start=Pose.at([6, 6, 0.1]),
        goal=Pose.at([6, 6, 3.1]),
    )
    check_arrived(went)
    assert went.track[-1, 2] == pytest.approx(3.0) and len(plan.poses) > 10


def test_a_plan_that_was_prepared_is_followed_as_any_other():
    mesh_map = MapWithCosts(PLANE)
    plan = planned(mesh_map, Pose.at([2.0, 2.0, 0.0]), Pose.at([7.0, 6.0, 0.0]))
    for field in (plan.field, None):  # None: it follows the path
        plain, other = controller_on(mesh_map), controller_on(mesh_map)
        plain.set_plan(plan._replace(field=field))
        newer = plan._replace(field=field)
        prepared = newer._replace(prepared=other.prepare_plan(newer))
        assert not hasattr(other, "_goal")  # it changes nothing
        other.set_plan(prepared)
        assert other._guide is prepared.prepared
        at = Pose.at([2.5, 2.1, 0.0], 0.5)
        assert command_at(plain, at) == command_at(other, at)
