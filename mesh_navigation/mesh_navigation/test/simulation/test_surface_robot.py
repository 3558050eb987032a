"""The robot on a mesh: exact where there is a formula, and nowhere off the surface."""

import math

import numpy as np
import pytest

from mesh_map.base.errors import MeshMapError
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.simulation.surface_robot import SurfaceRobot
from mesh_navigation.simulation.wheels import BaseLimits, Wheels

PLANE = MeshMap(zoo.grid().vertices, zoo.grid().faces)  # 10 m x 10 m
AT_ONCE = BaseLimits(math.inf, math.inf, math.inf, math.inf, math.inf)
X, Z = np.eye(3)[[0, 2]]


def robot_at(position, yaw=0.0, surface=PLANE, limits=AT_ONCE, **others):
    return SurfaceRobot(surface, Pose.at(position, yaw), limits=limits, **others)


def corner(flipped=()):
    """A floor 10 m x 10 m, from y = 0 to 10, and a wall upright at x = 10, 10 m high."""
    floor = zoo.grid()
    turned = floor.vertices[:, [2, 1, 0]] + np.float32([10, 0, 0])
    vertices = np.concatenate([floor.vertices, turned])
    shared = np.arange(len(vertices))
    for index in range(len(floor.vertices), len(vertices)):
        same = np.flatnonzero((floor.vertices == vertices[index]).all(axis=1))
        shared[index] = same[0] if len(same) else index
    faces = shared[np.concatenate([floor.faces, floor.faces + len(floor.vertices)])]
    faces[list(flipped)] = faces[list(flipped)][:, ::-1]
    return MeshMap(vertices, faces)


@pytest.mark.parametrize("seconds", [0.001, 0.013, 0.1, 1.0, 7.0])
@pytest.mark.parametrize("yaw", [0.0, 0.3, 2.0, -3.0])
def test_straight_on(seconds, yaw):
    robot = robot_at((5, 5, 0), yaw)
    robot.step(Velocity(0.4), seconds)
    way = 0.4 * seconds
    assert robot.pose.position == pytest.approx(
        [5 + way * math.cos(yaw), 5 + way * math.sin(yaw), 0], abs=1e-9
    )
    assert robot.pose.heading == pytest.approx([math.cos(yaw), math.sin(yaw), 0], abs=1e-9)
    assert robot.odometry.position == pytest.approx([way, 0, 0], abs=1e-9)
    assert robot.odometry.heading == pytest.approx(X, abs=1e-9)
    assert robot.driven == pytest.approx(way)


@pytest.mark.parametrize("velocity", [(1, 0, 0.5), (-1, 0, 0.5), (0.7, 0, -1), (0.4, 0.3, 0.5)])
@pytest.mark.parametrize("step", [0.01, 0.05, 0.31])
def test_arcs_are_exact_whatever_the_steps(velocity, step):
    robot = robot_at((5, 5, 0), 0.7)
    x, y, turn = velocity
    for index in range(1, 60):
        robot.step(Velocity(*velocity), step)
        angle = turn * index * step
        # The integral of the velocity turned by the heading.
        along = np.array([math.sin(angle), 1 - math.cos(angle)]) / turn
        own = np.array([x * along[0] - y * along[1], x * along[1] + y * along[0]])
        turned = np.array([[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)]]) @ own
        assert robot.pose.position[:2] - 5 == pytest.approx(turned, abs=1e-9)
        assert robot.odometry.position[:2] == pytest.approx(own, abs=1e-9)


def test_a_circle_closes():
    robot = robot_at((5, 5, 0))
    for _ in range(400):
        robot.step(Velocity(1.0, 0, math.pi / 2), 0.01)
    assert robot.pose.position == pytest.approx([5, 5, 0], abs=1e-9)
    assert robot.pose.heading == pytest.approx(X, abs=1e-9)
    assert robot.driven == pytest.approx(4.0, rel=1e-4)  # chords


def test_turning_on_the_spot():
    robot = robot_at((5, 5, 0))
    robot.step(Velocity(yaw=1.0), 3.0)
    assert robot.pose.position.tolist() == [5, 5, 0]
    assert robot.pose.heading == pytest.approx([math.cos(3), math.sin(3), 0], abs=1e-12)
    assert robot.driven == 0


def test_accelerations_take_time_and_way():
    robot = robot_at((1, 5, 0), limits=BaseLimits(1.0, 0.0, 1.0, acceleration=2.0))
    robot.step(Velocity(5.0), 2.0)  # 0.5 s until 1 m/s: 0.25 m, then 1.5 m
    assert robot.pose.position[0] == pytest.approx(1 + 1.75, abs=1e-9)
    assert robot.velocity == Velocity(1.0)
    robot.step(STOP, 1.0)
    assert robot.pose.position[0] == pytest.approx(1 + 2.0, abs=1e-9)
    assert robot.velocity == STOP


@pytest.mark.parametrize(
    "start, command, seconds, mean, end",
    [
        (0.0, 1.0, 1.5, (0.25 + 1.0) / 1.5, 1.0),  # 0.5 s, 0.25 m, until it is there
        (0.5, 1.0, 1.0, (0.1875 + 0.75) / 1.0, 1.0),
        (1.0, -1.0, 2.0, -1.0 / 2.0, -1.0),  # braking, then back: 1 s in all
        (1.0, 0.0, 0.25, 0.75, 0.5),  # not yet
        (0.5, 0.5, 9.0, 0.5, 0.5),
    ],
)
def test_ramps_of_the_velocity(start, command, seconds, mean, end):
    wheels = Wheels(BaseLimits(acceleration=2.0))
    wheels.velocity = Velocity(start)
    assert wheels.advance(Velocity(command), seconds).x == pytest.approx(mean)
    assert wheels.velocity.x == pytest.approx(end)


def test_nobody_stands_on_a_face_without_area():
    mesh = next(mesh for mesh in zoo.all_meshes() if mesh.name == "zero_area_face")
    surface = MeshMap(mesh.vertices, mesh.faces)
    (empty,) = np.flatnonzero(surface.faces_without_area)
    corners = mesh.vertices[mesh.faces[empty]].astype(np.float64)
    for point in [*corners, *(corners + np.roll(corners, 1, axis=0)) / 2, corners.mean(axis=0)]:
        for yaw in (0.1, 1.5, 3.0, 4.5):
            robot = robot_at(point, yaw, surface=surface)
            assert robot.place.face != empty
            robot.step(Velocity(1.0), 0.01)
            assert robot.obstruction in ("", "the surface ends here")


def test_what_is_not_finite_stops_wheels():
    wheels = Wheels(AT_ONCE)
    wheels.advance(Velocity(1.0, 0, 1.0), 1.0)
    assert wheels.advance(Velocity(math.nan, 0, 1.0), 1.0) == STOP


def test_limits_hold_on_both_sides():
    wheels = Wheels(BaseLimits(1.0, 0.5, 2.0, math.inf, math.inf))
    for sign in (1, -1):
        fast = Velocity(9.0 * sign, 9.0 * sign, 9.0 * sign)
        assert wheels.advance(fast, 0.1) == Velocity(sign, 0.5 * sign, 2.0 * sign)


@pytest.mark.parametrize("limit", BaseLimits._fields)
@pytest.mark.parametrize("value", [-1.0, math.nan])
def test_impossible_limits_are_refused(limit, value):
    with pytest.raises(ValueError, match=f"^{limit} of a base is {value}"):
        Wheels(BaseLimits()._replace(**{limit: value}))


@pytest.mark.parametrize("yaw", np.linspace(-3, 3, 13))
def test_the_border_stops_the_robot(yaw):
    robot = robot_at((5, 5, 0), yaw)
    robot.step(Velocity(2.0), 10.0)
    x, y, _ = robot.pose.position
    assert max(abs(x - 5), abs(y - 5)) == pytest.approx(5, abs=1e-6)
    assert (robot.velocity, robot.obstruction) == (STOP, "the surface ends here")
    back = robot.pose.position
    robot.step(Velocity(-1.0), 1.0)
    assert np.linalg.norm(robot.pose.position - back) == pytest.approx(1, abs=1e-6)
    assert robot.obstruction == ""
    # Wheels stand still while it is stopped: the odometry agrees.
    assert np.linalg.norm(robot.odometry.position) == pytest.approx(
        np.linalg.norm(robot.pose.position - 5 * (1 - Z)), abs=1e-6
    )


@pytest.mark.parametrize("flipped", [(), range(0, 400, 2), range(200)])
def test_a_wall_is_climbed_or_stops_the_robot(flipped):
    surface = corner(flipped)
    robot = robot_at((7, 4.2, 0), surface=surface)
    robot.step(Velocity(1.0), 5.0)
    assert robot.pose.position == pytest.approx([10, 4.2, 2], abs=1e-6)
    assert robot.pose.heading == pytest.approx(Z, abs=1e-9)
    assert robot.odometry.position == pytest.approx([3, 0, 2], abs=1e-6)
    robot.step(Velocity(-1.0), 4.0)
    assert robot.pose.position == pytest.approx([8, 4.2, 0], abs=1e-6)
    robot = robot_at((7, 4.2, 0), surface=surface, max_slope=1.0)
    robot.step(Velocity(1.0), 5.0)
    assert robot.pose.position == pytest.approx([10, 4.2, 0], abs=1e-6)
    assert (robot.velocity, robot.obstruction) == (STOP, "the surface is too steep here")


def kerb(height, tilt=0.0):
    """Two floors at y from 0 to 10, with a step up at x = 5, its side tilted by so much (m)."""
    x = np.float32([0, 5, 5 + tilt, 10])
    z = np.float32([0, 0, height, height])
    vertices = [(x[i], y, z[i]) for y in (0, 10) for i in range(4)]
    faces = [face for i in range(3) for face in ((i, i + 1, i + 5), (i, i + 5, i + 4))]
    return MeshMap(np.float32(vertices), np.array(faces))


@pytest.mark.parametrize("yaw", [0.0, 0.6, -0.6])
@pytest.mark.parametrize(
    "height, tilt, passes", [(0.15, 0, True), (0.15, 0.05, True), (0.3, 0, False)]
)
def test_small_steps_are_climbed_both_ways(height, tilt, passes, yaw):
    surface = kerb(height, tilt)
    for begin, heading, speed in ((4.0, yaw, 1.0), (6.0, yaw, -1.0), (6.0, yaw + math.pi, 1.0)):
        z = 0.0 if begin < 5 else height
        robot = robot_at((begin, 5, z), heading, surface=surface, max_slope=1.0, max_step=0.2)
        robot.step(Velocity(speed), 2.0)
        assert (abs(robot.pose.position[2] - z) > 0.1) == passes
        if not passes:
            assert robot.obstruction == "the surface is too steep here"
            assert robot.pose.position[0] == pytest.approx(5, abs=1e-6)
        else:
            assert robot.driven == pytest.approx(2, abs=1e-6)


def test_a_steep_side_of_a_hill_is_no_step():
    surface = kerb(4.0, 1.0)
    robot = robot_at((4.0, 5, 0), surface=surface, max_slope=1.0, max_step=0.2)
    robot.step(Velocity(1.0), 3.0)
    assert robot.pose.position == pytest.approx([5, 5, 0], abs=1e-6)


def test_robots_stay_on_a_sphere_and_come_round_it():
    sphere = zoo.sphere()
    surface = MeshMap(sphere.vertices, sphere.faces)
    radius = float(np.linalg.norm(sphere.vertices[0]))
    robot = robot_at((0.01, 0.02, radius), surface=surface)
    begin, heading = robot.pose.position, robot.pose.heading
    least = math.inf
    for index in range(1000):
        robot.step(Velocity(1.0), 2 * math.pi * radius / 1000)
        found = surface.closest_face(robot.pose.position, 1.0)
        assert found.distance < 1e-9
        assert robot.pose.heading @ robot.place.normal == pytest.approx(0, abs=1e-9)
        if index > 800:
            least = min(least, np.linalg.norm(robot.pose.position - begin))
    assert least < 0.1 * radius
    assert robot.pose.heading @ heading > 0.9


@pytest.mark.parametrize(
    "mesh", [m for m in zoo.all_meshes() if len(m.faces)], ids=lambda m: m.name
)
def test_random_drives_stay_on_any_mesh(mesh):
    surface = MeshMap(mesh.vertices, mesh.faces)
    random = np.random.default_rng(1)
    face = int(np.argmin(surface.faces_without_area))
    middle = mesh.vertices[mesh.faces[face]].astype(np.float64).mean(axis=0)
    robot = robot_at(middle, surface=surface, noise=0.1, slip=0.2, odometry_noise=0.1)
    for x, y, turn in random.normal(size=(200, 3)):
        robot.step(Velocity(x, y, turn), 0.3)
        assert surface.closest_face(robot.pose.position, math.inf).distance < 1e-5
        assert np.linalg.norm(robot.pose.orientation) == pytest.approx(1, abs=1e-9)
        assert np.isfinite(np.concatenate(robot.odometry)).all()


def test_mirrored_worlds_make_mirrored_drives():
    mesh = zoo.jittered_plane()
    left = MeshMap(mesh.vertices, mesh.faces)
    right = MeshMap(mesh.vertices * np.float32([1, -1, 1]), mesh.faces)
    middle = mesh.vertices.astype(np.float64).mean(axis=0)
    mirror = np.array([1, -1, 1])
    robots = robot_at(middle, 0.4, left), robot_at(middle * mirror, -0.4, right)
    for turn in (0.3, -0.8, 1.0, 0.1):
        for robot, sign in zip(robots, (1, -1)):
            robot.step(Velocity(0.5, 0, sign * turn), 0.5)
        assert robots[0].pose.position == pytest.approx(robots[1].pose.position * mirror, abs=1e-9)


@pytest.mark.parametrize("slip", [0.0, 0.25, 1.0])
def test_slip_is_lost_on_the_ground_and_counted_by_the_wheels(slip):
    robot = robot_at((5, 5, 0), slip=slip)
    robot.step(Velocity(1.0), 2.0)
    assert robot.pose.position[0] == pytest.approx(5 + 2 * (1 - slip), abs=1e-9)
    robot.step(Velocity(yaw=1.0), 1.0)
    assert robot.pose.heading == pytest.approx(
        [math.cos(1 - slip), math.sin(1 - slip), 0], abs=1e-9
    )
    assert robot.odometry.position == pytest.approx([2, 0, 0], abs=1e-9)
    assert robot.odometry.heading == pytest.approx([math.cos(1), math.sin(1), 0], abs=1e-9)


@pytest.mark.parametrize("drift", [0.009, -0.5])
@pytest.mark.parametrize("speed, step", [(0.5, 0.02), (-0.5, 0.013)])
def test_the_heading_of_the_odometry_drifts_with_each_meter(drift, speed, step):
    robot = robot_at((5, 5, 0), 0.3, odometry_yaw_drift=drift)
    robot.step(Velocity(yaw=1.0), 2.0)  # not by turning
    assert robot.odometry.heading == pytest.approx([math.cos(2.0), math.sin(2.0), 0], abs=1e-9)
    before, count = robot.odometry, round(4.0 / step)
    for _ in range(count):
        robot.step(Velocity(speed), step)
    way = abs(speed) * step * count
    turned = 2.0 + drift * way
    heading = robot.odometry.heading
    assert heading == pytest.approx([math.cos(turned), math.sin(turned), 0], abs=1e-9)
    # An arc of that length, of which the chord is known.
    chord = math.copysign(2 / abs(drift) * math.sin(abs(drift) * way / 2), speed)
    middle = 2.0 + drift * way / 2
    moved = robot.odometry.position - before.position
    assert moved == pytest.approx([chord * math.cos(middle), chord * math.sin(middle), 0], abs=1e-6)
    assert robot.pose.heading == pytest.approx([math.cos(2.3), math.sin(2.3), 0], abs=1e-9)


def test_slip_and_drift_change_while_it_drives():
    robot = robot_at((2, 5, 0))
    robot.step(Velocity(1.0), 1.0)
    robot.change_odometry(1.0, 0.0)
    robot.step(Velocity(1.0), 0.5)
    assert robot.pose.position == pytest.approx([3, 5, 0], abs=1e-9)
    robot.change_odometry(0.0, 0.1)
    robot.step(Velocity(1.0), 1.0)
    assert robot.pose.position == pytest.approx([4, 5, 0], abs=1e-9)
    assert robot.drift == pytest.approx(0.1)


def test_the_odometry_jumps_in_its_own_frame():
    robot = robot_at((5, 5, 0), 1.0)
    robot.step(Velocity(yaw=math.pi / 2), 1.0)
    truth = robot.pose
    robot.jump_odometry(0.5, -0.1, 0.2)
    assert robot.odometry.position == pytest.approx([0.1, 0.5, 0], abs=1e-9)
    turned = math.pi / 2 + 0.2
    heading = [math.cos(turned), math.sin(turned), 0]
    assert robot.odometry.heading == pytest.approx(heading, abs=1e-9)
    assert robot.pose.position.tolist() == truth.position.tolist()
    robot.step(Velocity(1.0), 1.0)  # and counts on from there
    expected = np.array([0.1, 0.5, 0]) + heading
    assert robot.odometry.position == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("noise", ["noise", "odometry_noise"])
@pytest.mark.parametrize("step", [0.02, 0.004])
def test_noise_adds_up_as_it_says_whatever_the_steps(noise, step):
    ways, turns = [], []
    for seed in range(60):
        robot = robot_at((2, 5, 0), seed=seed, **{noise: 0.05})
        for _ in range(round(1 / step)):
            robot.step(Velocity(1.0), step)
        pose, start = (robot.pose, 2) if noise == "noise" else (robot.odometry, 0)
        ways.append(pose.position[0] - start - 1)
        turns.append(math.atan2(pose.heading[1], pose.heading[0]))
        other = robot.odometry.position if noise == "noise" else robot.pose.position - [2, 5, 0]
        assert other == pytest.approx([1, 0, 0], abs=1e-6)
    assert np.std(ways) == pytest.approx(0.05, rel=0.3)
    assert np.std(turns) == pytest.approx(0.05, rel=0.3)


def test_the_same_seed_makes_the_same_drive():
    def track(seed):
        robot = robot_at((5, 5, 0), seed=seed, noise=0.1, slip=0.1, odometry_noise=0.1)
        poses = []
        for _ in range(50):
            robot.step(Velocity(1.0, 0, 1.0), 0.05)
            poses += [*robot.pose, *robot.odometry]
        return np.concatenate(poses).tolist()

    assert track(3) == track(3)
    assert track(3) != track(4)


def test_odometry_without_noise_is_the_truth_from_where_it_began():
    surface = corner()
    robot = robot_at((3, 3, 0), 1.0, surface)
    for turn in (0.3, -0.9, 0.4, 0.2):
        robot.step(Velocity(1.2, 0, turn), 2.0)
        back = Pose.at((0, 0, 0), -1.0).orientation
        assert robot.odometry.position == pytest.approx(
            rotate(back, robot.pose.position - [3, 3, 0]), abs=1e-6
        )
        assert robot.odometry.heading == pytest.approx(rotate(back, robot.pose.heading), abs=1e-6)


def test_put_elsewhere_it_stands_still_and_its_odometry_does_not_notice():
    robot = robot_at((3, 3, 0))
    robot.step(Velocity(1.0), 1.0)
    counted = robot.odometry
    robot.put(Pose.at((8, 8, 0.9), 2.0))
    assert robot.pose.position == pytest.approx([8, 8, 0])
    assert robot.velocity == STOP
    assert robot.odometry.position == pytest.approx(counted.position)


def test_any_attitude_of_a_pose_shows_where_it_looks():
    # A pose that was picked on a surface wound upside down: z down, x ahead.
    upside_down = Pose(np.array([5.0, 5.0, 0.1]), np.array([1.0, 0.0, 0.0, 0.0]))
    robot = SurfaceRobot(PLANE, upside_down)
    assert robot.pose.heading == pytest.approx(X, abs=1e-12)
    assert robot.place.normal == pytest.approx(Z, abs=1e-12)
    # Looking straight at the ground: any heading is right, none is not.
    down = Pose(np.array([5.0, 5.0, 0.0]), np.array([0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)]))
    assert np.linalg.norm(SurfaceRobot(PLANE, down).pose.heading[:2]) == pytest.approx(1)


@pytest.mark.parametrize(
    "pose, text",
    [
        (Pose.at((5, 5, 3)), r"no surface within 1\.00 m of \(5\.00, 5\.00, 3\.00\)"),
        (Pose.at((math.nan, 5, 0)), "no pose for a robot: position .* is not finite"),
        (Pose(np.zeros(3), np.zeros(4)), "no pose for a robot: orientation .* is no rotation"),
    ],
)
def test_what_is_no_place_is_refused(pose, text):
    with pytest.raises(MeshMapError, match=text):
        SurfaceRobot(PLANE, pose)
    robot = robot_at((5, 5, 0))
    with pytest.raises(MeshMapError, match=text):
        robot.put(pose)
    assert robot.pose.position.tolist() == [5, 5, 0]


def test_an_impossible_drift_is_refused():
    with pytest.raises(ValueError, match="drift of an odometry is nan"):
        robot_at((5, 5, 0), odometry_yaw_drift=math.nan)


@pytest.mark.parametrize("slip", [-0.1, 1.1, math.nan])
def test_impossible_slip_and_noise_are_refused(slip):
    with pytest.raises(ValueError, match="slip of a robot is"):
        robot_at((5, 5, 0), slip=slip)
    with pytest.raises(ValueError, match="noise of motions is"):
        robot_at((5, 5, 0), noise=-slip if slip > 0 else slip)


def test_obstacles_stop_it_but_hold_nobody():
    robot = robot_at((5, 5, 0))
    robot.is_free = lambda position: not 6 < position[0] < 7
    robot.step(Velocity(1.0), 3.0)
    assert 5.9 < robot.pose.position[0] <= 6
    assert (robot.velocity, robot.obstruction) == (STOP, "an obstacle is in the way")
    assert robot.odometry.position[0] == pytest.approx(robot.pose.position[0] - 5, abs=1e-9)
    robot.put(Pose.at((6.5, 5, 0)))  # an obstacle falls on it
    robot.step(Velocity(1.0), 1.0)
    assert robot.pose.position[0] == pytest.approx(7.5)
