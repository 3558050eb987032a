"""What the parameters of the controller do to a drive in simulated time: one picture for each."""
from pathlib import Path
from typing import Any, Dict, List, Sequence

from mesh_navigation.base.pose import Pose
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.planning import body_on, make_planner
from mesh_navigation.simulation.driving import Drive, drive, make_controller

from mesh_tools_test.tutorials.panels import (
    BLUE,
    ORANGE,
    THING,
    Chart,
    Panels,
    area_key,
    draw_boxes,
    draw_costs,
    draw_ends,
    draw_path,
    ends_key,
    lethal_key,
    line_key,
)
from mesh_tools_test.tutorials.parameter_worlds import Rectangle, Room, layer, room
from mesh_tools_test.tutorials.planner_pictures import COLLISION

RADIUS = 0.4  # m
_YARD = (8.0, 6.0)  # m
_WALLS: List[Rectangle] = [(2.4, 0.0, 2.6, 3.6), (5.2, 2.4, 5.4, 6.0)]
_FROM, _TO = Pose.at((1.0, 1.0, 0.0), 1.57), Pose.at((7.0, 5.0, 0.0), 1.57)
_LANE = (7.0, 1.6)  # m
_ALONG = Pose.at((0.6, 0.8, 0.0)), Pose.at((6.4, 0.8, 0.0))
_USUAL = {"max_lin_velocity": 0.6, "max_ang_velocity": 0.8, "max_lin_acceleration": 0.5}
_FREQUENCY = 10.0  # Hz


def all_pictures(folder: Path) -> None:
    """Write them into a folder."""
    yard, lane = room(_YARD, _WALLS, 0.2), room(_LANE, [], 0.2)
    inflation = {"inscribed_radius": RADIUS, "inflation_radius": 1.2, "repulsive_field": False}
    yard.mesh_map.compute_layers([COLLISION, layer("inflation", "Inflation", **inflation)])
    on_yard, on_lane = Drives(yard, _FROM, _TO), Drives(lane, *_ALONG)
    for name, values, unit in (
        ("lookahead_distance", (0.2, 0.6, 1.5), " m"),
        ("max_angle", (5.0, 20.0, 60.0), "°"),
    ):
        _tracks(folder / f"{name}.png", yard, on_yard, name, values, unit)
    for name, values, unit in (
        ("max_lin_velocity", (0.3, 0.6, 1.0), "m/s"),
        ("max_lin_acceleration", (0.2, 0.5, 2.0), "m/s²"),
        ("arrival_fading", (0.0, 0.5, 2.0), "m"),
    ):
        _speeds(folder / f"{name}.png", on_lane, name, values, unit)


class Drives:
    """Drives of a round robot from a start to a goal; each is driven once."""

    def __init__(self, where: Room, start: Pose, goal: Pose) -> None:
        mesh_map = where.mesh_map
        self._map, self._ends = mesh_map, {"start": start, "goal": goal}
        self._body = body_on(mesh_map, RobotShape(radius=RADIUS))
        self._planner = make_planner(mesh_map, "wave_front", {"cost_factor": 3.0}, self._body)
        self._known: Dict[Any, Drive] = {}

    def with_value(self, name: str, value: float) -> Drive:
        """That where a parameter of the controller has a value, and all others the usual one.

        :raises RuntimeError: the robot did not arrive
        """
        controller = make_controller(self._map, parameters={**_USUAL, name: value}, body=self._body)
        values = tuple(controller.values.items())
        if values not in self._known:
            frequency = {"controller_frequency": _FREQUENCY}
            went = drive(self._map, self._planner, controller, values=frequency, **self._ends)
            if not went.arrived:
                raise RuntimeError(f"{name} {value}: {went.result.message}")
            self._known[values] = went
        return self._known[values]


def _tracks(
    path: Path, yard: Room, on_yard: Drives, name: str, values: Sequence[float], unit: str
) -> None:
    drives = [on_yard.with_value(name, value) for value in values]
    titles = [f"{name} {v:g}{unit}: {went.times[-1]:.0f} s" for v, went in zip(values, drives)]
    panels, mesh_map = Panels(titles, _YARD), yard.mesh_map
    costs = mesh_map.planning_costs().costs
    for axes, went in zip(panels.axes, drives):
        draw_costs(axes, mesh_map.vertices, mesh_map.faces[yard.floor], costs, (0.0, 1.0))
        draw_boxes(axes, yard.walls)
        draw_path(axes, went.track, ORANGE)
        axes.plot(*went.plan.poses[:, :2].T, color="black", linewidth=1.2, zorder=6)
        draw_ends(axes, _FROM.position, _TO.position)
        axes.set_xlim(0, _YARD[0])
        axes.set_ylim(0, _YARD[1])
    panels.name_axes("x [m]", "y [m]")
    panels.scale((0.0, 1.0), "costs of all layers")
    handles = [lethal_key(), area_key(THING, "walls"), line_key("black", "plan")]
    panels.key([*handles, line_key(ORANGE, "track of the robot"), *ends_key()])
    panels.save(path)


def _speeds(path: Path, on_lane: Drives, name: str, values: Sequence[float], unit: str) -> None:
    """The speed along a straight way of one drive for each value."""
    titles, charts = [], []
    for value in values:
        went = on_lane.with_value(name, value)
        titles.append(f"{name} {value:g} {unit}: {went.times[-1]:.0f} s")
        charts.append((went.track[:, 0] - _ALONG[0].position[0], went.velocities[:, 0]))
    length = _ALONG[1].position[0] - _ALONG[0].position[0]
    chart = Chart(titles, (0.0, float(length) + 0.1), (0.0, 1.1))
    for axes, (way, speed) in zip(chart.axes, charts):
        axes.plot(way, speed, color=BLUE, linewidth=2)
        axes.axvline(length, color="0.4", linewidth=1, linestyle=":")
    chart.name_axes("way [m]; dotted: the goal", "speed [m/s]")
    chart.save(path)
