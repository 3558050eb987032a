"""A picture of a plan: the potential with isolines, what is closed, and the path."""

import math
from typing import Any, Callable, Optional, Sequence, Tuple

import numpy as np
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render_camera import Camera, usual_view, view_axes
from mesh_msgs_hdf5.rendering.render_figure import picture_png
from mesh_msgs_hdf5.rendering.render_paint import PLAIN, Legend
from mesh_msgs_hdf5.rendering.render_scale import RAINBOW, finite_limits, value_colors

from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.pose import Pose
from mesh_navigation.plugins.planner import PlanResult
from mesh_navigation.surface.face_points import passable

SIZE = (1200, 900)  # pixels
_MARGIN = 0.08  # of the region that is shown, on each side
_CEILING = 1.0  # m above all that was reached: what begins higher is left out
_ABOVE = 0.05  # m above the path: the surface itself does not hide it


def plan_picture(
    mesh_map: MeshMap,
    result: PlanResult,
    ends: Sequence[Pose],
    cost_limit: Optional[float],
    title: str = "",
    size: Tuple[int, int] = SIZE,
    progress: Callable[[float], None] = lambda part: None,
    view: Optional[Tuple[float, float]] = None,
    stops: np.ndarray = RAINBOW,
) -> bytes:
    """A PNG of the part of the map where the planner has searched, without what is far above that.

    The path is dotted where something in front of it hides it.

    Args:
        mesh_map: the map.
        result: of the plan, with or without a path and a potential.
        ends: start and goal.
        cost_limit: of the planner: what costs more, is lethal or unknown is gray; None: no limit.
        title: above the picture.
        size: width and height in pixels.
        progress: told the part that is done, 0 to 1.
        view: azimuth and elevation in degrees of the place to look from; None: from above, or iso
            where storeys lie over each other.
        stops: the colors of the potential, from the least to the greatest.
    """
    potential = result.potential
    if potential is None:
        potential = np.full(len(mesh_map.vertices), np.inf, np.float32)
    limit = np.inf if cost_limit is None else cost_limit
    open_vertices = passable(mesh_map.planning_costs().costs, limit)
    points = result.poses[:, :3]
    places = np.concatenate([points, [pose.position for pose in ends]])
    places = places[np.isfinite(places).all(axis=1)]
    shown = _shown(mesh_map, np.isfinite(potential), places)
    used, faces = np.unique(mesh_map.faces[shown], return_inverse=True)
    faces = faces.reshape(-1, 3).astype(np.uint32)
    vertices = mesh_map.vertices[used]
    view = view or usual_view(vertices, faces)
    directions = view_axes(*view)
    seen = vertices.astype(np.float64) @ directions[:2].T
    paint = PotentialPaint(seen, faces, potential[used], open_vertices[used], max(size), stops)
    hidden = _hidden(mesh_map, points, directions[2], shown)

    def overlay(axes: Any, camera: Camera) -> None:
        _draw_path(axes, points @ camera.axes[:2].T, hidden)
        with np.errstate(invalid="ignore"):  # ends that are nowhere
            start, goal = (camera.axes[:2] @ pose.position for pose in ends)
        _draw_end(axes, start, goal, "start", "o", "white")
        _draw_end(axes, goal, start, "goal", "*", "gold")

    footer = f"frame {mesh_map.frame_id}, map of {len(mesh_map.vertices)} vertices"
    mesh = Mesh(vertices, faces, frame_id=mesh_map.frame_id)
    return picture_png(mesh, paint, view, size, title, progress, overlay, footer)


def _shown(mesh_map: MeshMap, reached: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(F,) bool: the faces in and around the box of what was reached, and of the path and its ends,
    without ceilings and storeys above it."""
    corners = mesh_map.vertices[mesh_map.faces.reshape(-1)].reshape(-1, 3, 3)
    points = np.concatenate([mesh_map.vertices[reached], places])
    if len(points) == 0:
        return np.ones(len(corners), dtype=bool)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(1.0, _MARGIN * float((high - low)[:2].max()))
    low, high = low - (margin, margin, np.inf), high + (margin, margin, _CEILING)
    inside = (corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)
    shown = inside.all(axis=1)
    return shown if shown.any() else np.ones(len(corners), dtype=bool)


def _hidden(
    mesh_map: MeshMap, points: np.ndarray, viewer: np.ndarray, shown: np.ndarray
) -> np.ndarray:
    """(N,) bool: the points with one of the faces that are shown between them and the viewer."""
    if len(points) == 0:
        return np.zeros(0, dtype=bool)
    above = points + _ABOVE * np.array([0.0, 0.0, 1.0])
    towards = np.tile(viewer, (len(points), 1))
    index = mesh_map.spatial_index
    return index.any_hit_batch(origins=above, directions=towards, mask=shown)


def _draw_path(axes: Any, points: np.ndarray, hidden: np.ndarray) -> None:
    begin = 0
    for index in range(1, len(points)):
        last = index == len(points) - 1
        if last or hidden[index] != hidden[begin]:
            run = points[begin : index + 1]
            style = (0, (1, 1.5)) if hidden[begin] else "solid"
            for color, width in (("white", 5.5), ("black", 2.5)):
                axes.plot(
                    run[:, 0],
                    run[:, 1],
                    color=color,
                    linewidth=width,
                    linestyle=style if color == "black" else "solid",
                    alpha=0.4 if color == "white" and hidden[begin] else 1.0,
                    solid_joinstyle="round",
                    zorder=3 if color == "white" else 4,
                )
            begin = index


def _draw_end(
    axes: Any, position: np.ndarray, other: np.ndarray, label: str, shape: str, color: str
) -> None:
    """A mark, and its label on the side that is turned away from the other end."""
    if not np.isfinite(position).all():
        return
    x, y = position[:2]
    size = 9 if shape == "o" else 16
    axes.plot(x, y, shape, color=color, markersize=size, markeredgecolor="black", zorder=5)
    right, up = x >= other[0], y >= other[1]
    axes.annotate(
        label,
        (x, y),
        xytext=(11 if right else -11, 9 if up else -9),
        textcoords="offset points",
        fontsize=10,
        ha="left" if right else "right",
        va="bottom" if up else "top",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
        zorder=6,
    )


CLOSED = (0.38, 0.38, 0.38)
_LINES = 16  # of the potential in a picture, about
_LINE_WIDTH = 1.3  # pixels
_LINE_SHADE = 0.55  # of the color beside it
_STEEPEST = 8.0  # change of the potential per meter in the picture: lines get no wider there


class PotentialPaint:
    """A paint for mesh_msgs_hdf5.rendering (see render_paint there)."""

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        potential: np.ndarray,
        passable: np.ndarray,
        pixels: int,
        stops: np.ndarray = RAINBOW,
    ) -> None:
        """
        Args:
            vertices, faces: (V,2) or more m, the first two to the right and up in the picture, and
                (F,3): what is shown.
            potential: (V,) inf where it is not known.
            passable: (V,) bool; other vertices are shown as closed.
            pixels: along the longer side of the picture.
            stops: the colors, from the least potential to the greatest.
        """
        self._faces, self._passable, self._stops = faces, passable, stops
        self._potential = potential.astype(np.float64)
        self._known = np.isfinite(potential)
        self._limits = finite_limits(potential)
        self._step = _round_step((self._limits[1] - self._limits[0]) / _LINES)
        size = float(np.ptp(vertices[:, :2], axis=0).max()) if len(vertices) else 1.0
        self._half_line = 0.5 * _LINE_WIDTH * size / pixels
        self._slopes = _slopes(vertices, faces, np.where(self._known, self._potential, np.nan))
        entries = []
        closed = int(np.count_nonzero(~passable))
        if closed:
            entries.append((f"closed ({closed})", CLOSED))
        unknown = int(np.count_nonzero(passable & ~self._known))
        if unknown:
            entries.append((f"not reached ({unknown})", PLAIN))
        title = f"cost to the goal [m], lines every {self._step:g} m"
        bar = self._limits if self._known.any() else None
        self.legend = Legend(title if bar else "no potential", bar, stops, tuple(entries))

    def colors(self, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(N,3) of points on the faces (N,) where the corners have the weights (N,3)."""
        corners = self._faces[face]
        known = self._known[corners]
        share = np.where(known, weights, 0)
        total = share.sum(axis=1)
        values = np.where(known, self._potential[corners], 0)
        value = (values * share).sum(axis=1) / np.where(total > 0, total, 1)
        colors = value_colors(self._stops, self._limits, value)
        away = np.abs(value - self._step * np.rint(value / self._step))
        colors[away < self._half_line * self._slopes[face]] *= _LINE_SHADE
        nearest = np.take_along_axis(corners, weights.argmax(axis=1)[:, None], axis=1)[:, 0]
        colors[~self._known[nearest]] = PLAIN
        colors[~self._passable[nearest]] = CLOSED
        return colors


def _round_step(least: float) -> float:
    """1, 2 or 5 times a power of ten: the smallest that is not below ``least``."""
    if not least > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least * (1 - 1e-9))


def _slopes(vertices: np.ndarray, faces: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(F,) how much values (V,) change per meter in the picture; 0 where one is not known."""
    a, b, c = (vertices[faces[:, i], :2].astype(np.float64) for i in range(3))
    u, v, w = (values[faces[:, i]] for i in range(3))
    b, c, v, w = b - a, c - a, v - u, w - u
    area = b[:, 0] * c[:, 1] - c[:, 0] * b[:, 1]
    x = v * c[:, 1] - w * b[:, 1]
    y = w * b[:, 0] - v * c[:, 0]
    slopes = np.hypot(x, y) / np.where(area != 0, np.abs(area), np.inf)
    return np.minimum(np.nan_to_num(slopes, nan=0.0), _STEEPEST)
