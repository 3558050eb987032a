"""Robots exactly on a corner of the border leave it wherever the floor goes on, without ROS."""

import math

import numpy as np
import pytest

from controller_drives import command_at, following, planned
from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import Velocity
from mesh_navigation.simulation.driving import drive
from mesh_navigation.simulation.surface_robot import SurfaceRobot
from mesh_navigation.simulation.wheels import BaseLimits

HALF_SLIT, RINGS, FACES = math.radians(10), 8, 11
HEADINGS = np.linspace(HALF_SLIT, 2 * np.pi - HALF_SLIT, 15)[1:-1]  # 13 of them


def hill(slope, noise=0.1, seed=1):
    """A hill with a slit to its top: a corner of the border with 11 faces, which together have less
    than the 340 degrees that they fill as seen from above."""
    random = np.random.default_rng(seed)
    angles = np.linspace(HALF_SLIT, 2 * np.pi - HALF_SLIT, FACES + 1)
    ring = np.stack([np.cos(angles), np.sin(angles), random.normal(-slope, noise, FACES + 1)], 1)
    vertices = np.concatenate([[[0, 0, 0]]] + [0.5 * (1 + i) * ring for i in range(RINGS)])
    corner = np.arange(1, 1 + RINGS * (FACES + 1)).reshape(RINGS, FACES + 1)
    a, b = corner[0, :-1], corner[0, 1:]
    faces = [np.stack([np.zeros_like(a), a, b], 1)]
    for inner, outer in zip(corner, corner[1:]):
        a, b, c, d = inner[:-1], inner[1:], outer[:-1], outer[1:]
        faces += [np.stack([a, c, d], 1), np.stack([a, d, b], 1)]
    return MeshMap(vertices.astype(np.float32), np.concatenate(faces).astype(np.uint32))


HILLS = {
    "gentle": hill(0.1),
    "slope": hill(0.3),
    "steep": hill(0.6),
    "pit": hill(-0.5),
    "rough": hill(0.2, 0.3, 4),
}
every = pytest.mark.parametrize("name", HILLS)


def goal_at(mesh_map, angle):
    """2.5 m away as seen from above."""
    above = (2.5 * math.cos(angle), 2.5 * math.sin(angle), 9.0)
    return mesh_map.spatial_index.cast(origin=above, direction=(0, 0, -1)).position


@every
def test_the_robot_goes_where_the_floor_goes_on(name):
    mesh_map = HILLS[name]
    at_once = BaseLimits(*[math.inf] * 5)
    for angle in HEADINGS:
        robot = SurfaceRobot(mesh_map, Pose.at((0, 0, 0), angle), limits=at_once)
        robot.step(Velocity(0.5), 0.1)
        assert robot.obstruction == "" and robot.driven == pytest.approx(0.05)
        ahead = math.atan2(*robot.pose.position[1::-1])
        # not the yaw of the pose, but what of it is along the face
        assert abs((ahead - angle + math.pi) % (2 * math.pi) - math.pi) < 0.4


def is_over_floor(mesh_map, place):
    """Whether a face at the top lies where a robot there looks, as seen along its normal; None near
    the sides of the slit."""
    left = np.cross(place.normal, place.direction)
    seen = []
    for face in range(FACES):
        a, b = mesh_map.vertices[mesh_map.faces[face, 1:]].astype(np.float64)
        (ax, ay), (bx, by) = ((end @ place.direction, end @ left) for end in (a, b))
        begin, spread = math.atan2(ay, ax), math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        assert spread > 0.05  # none is folded
        past = -begin % (2 * math.pi)
        seen.append((0.01 < past < spread - 0.01, past < spread + 0.02 or past > 6.26))
    on = any(surely for surely, _ in seen)
    return on if on or not any(maybe for _, maybe in seen) else None


@every
@pytest.mark.parametrize("yaw", [0.3, 1.7, 3.1, 4.5, 5.9])
def test_turning_on_the_spot_it_finds_all_ways_off(name, yaw):
    mesh_map = HILLS[name]
    at_once = BaseLimits(*[math.inf] * 5)
    went = 0
    for turn in np.arange(26) * math.pi / 13:
        robot = SurfaceRobot(mesh_map, Pose.at((0, 0, 0), yaw), limits=at_once)
        robot.step(Velocity(yaw=turn), 1.0)
        goes_on = is_over_floor(mesh_map, robot.place)
        robot.step(Velocity(0.5), 0.02)
        if goes_on is not None:
            assert robot.driven == pytest.approx(0.01 if goes_on else 0.0)
            assert robot.obstruction == ("" if goes_on else "the surface ends here")
            went += goes_on
    assert went > 20


def test_into_the_slit_it_does_not_go():
    at_once = BaseLimits(*[math.inf] * 5)
    robot = SurfaceRobot(HILLS["gentle"], Pose.at((0, 0, 0), 0.0), limits=at_once)
    robot.step(Velocity(0.5), 0.1)
    assert robot.driven == 0 and robot.obstruction == "the surface ends here"
    robot.step(Velocity(-0.5), 0.1)
    assert robot.driven == pytest.approx(0.05)


@pytest.mark.parametrize("name", ["gentle", "slope", "steep", "pit"])  # elsewhere it turns first
def test_the_controller_drives_where_the_floor_goes_on(name):
    mesh_map = HILLS[name]
    for angle in HEADINGS:
        start = Pose.at((0, 0, 0), angle)
        plan = planned(mesh_map, start, Pose.at(goal_at(mesh_map, angle), angle))
        controller = following(mesh_map, plan)
        speeds = [command_at(controller, start, 0.05 * i).velocity.x for i in range(6)]
        assert min(speeds) > 0 and speeds == sorted(speeds) and speeds[-1] > 0.2


@pytest.mark.parametrize("yaw", [0.0, 2.0, 4.0])
@pytest.mark.parametrize("angle", [-0.3, -0.6, -1.4, 0.3, 1.4, 3.1])
def test_drives_from_the_corner_arrive(yaw, angle):
    mesh_map = HILLS["slope"]
    goal = Pose.at(goal_at(mesh_map, angle), 0.0)
    went = drive(mesh_map, start=Pose.at((0, 0, 0), yaw), goal=goal, max_time=100.0)
    assert went.arrived, went.result.message


def test_at_the_foot_of_a_wall_it_stands_on_the_floor():
    """Exactly on the edge, where the wall has the lower indices, and most headings do not run along
    the wall."""
    vertices = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [4, 0, 2], [4, 4, 2]]
    mesh_map = MeshMap(np.float32(vertices), [[1, 2, 5], [1, 5, 4], [0, 1, 2], [0, 2, 3]])
    for yaw in np.linspace(2.0, 4.2, 5):
        for foot in ([4, 1, 0], [4, 0, 0], [4, 4, 0]):
            if not 0 <= foot[1] + math.sin(yaw) <= 4:
                continue  # off the floor
            start = Pose.at(foot, yaw)
            robot = SurfaceRobot(mesh_map, start, limits=BaseLimits(*[math.inf] * 5))
            robot.step(Velocity(0.5), 0.1)
            along = 0.05 * np.array([math.cos(yaw), math.sin(yaw), 0.0])
            np.testing.assert_allclose(robot.pose.position, foot + along, atol=1e-9)
            goal = foot + 20 * along
            controller = following(mesh_map, planned(mesh_map, start, Pose.at(goal, yaw)))
            assert command_at(controller, start).velocity.x > 0
