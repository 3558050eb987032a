"""What the parameters of sensors and of the guard do: what passes, what stops, and when."""
from pathlib import Path
from typing import List, Sequence, Tuple

import numpy as np
from mesh_map.layers.obstacles import find_obstacles
from mesh_map.spatial.hits import NO_FACE
from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.velocity_guard.collision_zone import CollisionZone
from mesh_navigation.velocity_guard.velocity_bounds import VelocityLimits
from mesh_navigation.velocity_guard.velocity_guard import Moment, VelocityGuard
from mesh_msgs.world.solids import floor
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_tools_test.tutorials.panels import (
    BLUE,
    CLOSED,
    ORANGE,
    Chart,
    Panels,
    area_key,
    dot_key,
    line_key,
)

_TICK = 0.02  # s
_RADIUS, _BOX = 0.4, (0.4, 1.0, -0.5, 0.5, 0.1, 1.2)  # m: x, y, z of the zone, least and greatest
_SENSOR = np.array([0.0, 0.0, 0.8])  # m


def all_pictures(folder: Path) -> None:
    """Write them into a folder."""
    _limits(folder / "guard_limits.png")
    _silence(folder / "guard_silence.png")
    _zone(folder / "guard_zone.png")
    _obstacles(folder / "obstacle_heights.png")


def passed(
    limits: VelocityLimits, frequency: float, wanted: Sequence[Tuple[float, float]], end: float
) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What the guard makes of the commands of a controller.

    :param wanted: from when on (s) which speed (m/s) is commanded; NaN: nothing is
    :returns: times (s) of commands and their speeds; times of what is sent to the base, and speeds
    """
    guard = VelocityGuard(limits, Moment(1.0, 1.0))
    times, speeds, sent_times, sent = [], [], [0.0], [0.0]
    period = 1.0 / frequency
    next_command = 0.0
    for number in range(round(end / _TICK) + 1):
        time = number * _TICK
        now = Moment(1.0 + time, 1.0 + time)
        answer = guard.tick(now)
        if time >= next_command - 1e-9:
            next_command += period
            speed = [value for begin, value in wanted if begin <= time + 1e-9][-1]
            if not np.isnan(speed):
                velocity = Velocity(x=speed) if speed else STOP
                answer = guard.command(1, velocity, period, now)
                times.append(time)
                speeds.append(speed)
        if answer is not None:
            sent_times.append(time)
            sent.append(answer.x)
    return tuple(np.array(each) for each in (times, speeds, [*sent_times, end], [*sent, sent[-1]]))


def _draw_speeds(axes, found) -> None:
    times, speeds, sent_times, sent = found
    axes.plot(times, speeds, "o", color=ORANGE, markersize=3)
    axes.step(sent_times, sent, where="post", color=BLUE, linewidth=2)


def _speed_chart(titles: Sequence[str], end: float, highest: float) -> Chart:
    chart = Chart(titles, (0.0, end), (-0.05, highest))
    chart.name_axes("time [s]", "speed [m/s]")
    keys = [dot_key(ORANGE, "commands of the controller"), line_key(BLUE, "what the base gets")]
    chart.key(keys)
    return chart


def _limits(path: Path) -> None:
    """Of one command for a while, and then a stop."""
    each = (
        ("no limit reached", VelocityLimits(5.0, 5.0, 20.0, 50.0)),
        ("max_lin_velocity 0.8 m/s", VelocityLimits(0.8, 5.0, 20.0, 50.0)),
        ("max_lin_acceleration 1 m/s²", VelocityLimits(5.0, 5.0, 1.0, 50.0)),
    )
    chart = _speed_chart([title for title, _ in each], 2.4, 1.4)
    for axes, (_, limits) in zip(chart.axes, each):
        _draw_speeds(axes, passed(limits, 20.0, [(0.0, 0.0), (0.2, 1.2), (1.8, 0.0)], 2.4))
    chart.save(path)


def _silence(path: Path) -> None:
    """Of commands that end at a second, as when the server hangs."""
    frequencies = (20.0, 10.0, 5.0)
    titles = [f"controller_frequency {value:g} Hz" for value in frequencies]
    chart = _speed_chart(titles, 2.4, 0.8)
    for axes, frequency in zip(chart.axes, frequencies):
        limits = VelocityLimits(5.0, 5.0, 20.0, 50.0)
        found = passed(limits, frequency, [(0.0, 0.6), (1.0, np.nan)], 2.4)
        _draw_speeds(axes, found)
        last = found[0][-1]
        stop = found[2][np.flatnonzero(found[3] > 0)[-1] + 1]
        axes.axvspan(last, stop, color=CLOSED, alpha=0.35, linewidth=0)
        axes.annotate(f"{stop - last:.2f} s", ((last + stop) / 2, 0.68), ha="center", fontsize=9)
    chart.save(path)


def _zone(path: Path) -> None:
    """Clouds with more and more points in the box."""
    random = np.random.default_rng(3)
    far = random.uniform((1.1, -0.9, 0.2), (1.75, 0.9, 1.0), (12, 3))
    near = np.array([[0.85, 0.2, 0.5], [0.7, -0.25, 0.6], [0.9, -0.1, 0.4], [0.6, 0.35, 0.5]])
    panels = Panels(["0 points: drives", "2 points: drives", "3 points: stands"], (2.4, 2.0))
    for axes, count in zip(panels.axes, (0, 2, 3)):
        cloud = np.concatenate([far, near[:count]])
        zone = CollisionZone(_BOX, 3, 0.5)
        zone.see(cloud, 0.0)
        stops = bool(zone.obstruction(0.0))
        if stops != (count >= 3):
            raise RuntimeError(f"{count} points in the zone: {zone.obstruction(0.0)}")
        _draw_zone(axes, cloud, ORANGE if stops else BLUE)
    panels.name_axes("x, ahead [m]", "y, to the left [m]")
    box = area_key(BLUE, "zone_box [0.4, 1.0, -0.5, 0.5, 0.1, 1.2], seen from above")
    box.set_alpha(0.3)
    panels.key([box, dot_key("black", "points of the cloud"), area_key(CLOSED, "robot")])
    panels.save(path)


def _draw_zone(axes, cloud: np.ndarray, color) -> None:
    low_x, high_x, low_y, high_y = _BOX[:4]
    axes.fill(
        [low_x, high_x, high_x, low_x], [low_y, low_y, high_y, high_y], color=color, alpha=0.3
    )
    angle = np.linspace(0.0, 2 * np.pi, 60)
    axes.fill(_RADIUS * np.cos(angle), _RADIUS * np.sin(angle), color=CLOSED)
    axes.annotate("", (0.35, 0), (0, 0), arrowprops={"arrowstyle": "->", "lw": 2})
    axes.plot(cloud[:, 0], cloud[:, 1], "o", color="black", markersize=5)
    axes.set_xlim(-0.6, 1.8)
    axes.set_ylim(-1.0, 1.0)


def _obstacles(path: Path) -> None:
    """Points at all heights and distances, from the side: which of them are obstacles."""
    x, z = np.meshgrid(np.arange(0.4, 9.9, 0.45), np.arange(0.05, 1.6, 0.17), indexing="ij")
    points = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    ground = SpatialIndex(*_ground(), device="off")
    each: List[Tuple[str, Tuple[float, float, float]]] = [
        ("min_obstacle_height 0.1, robot_height 1.2, max_obstacle_dist 8 m", (0.1, 1.2, 8.0)),
        ("min_obstacle_height 0.25, robot_height 1.2, max_obstacle_dist 8 m", (0.25, 1.2, 8.0)),
        ("min_obstacle_height 0.25, robot_height 0.6, max_obstacle_dist 4 m", (0.25, 0.6, 4.0)),
    ]
    panels = Panels([title for title, _ in each], (10.0, 2.2), stacked=True)
    for axes, (_, (lowest, highest, farthest)) in zip(panels.axes, each):
        found = find_obstacles(
            ground,
            points,
            _SENSOR,
            (0.0, 0.0, -1.0),
            farthest=farthest,
            lowest=lowest,
            highest=highest,
        )
        stands = found.faces != NO_FACE
        others = ~stands & ~found.ground
        axes.plot(x.ravel()[stands], z.ravel()[stands], "s", color=ORANGE, markersize=5)
        axes.plot(x.ravel()[others], z.ravel()[others], "x", color="0.6", markersize=4)
        axes.plot(x.ravel()[found.ground], z.ravel()[found.ground], "o", color=BLUE, markersize=4)
        axes.plot(_SENSOR[0], _SENSOR[2], "k>", markersize=10)
        axes.axhline(0.0, color="black", linewidth=1.2)
        axes.set_xlim(-0.2, 9.8)
        axes.set_ylim(-0.1, 2.1)
    panels.name_axes("distance [m]", "height [m]")
    panels.key(
        [
            dot_key(ORANGE, "obstacle", "s"),
            dot_key(BLUE, "ground"),
            dot_key("0.6", "does not matter", "x"),
            dot_key("black", "sensor", ">"),
        ]
    )
    panels.save(path)


def _ground() -> Tuple[np.ndarray, np.ndarray]:
    vertices, faces = floor((-1.0, -1.0), (11.0, 1.0), 0.5)
    return vertices.astype(np.float32), faces.astype(np.uint32)
