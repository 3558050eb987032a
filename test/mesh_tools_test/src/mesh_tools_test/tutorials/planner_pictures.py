"""What radius, edges and the parameters of planners do to a path: one picture for each."""
from pathlib import Path
from typing import Any, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from mesh_navigation.base.path import path_length
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.planning import body_on, make_planner, plan

from mesh_tools_test.tutorials.panels import (
    CLOSED,
    EDGE,
    THING,
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

_FIELD, _FIELD_EDGE, _MOUND = (10.0, 7.0), 0.125, 1.2  # m
_PILLARS: List[Rectangle] = [(4.8, 5.9, 5.2, 6.3)]
_FROM, _TO = (1.0, 3.5), (9.0, 3.5)
_HALL = (8.0, 6.0)  # m
_DOORS = 1.1, 1.7  # m: the near one and the far one
_WALLS: List[Rectangle] = [
    (3.9, 0.0, 4.1, 1.0),
    (3.9, 1.0 + _DOORS[0], 4.1, 3.8),
    (3.9, 3.8 + _DOORS[1], 4.1, 6.0),
]
_HERE, _THERE = (0.8, 1.55), (7.2, 1.55)
COLLISION = layer("collision", "Collision", step_height=0.2, robot_height=1.0)


class Planned(NamedTuple):
    """points: (N, 3) m of the path, none where there is none; closed: (V,) bool, to the robot's
    middle."""

    points: np.ndarray
    closed: np.ndarray


def all_pictures(folder: Path) -> None:
    """Write them into a folder."""
    field = room(_FIELD, _PILLARS, _FIELD_EDGE, mound=_MOUND)
    inflation = {"inscribed_radius": 0.4, "inflation_radius": 1.2, "repulsive_field": False}
    field.mesh_map.compute_layers(
        [
            COLLISION,
            layer("steepness", "Steepness", threshold=1.0),
            layer("inflation", "Inflation", inputs=["collision"], **inflation),
        ]
    )
    _on_field(folder / "cost_factor.png", field, "cost_factor", (0.0, 0.6, 3.0), {})
    _on_field(folder / "cost_limit.png", field, "cost_limit", (0.2, 0.4, 1.0), {"cost_factor": 0.0})
    _radius(folder / "robot_radius.png")
    _edges(folder / "edges_and_radius.png")


def planned(
    shown: Room,
    start: Sequence[float],
    goal: Sequence[float],
    radius: float,
    params: Optional[Mapping[str, Any]] = None,
) -> Planned:
    """A plan of the wave front for a round robot."""
    mesh_map = shown.mesh_map
    body = body_on(mesh_map, RobotShape(radius=radius))
    planner = make_planner(mesh_map, "wave_front", params or {}, body)
    result = plan(mesh_map, (*start, 0.0), (*goal, 0.0), planner)
    costs = body.costs(mesh_map.planning_costs().costs)
    limit = planner.values["cost_limit"]
    return Planned(result.poses[:, :3] if result.succeeded else np.zeros((0, 3)), ~(costs <= limit))


def _on_field(
    path: Path, field: Room, name: str, values: Sequence[float], others: Mapping[str, Any]
) -> None:
    found = [planned(field, _FROM, _TO, 0.4, {**others, name: value}) for value in values]
    titles = [f"{name} {value:g}: {_told(each)}" for value, each in zip(values, found)]
    panels = Panels(titles, _FIELD)
    limits = (0.0, 1.0)
    for axes, each in zip(panels.axes, found):
        _draw(axes, field, each, limits, _FROM, _TO, _FIELD)
    panels.name_axes("x [m]", "y [m]")
    panels.scale(limits, "costs of all layers")
    panels.key(
        [
            lethal_key(),
            area_key(CLOSED, "closed: over cost_limit, or within the radius of lethal ground"),
            line_key("black", "path"),
            *ends_key(),
        ]
    )
    panels.save(path)


def _radius(path: Path) -> None:
    hall = room(_HALL, _WALLS, 0.1)
    hall.mesh_map.compute_layers([COLLISION])
    values = (0.3, 0.6, 0.9)
    found = [planned(hall, _HERE, _THERE, value) for value in values]
    titles = [f"robot_radius {value:g} m: {_told(each)}" for value, each in zip(values, found)]
    _hall_picture(path, [hall] * 3, found, titles, edges=False)


def _edges(path: Path) -> None:
    values = (0.8, 0.4, 0.2)
    halls = [room(_HALL, _WALLS, 10.0, value) for value in values]
    for hall in halls:
        hall.mesh_map.compute_layers([COLLISION])
    found = [planned(hall, _HERE, _THERE, 0.4) for hall in halls]
    titles = [f"max_edge_length {value:g} m: {_told(each)}" for value, each in zip(values, found)]
    _hall_picture(path, halls, found, titles, edges=True)


def _hall_picture(
    path: Path,
    halls: Sequence[Room],
    found: Sequence[Planned],
    titles: Sequence[str],
    edges: bool,
) -> None:
    panels = Panels(titles, _HALL)
    for axes, hall, each in zip(panels.axes, halls, found):
        _draw(axes, hall, each, (0.0, 1.0), _HERE, _THERE, _HALL, edges)
    for axes in panels.axes[:1]:
        for y, width in ((1.0, _DOORS[0]), (3.8, _DOORS[1])):
            axes.annotate(f"{width:g} m", (4.35, y + width / 2 + 0.42), fontsize=8, va="center")
    panels.name_axes("x [m]", "y [m]")
    handles = [lethal_key(), area_key(CLOSED, "closed to the robot's middle")]
    handles += [area_key(THING, "walls"), line_key("black", "path"), *ends_key()]
    panels.key([*handles, line_key(EDGE, "edges of the mesh")] if edges else handles)
    panels.save(path)


def _draw(
    axes: Any,
    shown: Room,
    each: Planned,
    limits: Tuple[float, float],
    start: Sequence[float],
    goal: Sequence[float],
    size: Tuple[float, float],
    edges: bool = False,
) -> None:
    mesh_map = shown.mesh_map
    faces, costs = mesh_map.faces[shown.floor], mesh_map.planning_costs().costs
    draw_costs(axes, mesh_map.vertices, faces, costs, limits, each.closed, edges)
    draw_boxes(axes, shown.walls)
    if len(each.points):
        draw_path(axes, each.points)
    draw_ends(axes, start, goal)
    axes.set_xlim(0, size[0])
    axes.set_ylim(0, size[1])


def _told(each: Planned) -> str:
    return f"{path_length(each.points):.1f} m" if len(each.points) else "no path"
