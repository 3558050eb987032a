"""Small multiples: panels side by side, or below each other, that differ in one value."""
from pathlib import Path
from typing import Any, List, Optional, Sequence, Tuple

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from mesh_msgs_hdf5.rendering.render_scale import LETHAL

from mesh_tools_test.demo.planners import DIJKSTRA, EXACT, WAVE_FRONT

# As in the demo: Viridis backwards, so that what is cheap is bright, and colors of Okabe and Ito.
COLORS = "viridis_r"
BLUE, ORANGE, BLACK = (
    tuple(value / 255 for value in shown.color) for shown in (WAVE_FRONT, EXACT, DIJKSTRA)
)
CLOSED, THING, EDGE = "0.55", "0.25", "0.35"  # closed to the robot, solid, edges of the mesh
_DPI, WIDTH = 100, 1000  # pixels
_LEFT, _RIGHT, _TITLE, _EDGE, _BOTTOM, _GAP = 60, 105, 34, 10, 84, 22  # pixels
_HATCH = "////"  # of what is lethal, in print without colors


class Panels:
    """A figure of panels that share both axes, in meters.

    axes: of the panels, from left to right or from top to bottom.
    """

    def __init__(self, titles: Sequence[str], size: Tuple[float, float], stacked: bool = False):
        """
        :param titles: of the panels
        :param size: m along both axes of a panel
        :param stacked: below each other, with the titles on their right
        """
        count, across = len(titles), 1 if stacked else len(titles)
        width = (WIDTH - _LEFT - _RIGHT - (across - 1) * _GAP) / across
        height = width * size[1] / size[0]
        rows = count if stacked else 1
        top = _EDGE if stacked else _TITLE
        self._height = top + rows * height + (rows - 1) * _GAP + _BOTTOM
        self.figure = Figure(figsize=(WIDTH / _DPI, self._height / _DPI), dpi=_DPI)
        self.axes: List[Any] = []
        for number, title in enumerate(titles):
            right, down = (0, number) if stacked else (number, 0)
            left = _LEFT + right * (width + _GAP)
            bottom = self._height - top - (down + 1) * height - down * _GAP
            axes = self.figure.add_axes(self._place(left, bottom, width, height))
            axes.tick_params(labelsize=8)
            axes.yaxis.set_major_locator(MaxNLocator(3 if stacked else 6, steps=[1, 2, 5, 10]))
            if stacked:
                axes.text(0.006, 0.9, title, transform=axes.transAxes, weight="bold", va="top")
            else:
                axes.set_title(title, fontsize=10, weight="bold")
            if down < rows - 1:
                axes.set_xticklabels([])
            if right:
                axes.set_yticklabels([])
            self.axes.append(axes)
        self._inner = _BOTTOM, self._height - top

    def _place(self, left: float, bottom: float, width: float, height: float) -> List[float]:
        return [left / WIDTH, bottom / self._height, width / WIDTH, height / self._height]

    def name_axes(self, x: str, y: str) -> None:
        """Below the lowest panels, and left of the first ones."""
        bottom = max(axes.get_position().y0 for axes in self.axes[-1:])
        for axes in self.axes:
            if axes.get_position().y0 <= bottom + 1e-6:
                axes.set_xlabel(x, fontsize=9)
            if axes.get_position().x0 <= _LEFT / WIDTH + 1e-6:
                axes.set_ylabel(y, fontsize=9)

    def scale(self, limits: Tuple[float, float], label: str) -> None:
        """The key of the costs, on the right."""
        low, high = self._inner
        high = min(high, low + 260)
        bar = self.figure.add_axes(self._place(WIDTH - _RIGHT + 14, low, 14, high - low))
        shown = ScalarMappable(Normalize(*limits), COLORS)
        self.figure.colorbar(shown, cax=bar).set_label(label, fontsize=9)
        bar.tick_params(labelsize=8)

    def key(self, handles: Sequence[Any]) -> None:
        """That of all else, below."""
        self.figure.legend(
            handles=list(handles),
            loc="lower left",
            bbox_to_anchor=(_LEFT / WIDTH - 0.01, 4 / self._height),
            ncol=len(handles),
            frameon=False,
            fontsize=9,
        )

    def save(self, path: Path) -> None:
        """As PNG."""
        with rc_context({"hatch.linewidth": 0.7}):
            FigureCanvasAgg(self.figure).print_png(str(path))


class Chart(Panels):
    """Panels side by side that are no pictures of places, but have any axes."""

    def __init__(
        self, titles: Sequence[str], across: Tuple[float, float], up: Tuple[float, float]
    ) -> None:
        """
        :param titles: of the panels
        :param across, up: least and greatest value of each axis
        """
        super().__init__(titles, (4.0, 3.0))
        for axes in self.axes:
            axes.set_xlim(*across)
            axes.set_ylim(*up)
            axes.grid(True, linewidth=0.4, alpha=0.5)


def lethal_key(text: str = "lethal") -> Patch:
    """For the key."""
    return Patch(facecolor=LETHAL, edgecolor="white", hatch=_HATCH, label=text)


def area_key(color: Any, text: str) -> Patch:
    """For the key."""
    return Patch(facecolor=color, label=text)


def line_key(color: Any, text: str, style: str = "-") -> Line2D:
    """For the key."""
    return Line2D([], [], color=color, linestyle=style, linewidth=2.2, label=text)


def dot_key(color: Any, text: str, marker: str = "o") -> Line2D:
    """For the key."""
    return Line2D([], [], color=color, marker=marker, linestyle="", markersize=5, label=text)


def draw_ground(
    axes: Any,
    profile: np.ndarray,
    costs: np.ndarray,
    lethal: np.ndarray,
    limits: Tuple[float, float],
    below: float,
) -> None:
    """A track from the side: what is below the ground has the color of the ground's cost.

    :param profile: (N, 2) m: x and z; costs, lethal: (N,) of these places
    :param below: m, down to which it is drawn
    """
    middles = (profile[1:] + profile[:-1]) / 2
    ends = np.concatenate([profile[:1], middles, profile[-1:]])
    quads = np.stack(
        [
            np.stack([ends[:-1, 0], np.full(len(profile), below)], axis=1),
            ends[:-1],
            profile,
            ends[1:],
            np.stack([ends[1:, 0], np.full(len(profile), below)], axis=1),
        ],
        axis=1,
    )
    free = PolyCollection(
        quads[~lethal], array=costs[~lethal], cmap=COLORS, norm=Normalize(*limits)
    )
    free.set_edgecolor("face")
    free.set_linewidth(0.5)
    axes.add_collection(free)
    _fill(axes, quads[lethal])
    axes.plot(*profile.T, color="black", linewidth=1.2, zorder=4)
    # Of an upright step, this is all that is seen.
    axes.add_collection(LineCollection(quads[lethal][:, 1:4], colors=[LETHAL], lw=6, zorder=3))


def draw_costs(
    axes: Any,
    vertices: np.ndarray,
    faces: np.ndarray,
    costs: np.ndarray,
    limits: Tuple[float, float],
    closed: Optional[np.ndarray] = None,
    edges: bool = False,
) -> None:
    """A floor from above, as RViz shows it.

    :param vertices: (V, 2) or more m; faces: (F, 3); costs: (V,), +inf is lethal
    :param closed: (V,) bool, what besides is closed to the robot; it is grey
    :param edges: those of the mesh are drawn
    """
    lethal = ~np.isfinite(costs)
    x, y = vertices[:, 0], vertices[:, 1]
    shown = _without_lethal(faces, costs, lethal)
    axes.tripcolor(
        x, y, faces, shown, shading="gouraud", cmap=COLORS, norm=Normalize(*limits), zorder=1
    )
    if closed is not None:
        _fill(axes, _cells(vertices, faces, closed & ~lethal), CLOSED)
    _fill(axes, _cells(vertices, faces, lethal))
    if edges:
        axes.triplot(x, y, faces, color=EDGE, linewidth=0.4, zorder=3)
    axes.set_aspect("equal")


def draw_boxes(axes: Any, boxes: Sequence[Tuple[float, float, float, float]]) -> None:
    """Solid things: x, y from; x, y to (m)."""
    for left, bottom, right, top in boxes:
        axes.add_patch(
            Rectangle(
                (left, bottom), right - left, top - bottom, color=THING, linewidth=0, zorder=4
            )
        )


def draw_path(axes: Any, points: np.ndarray, color: Any = "black", style: str = "-") -> None:
    """In a white halo; points: (N, 2) or more m."""
    halo = [withStroke(linewidth=4.5, foreground="white")] if style == "-" else None
    look = {"color": color, "linewidth": 2.2, "linestyle": style, "path_effects": halo}
    axes.plot(points[:, 0], points[:, 1], zorder=5, **look)


def draw_ends(axes: Any, start: Sequence[float], goal: Sequence[float]) -> None:
    """Where it begins, and where it has to arrive."""
    look = {"markeredgecolor": "black", "zorder": 6, "linestyle": ""}
    axes.plot(*start[:2], marker="o", markersize=8, color="white", **look)
    axes.plot(*goal[:2], marker="*", markersize=14, color="gold", **look)


def ends_key() -> List[Line2D]:
    """For the key."""
    look = {"markeredgecolor": "black", "linestyle": ""}
    return [
        Line2D([], [], marker="o", markersize=8, color="white", label="start", **look),
        Line2D([], [], marker="*", markersize=14, color="gold", label="goal", **look),
    ]


def _fill(axes: Any, polygons: np.ndarray, color: Any = None) -> None:
    """Polygons (K, N, 2) as one area; without a color: as what is lethal."""
    if not len(polygons):
        return
    closed = np.concatenate([polygons, polygons[:, :1]], axis=1)
    codes = np.full(closed.shape[:2], Outline.LINETO, Outline.code_type)
    codes[:, 0], codes[:, -1] = Outline.MOVETO, Outline.CLOSEPOLY
    look = {"facecolor": color, "zorder": 2, "linewidth": 0}
    if color is None:
        look.update(facecolor=LETHAL, edgecolor="white", hatch=_HATCH)
    axes.add_patch(PathPatch(Outline(closed.reshape(-1, 2), codes.ravel()), **look))


def _cells(vertices: np.ndarray, faces: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """(K, 4, 2): of the chosen vertices (V,) what of their faces is nearest to them."""
    corners = vertices[faces][:, :, :2].astype(np.float64)
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    centers = np.broadcast_to(corners.mean(axis=1, keepdims=True), corners.shape)
    quads = np.stack([corners, middles, centers, np.roll(middles, 1, axis=1)], axis=2)
    return quads[chosen[faces]]


def _without_lethal(faces: np.ndarray, costs: np.ndarray, lethal: np.ndarray) -> np.ndarray:
    """The costs (V,) where lethal vertices have those of the others around them."""
    values, known = np.where(lethal, 0.0, costs), ~lethal[faces]
    total, count = np.zeros(len(costs)), np.zeros(len(costs))
    for corner in range(3):
        np.add.at(total, faces[:, corner], (values[faces] * known).sum(axis=1))
        np.add.at(count, faces[:, corner], known.sum(axis=1))
    return np.where(lethal, total / np.maximum(count, 1), values)
