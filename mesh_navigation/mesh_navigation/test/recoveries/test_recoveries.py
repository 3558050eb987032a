"""The recovery behaviors, with a simulated robot and clock."""

import numpy as np
import pytest
from navigation_test_maps import MapWithCosts, vertex_at

from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import RecoveryOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, NotLocalized, RobotLost, Velocity
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.plugins.plugin_list import BEHAVIORS, PluginList, find_plugin
from mesh_navigation.recoveries.back_up import BackUp
from mesh_navigation.recoveries.clear_layers import ClearLayers
from mesh_navigation.recoveries.wait import Wait
from mesh_navigation.simulation.simulated_robot import SimulatedClock, SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot

GRID = zoo.grid(cells=40, size=10.0)


def behavior(cls, mesh_map, **parameters):
    made = cls()
    assert made.initialize("behavior", mesh_map, parameters) == []
    return made


class Scene:
    """A robot on a map, and a clock that lets it drive."""

    def __init__(self, mesh=GRID, costs=None, pose=Pose.at((5, 5, 0)), seed=0, **noise):
        self.map = MapWithCosts(mesh, costs)
        self.robot = SimulatedRobot(SurfaceRobot(self.map.geometry, pose, seed=seed, **noise))
        self.track, self.commands, self.each = [], [], lambda time: None
        self.clock = SimulatedClock(self.robot, self._on_step, step=0.05)
        self.cancellation = Cancellation()

    def _on_step(self, time):
        self.track.append(self.robot.body.pose.position.copy())
        self.commands.append(self.robot.last_command)
        self.each(time)

    def drive(self, seconds, x=0.5, yaw=0.0):
        """As a controller would: the trail is noted."""
        end = self.clock.now() + seconds
        while self.clock.now() < end - 1e-9:
            self.robot.trail.add(self.robot.state().pose)
            self.robot.drive(Velocity(x, 0.0, yaw))
            self.clock.wait_until(self.clock.now() + 0.05, self.cancellation)
        self.robot.drive(STOP)
        self.clock.wait_until(self.clock.now() + 1.0, self.cancellation)
        self.robot.trail.add(self.robot.state().pose)
        self.track, self.commands = [], []

    def back_up(self, **parameters):
        made = behavior(BackUp, self.map, **parameters)
        return made.run(self.robot, self.clock, self.cancellation)

    @property
    def position(self):
        return self.robot.body.pose.position


def way_length(track):
    return float(np.linalg.norm(np.diff(track, axis=0), axis=1).sum())


def test_they_are_found_as_plugins():
    plugins = PluginList(BEHAVIORS)
    assert plugins.names == ["clear_layers", "wait", "back_up"] and not plugins.complaints
    for name, cls in (("ClearLayers", ClearLayers), ("Wait", Wait), ("BackUp", BackUp)):
        assert type(find_plugin(BEHAVIORS, f"mesh_recovery/{name}")) is cls


# ClearLayers


def map_with_obstacle():
    mesh_map = MeshMap(GRID.vertices, GRID.faces)
    names = ("seen", "heard")
    mesh_map.compute_layers([{"name": n, "type": "mesh_layers/ObstacleLayer"} for n in names])
    for name in names:
        mesh_map.layers[name].insert_cloud(mesh_map, [[5, 5.1, 0.5]], (0, 0, 1), 0.0)
        mesh_map.refresh_layer(name)
    return mesh_map


def clear(mesh_map, **parameters):
    return behavior(ClearLayers, mesh_map, **parameters).run(None, None, Cancellation())


def test_obstacles_are_forgotten():
    mesh_map = map_with_obstacle()
    assert np.isinf(mesh_map.costs).sum() == 3
    assert clear(mesh_map, layers=["seen"]) == (0, "cleared: 1 in layer seen")
    assert np.isinf(mesh_map.costs).sum() == 3
    assert clear(mesh_map) == (0, "cleared: 0 in layer seen, 1 in layer heard")
    assert not mesh_map.costs.any()


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({"layers": ["steep"]}, "nothing can be cleared: no layer of this map forgets anything"),
        ({"layers": ["smelt"]}, "nothing was cleared: there is no layer smelt"),
        ({"layers": [5]}, "the parameter layers is no list of names but [5]"),
        ({}, "(asked: steep)"),
    ],
)
def test_what_cannot_be_cleared_is_a_failure(parameters, words):
    mesh_map = MeshMap(GRID.vertices, GRID.faces)
    mesh_map.compute_layers([{"name": "steep", "type": "mesh_layers/SteepnessLayer"}])
    result = clear(mesh_map, **parameters)
    assert result.outcome == RecoveryOutcome.FAILURE and words in result.message


# Wait


class ListedClock(Clock):
    """Waiting brings the next time of a list."""

    def __init__(self, *times):
        self._times, self.asked = list(times), []

    def now(self):
        return self._times[0]

    def wait_until(self, moment, cancellation):
        self.asked.append(moment)
        self._times.pop(0)


def test_waiting():
    scene = Scene()
    result = behavior(Wait, scene.map, seconds=3.0).run(None, scene.clock, Cancellation())
    assert result == (0, "waited for 3.0 s") and scene.clock.now() == pytest.approx(3.0)


def test_waiting_while_the_clock_is_set_back():
    """Time that was waited counts, also that before the clock was set back."""
    clock = ListedClock(100, 102, 7, 8, 20)
    result = behavior(Wait, Scene().map, seconds=5.0).run(None, clock, Cancellation())
    assert result.succeeded and clock.asked == [105, 105, 10, 10]


def test_waiting_is_canceled():
    scene = Scene()
    scene.each = lambda time: time > 1.0 and scene.cancellation.cancel("enough")
    result = behavior(Wait, scene.map).run(None, scene.clock, scene.cancellation)
    assert result == (151, "waiting stopped after 1.0 of 5.0 s: enough")


# BackUp


@pytest.mark.parametrize("yaw", [0.0, 0.4, -0.4])
def test_back_along_the_way_it_came(yaw):
    scene = Scene()
    scene.drive(6.0, yaw=yaw)
    trail = np.array([pose.position for pose in scene.robot.trail.back()])
    result = scene.back_up(distance=1.5)
    assert result == (0, "backed up by 1.49 m")
    track = np.array(scene.track)
    assert 1.45 < way_length(track) < 1.55
    assert np.linalg.norm(track[:, None] - trail, axis=2).min(axis=1).max() < 0.07
    assert scene.robot.last_command == STOP
    commands = np.array(scene.commands)
    assert (commands[:, 0] <= 0).all() and commands[:, 0].min() == pytest.approx(-0.2)
    assert np.abs(commands[:, 2]).max() <= 0.5
    assert np.diff(commands[:, 0]).min() >= -0.5 * 0.05 - 1e-9


def test_a_second_time_it_goes_on_from_there():
    scene = Scene()
    scene.drive(6.0, yaw=0.3)
    whole = way_length([pose.position for pose in scene.robot.trail.back()])
    for part in (1, 2):
        assert scene.back_up(distance=1.0).succeeded
        left = [pose.position for pose in scene.robot.trail.back()]
        assert way_length(left) == pytest.approx(whole - part, abs=0.1)
        assert np.linalg.norm(left[0] - scene.position) < 0.1
    # A new drive from here is what is gone back next, not the loop that was left.
    scene.drive(2.0, yaw=-0.6)
    trail = np.array([pose.position for pose in scene.robot.trail.back()])
    assert scene.back_up(distance=1.2).succeeded
    track = np.array(scene.track)
    assert np.linalg.norm(track[:, None] - trail, axis=2).min(axis=1).max() < 0.07
    assert way_length(track) < 1.3


def test_straight_back_without_a_trail():
    scene = Scene(pose=Pose.at((5, 5, 0), 0.7))
    assert scene.back_up().message == "backed up by 0.49 m"
    np.testing.assert_allclose(
        scene.position, [5 - 0.495 * np.cos(0.7), 5 - 0.495 * np.sin(0.7), 0], atol=0.01
    )


def test_straight_back_from_where_the_trail_ends():
    scene = Scene()
    scene.drive(1.0)
    assert scene.back_up(distance=2.0).succeeded
    np.testing.assert_allclose(scene.position, [3.5, 5, 0], atol=0.1)


def test_it_turns_first_where_the_way_is_beside_it():
    scene = Scene()
    scene.drive(4.0)
    scene.drive(2.6, x=0.0, yaw=0.5)
    assert abs(scene.robot.body.pose.heading[0]) < 0.5
    before = scene.position.copy()
    assert scene.back_up(distance=1.0).succeeded
    np.testing.assert_allclose(scene.position, before - [1.0, 0, 0], atol=0.08)


def test_straight_back_where_it_has_turned_round():
    """The trail is before it; it does not turn to back up along that."""
    scene = Scene()
    scene.drive(2.0)
    scene.drive(6.3, x=0.0, yaw=0.5)
    assert scene.robot.body.pose.heading[0] < -0.9
    assert scene.back_up().succeeded
    assert scene.position[0] > 6.4 and not np.array(scene.commands)[:, 2].any()


@pytest.mark.parametrize("value, word", [(np.inf, "lethal"), (np.nan, "unknown")])
def test_it_stops_before_blocked_ground(value, word):
    scene = Scene()
    scene.drive(6.0)
    scene.map.costs[GRID.vertices[:, 0] == 6.0] = value
    result = scene.back_up(distance=3.0)
    assert result.outcome == RecoveryOutcome.IMPASSABLE
    assert word in result.message and "0.20 m behind the robot" in result.message
    # Ground is blocked where the vertex at 6.0 is nearer than that at 6.25.
    assert 6.125 + 0.2 - 0.01 <= scene.position[0] < 6.125 + 0.2 + 0.06
    assert (np.array(scene.track)[:, 0] > 6.3).all()


def test_a_body_is_kept_off_what_is_beside_the_way_back(monkeypatch):
    """The middle would pass at 0.25 m from the post."""
    scene = Scene()
    monkeypatch.setattr(BackUp, "body", Body(scene.map.geometry, RobotShape(radius=0.4)))
    scene.drive(6.0)
    scene.map.costs[vertex_at(GRID, (6.0, 5.25, 0))] = np.inf
    result = scene.back_up(distance=3.0)
    assert result.outcome == RecoveryOutcome.IMPASSABLE
    assert "within 0.40 m of it" in result.message
    assert np.linalg.norm(np.array(scene.track)[:, :2] - (6.0, 5.25), axis=1).min() > 0.4


def test_it_stops_before_what_appears_behind_it():
    scene = Scene()
    scene.drive(6.0)

    def appear(time):
        if scene.position[0] < 7.0:
            scene.map.costs[vertex_at(GRID, (6.25, 5.0, 0))] = np.inf

    scene.each = appear
    assert scene.back_up(distance=3.0).outcome == RecoveryOutcome.IMPASSABLE
    assert 6.375 + 0.19 <= scene.position[0] < 7.0


def test_it_leaves_blocked_ground():
    scene = Scene()
    scene.drive(4.0)
    scene.map.costs[vertex_at(GRID, (7.0, 5.0, 0))] = np.inf
    assert abs(scene.position[0] - 7.0) < 0.1
    assert scene.back_up(distance=1.0).succeeded
    assert scene.position[0] < 6.1


def test_it_stays_where_all_is_blocked():
    scene = Scene(costs=np.full(len(GRID.vertices), np.inf))
    result = scene.back_up()
    assert result.outcome == RecoveryOutcome.IMPASSABLE and "0.00 m" in result.message
    np.testing.assert_allclose(scene.position, [5, 5, 0])


def test_it_stops_before_the_end_of_the_surface():
    scene = Scene(pose=Pose.at((0.7, 5, 0)))
    result = scene.back_up(distance=2.0)
    assert result.outcome == RecoveryOutcome.IMPASSABLE
    assert "the surface ends at (0.00, 5.00" in result.message
    assert 0.19 <= scene.position[0] < 0.26


def test_off_the_map_it_fails():
    scene = Scene()
    state = scene.robot.state()
    high = state._replace(pose=Pose.at((5, 5, 3)))
    scene.robot.state = lambda: high
    result = scene.back_up()
    assert result.outcome == RecoveryOutcome.FAILURE and "off the map" in result.message


def test_a_robot_that_does_not_obey():
    scene = Scene()
    scene.robot.advance = lambda seconds: setattr(scene.robot, "time", scene.robot.time + seconds)
    result = scene.back_up()
    assert result.outcome == RecoveryOutcome.FAILURE and "does not get on for 3 s" in result.message
    assert 3.0 < scene.clock.now() < 3.5


def test_a_robot_that_is_lost_stops():
    scene = Scene()
    scene.drive(2.0)

    def lose(time):
        if len(scene.track) > 10:
            scene.robot.state = lost

    def lost():
        raise RobotLost("no transform")

    scene.each = lose
    with pytest.raises(RobotLost, match="no transform"):
        scene.back_up()
    assert scene.robot.last_command == STOP


def test_a_robot_that_is_lost_for_a_while_goes_on():
    scene = Scene()
    scene.drive(2.0)
    scene.robot.lost_timeout = 5.0
    tell, gap = scene.robot.state, []

    def state():
        if 10 < len(scene.track) < 90:  # 4 s: longer than a robot may not get on
            gap.append(scene.robot.last_command)
            raise RobotLost("no transform")
        return tell()

    scene.robot.state = state
    result = scene.back_up()
    assert result.outcome == RecoveryOutcome.SUCCESS
    assert set(gap[2:]) == {STOP}


def test_a_robot_that_is_localized_elsewhere_does_not_go_back_to_its_trail():
    scene = Scene()
    scene.drive(4.0)
    tell, gap = scene.robot.state, []

    def state():
        if 10 < len(scene.track) < 400:  # 20 s: longer than for a transform
            if not gap:
                scene.robot.put(Pose.at((3.0, 5.3, 0.0)))  # aside of the trail, within its reach
                scene.robot.trail.clear()  # as the server does
            gap.append(scene.robot.last_command)
            raise NotLocalized("few rays are explained", 60.0)
        return tell()

    scene.robot.state = state
    result = scene.back_up(distance=1.0)
    assert result == (0, "backed up by 0.99 m")
    assert set(gap[2:]) == {STOP}
    after = np.array(scene.track[400:])
    assert np.ptp(after[:, 1]) < 1e-6 and 0.5 < np.ptp(after[:, 0]) < 1.0
    assert not scene.robot.trail.back()


def test_a_robot_that_is_not_localized_gives_up():
    scene = Scene()

    def state():
        raise NotLocalized("few rays are explained", 12.0)

    scene.robot.state = state
    with pytest.raises(NotLocalized, match="few rays"):
        scene.back_up()
    assert 12.0 <= scene.clock.now() < 12.2


def test_it_is_canceled():
    scene = Scene()
    scene.drive(4.0)
    scene.each = lambda time: len(scene.track) > 40 and scene.cancellation.cancel("enough")
    result = scene.back_up(distance=5.0)
    assert result.outcome == RecoveryOutcome.CANCELED
    assert result.message.startswith("backing up stopped after 0.") and "enough" in result.message
    assert scene.robot.last_command == STOP


def test_nothing_to_do():
    assert Scene().back_up(distance=0.0) == (0, "backed up by 0.00 m")


def hills():
    vertices = GRID.vertices.astype(np.float64)
    heights = 0.5 * np.sin(vertices[:, 0]) * np.cos(vertices[:, 1])
    return GRID._replace(vertices=np.float32(vertices + heights[:, None] * [0, 0, 1]))


@pytest.mark.parametrize("seed", range(4))
def test_on_hills_with_noise_and_slip(seed):
    random = np.random.default_rng(seed)
    pose = Pose.at((5, 5, 0), random.uniform(-3, 3))
    scene = Scene(hills(), pose=pose, seed=seed, slip=0.1, noise=0.05)
    scene.drive(6.0, yaw=random.uniform(-0.4, 0.4))
    trail = np.array([pose.position for pose in scene.robot.trail.back()])
    assert scene.back_up(distance=1.5).succeeded
    track = np.array(scene.track)
    assert np.linalg.norm(track[:, None] - trail, axis=2).min(axis=1).max() < 0.1
    back = int(np.argmin(np.linalg.norm(trail - track[-1], axis=1)))
    assert way_length(trail[: back + 1]) == pytest.approx(1.5, abs=0.1)
