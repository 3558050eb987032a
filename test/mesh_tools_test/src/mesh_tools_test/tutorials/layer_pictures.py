"""What the parameters of layers do: one picture for each."""
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np
from mesh_map.map.mesh_map import MeshMap

from mesh_tools_test.tutorials.panels import (
    BLACK,
    BLUE,
    ORANGE,
    THING,
    Panels,
    area_key,
    draw_boxes,
    draw_costs,
    draw_ground,
    lethal_key,
    line_key,
)
from mesh_tools_test.tutorials.parameter_worlds import (
    THINGS,
    Rectangle,
    Room,
    Track,
    coarse_steps,
    layer,
    room,
    steps_and_slopes,
    track,
)

EDGE = 0.04  # m, of tracks
_BELOW, _ABOVE = 0.25, 0.35  # m around what is seen of a track
_HALL, _HALL_EDGE = (5.0, 6.0), 0.1  # m
_WALLS: List[Rectangle] = [(0.0, 2.4, 2.0, 2.6), (3.6, 2.4, 5.0, 2.6), (1.4, 0.9, 1.6, 1.1)]
_INFLATION: Dict[str, Any] = {
    "inscribed_radius": 0.4,
    "inflation_radius": 1.2,
    "inscribed_value": 1.0,
    "repulsive_field": False,
}


def all_pictures(folder: Path) -> None:
    """Write them into a folder."""
    height_difference = ("height_diff", "HeightDiff", "height difference [m]", (0.0, 0.4))
    _steps(
        folder / "height_diff_threshold.png",
        height_difference,
        [{"threshold": value, "radius": 0.2} for value in (0.15, 0.25, 0.35)],
        "threshold",
    )
    _steps(
        folder / "height_diff_radius.png",
        height_difference,
        [{"threshold": 0.25, "radius": value} for value in (0.1, 0.2, 0.4)],
        "radius",
    )
    _steps(
        folder / "steepness_threshold.png",
        ("steepness", "Steepness", "steepness [rad]", (0.0, 1.0)),
        [{"threshold": value} for value in (0.3, 0.5, 0.75)],
        "threshold",
    )
    _coarse(folder / "max_edge_length.png")
    _things(folder / "step_height.png", "step_height", (0.1, 0.25, 0.5), robot_height=1.2)
    _things(folder / "robot_height.png", "robot_height", (0.5, 1.0, 1.5), step_height=0.25)
    hall = room(_HALL, _WALLS, _HALL_EDGE)
    _inflation(folder / "inscribed_radius.png", hall, "inscribed_radius", (0.2, 0.4, 0.8))
    _inflation(folder / "inflation_radius.png", hall, "inflation_radius", (0.5, 1.2, 2.0))
    _fading(folder / "fading.png", hall)


def computed(mesh_map: MeshMap, *layers: Mapping[str, Any]) -> Tuple[np.ndarray, np.ndarray]:
    """Costs (V,) of the last of these layers, and which vertices (V,) it calls lethal."""
    mesh_map.compute_layers(list(layers))
    result = mesh_map.layers[layers[-1]["name"]].result
    assert result is not None, mesh_map.layer_errors
    return result.costs, result.lethal


def _track_panels(shown: Sequence[Track], titles: Sequence[str]) -> Panels:
    """Panels below each other, each as high as the track with what stands on it."""
    profile = shown[0].profile
    high = max([profile[:, 1].max(), *(thing.high for thing in shown[0].things)])
    low = profile[:, 1].min() - _BELOW
    size = profile[-1, 0] - profile[0, 0], high + _ABOVE - low
    panels = Panels(titles, size, stacked=True)
    for axes in panels.axes:
        axes.set_xlim(profile[0, 0], profile[-1, 0])
        axes.set_ylim(low, low + size[1])
    panels.name_axes("x [m]", "z [m]")
    return panels


def _steps(path: Path, shown: Tuple[str, str, str, Any], values: List[Any], name: str) -> None:
    """One layer on the track of steps and slopes, with each of these parameters."""
    layer_name, kind, label, limits = shown
    corners, names = steps_and_slopes()
    ground = track(corners, EDGE)
    unit = " rad" if "rad" in label else " m"
    titles = [f"{name} {each[name]:g}{unit}" for each in values]
    panels = _track_panels([ground], titles)
    for axes, params in zip(panels.axes, values):
        costs, lethal = computed(ground.mesh_map, layer(layer_name, kind, **params))
        low = axes.get_ylim()[0]
        middle = ground.middle
        draw_ground(axes, ground.profile, costs[middle], lethal[middle], limits, low)
    for x, z, text in names:
        panels.axes[0].annotate(text, (x, z + 0.04), fontsize=8, ha="center", va="bottom")
    panels.scale(limits, label)
    panels.key([lethal_key(f"lethal: {layer_name} above its threshold")])
    panels.save(path)


def _coarse(path: Path) -> None:
    """Steps of CAD with edges of several lengths, for one radius and threshold."""
    values = (0.0, 0.2, 0.1)
    tracks = [coarse_steps(value) for value in values]
    titles = [
        "max_edge_length %s" % (f"{value:g} m" if value else "0: as it is") for value in values
    ]
    panels = _track_panels(tracks, titles)
    limits = (0.0, 0.4)
    for axes, ground in zip(panels.axes, tracks):
        height_diff = layer("height_diff", "HeightDiff", threshold=0.25, radius=0.2)
        costs, lethal = computed(ground.mesh_map, height_diff)
        middle, low = ground.middle, axes.get_ylim()[0]
        draw_ground(axes, ground.profile, costs[middle], lethal[middle], limits, low)
        axes.plot(*ground.profile.T, "o", color="black", markersize=2.5, zorder=5)
    panels.scale(limits, "height difference [m]")
    dots = line_key("black", "ground; dots: vertices")
    dots.set_marker("o")
    panels.key([lethal_key("lethal: height_diff, threshold 0.25 m, radius 0.2 m"), dots])
    panels.save(path)


def _things(path: Path, name: str, values: Sequence[float], **others: float) -> None:
    """The collision layer with things on the ground and above it."""
    ground = track([(0.0, 0.0), (12.0, 0.0)], EDGE, THINGS)
    panels = _track_panels([ground], [f"{name} {value:g} m" for value in values])
    middle = ground.middle
    for axes, value in zip(panels.axes, values):
        params = {**others, name: value}
        _, lethal = computed(ground.mesh_map, layer("collision", "Collision", **params))
        free = np.zeros(len(middle))
        draw_ground(axes, ground.profile, free, lethal[middle], (0.0, 1.0), axes.get_ylim()[0])
        draw_boxes(axes, [(each.begin, each.low, each.end, each.high) for each in THINGS])
        axes.axhspan(params["step_height"], params["robot_height"], color=BLUE, alpha=0.16, lw=0)
    for thing in THINGS:
        text = f"{thing.high:g} m high" if thing.low == 0.0 else f"{thing.low:g} m above"
        place = (thing.begin + thing.end) / 2, thing.high + 0.04
        panels.axes[0].annotate(text, place, fontsize=8, ha="center", va="bottom")
    band = area_key(BLUE, "what the body fills: step_height to robot_height")
    band.set_alpha(0.16)
    panels.key([lethal_key(), area_key(THING, "things"), band])
    panels.save(path)


def _inflated(hall: Room, **params: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Costs (V,) with +inf where it is lethal, and those of the inflation as they are."""
    collision = layer("collision", "Collision", step_height=0.2, robot_height=1.0)
    inflation = layer("inflation", "Inflation", **{**_INFLATION, **params})
    costs, lethal = computed(hall.mesh_map, collision, inflation)
    return np.where(lethal, np.inf, costs), costs


def _hall_panels(hall: Room, titles: Sequence[str], each: Sequence[Mapping[str, Any]]) -> Panels:
    panels = Panels(titles, _HALL)
    mesh_map = hall.mesh_map
    for axes, params in zip(panels.axes, each):
        costs, _ = _inflated(hall, **params)
        draw_costs(axes, mesh_map.vertices, mesh_map.faces[hall.floor], costs, (0.0, 1.0))
        draw_boxes(axes, hall.walls)
        axes.set_xlim(0, _HALL[0])
        axes.set_ylim(0, _HALL[1])
    panels.name_axes("x [m]", "y [m]")
    panels.scale((0.0, 1.0), "cost of the inflation")
    return panels


def _inflation(path: Path, hall: Room, name: str, values: Sequence[float]) -> None:
    params = [{name: value} for value in values]
    panels = _hall_panels(hall, [f"{name} {value:g} m" for value in values], params)
    panels.key([lethal_key(), area_key(THING, "walls")])
    panels.save(path)


def _fading(path: Path, hall: Room) -> None:
    """Three ways from 1 to 0, above each other in a chart, and each of them on the floor."""
    each: List[Dict[str, Any]] = [{"fading": "cosine"}]
    each += [{"fading": "exponential", "cost_scaling_factor": value} for value in (1.0, 5.0)]
    titles = ["cosine", "exponential, 1 / m", "exponential, 5 / m"]
    panels = _hall_panels(hall, titles, each)
    for axes, params, color in zip(panels.axes, each, (BLACK, BLUE, ORANGE)):
        inset = axes.inset_axes([0.41, 0.7, 0.56, 0.24])
        distance, costs = _costs_from_wall(hall, params)
        inset.plot(distance, costs, color=color, linewidth=2)
        inset.set_xlim(0, 1.6)
        inset.set_ylim(0, 1.1)
        inset.set_title("cost over m from the wall", fontsize=7, pad=2)
        inset.tick_params(labelsize=7, pad=1)
    panels.key([lethal_key(), area_key(THING, "walls")])
    panels.save(path)


def _costs_from_wall(hall: Room, params: Mapping[str, Any]) -> Tuple[np.ndarray, np.ndarray]:
    """m from the wall, and costs, along x = 0.5."""
    _, costs = _inflated(hall, **params)
    x, y, z = hall.mesh_map.vertices.T
    line = np.flatnonzero((np.abs(x - 0.5) < 1e-3) & (y >= 2.6 - 1e-3) & (np.abs(z) < 1e-6))
    line = line[np.argsort(y[line])]
    return y[line] - 2.6, costs[line]
