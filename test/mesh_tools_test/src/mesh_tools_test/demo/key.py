"""What explains a picture: title, key of its lines, scale, and where start and goal are."""
import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from PIL import Image

from mesh_msgs_hdf5.rendering.render_figure import round_length

from mesh_tools_test.demo.rviz_config import HALO, HALO_WIDTH, ISOLINE, PATH, TRACK, TRACK_COLOR

TITLE, STRIP = 40, 52  # pixels above and below the 3D view
RING = 44  # pixels across, around start and goal
_DPI, _SCALE = 100, 170  # pixels of the bar of the scale, at most
_POINT = 72 / _DPI  # of a pixel, in points
_PAPER, _ROBOT, _FRONT = (0.93, 0.94, 0.95), (0.16, 0.30, 0.55), (1.0, 0.55, 0.0)


def with_key(view, camera, title, handles, places):
    """A picture of the 3D view with all that explains it, as an image.

    :param view: (H, W, 3) uint8
    :param camera: the OrbitCamera of the view
    :param handles: of the key, as `line` and `robot` make them
    :param places: name -> position (3,) m: marked in the picture
    """
    height, width = view.shape[:2]
    whole = height + TITLE + STRIP
    figure = Figure(figsize=(width / _DPI, whole / _DPI), dpi=_DPI, facecolor=_PAPER)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes([0, 0, 1, 1])  # in pixels, those of the 3D view as the camera has them
    axes.imshow(view, extent=(0, width, height, 0), interpolation="nearest", aspect="auto")
    axes.set_axis_off()
    axes.set_xlim(0, width)
    axes.set_ylim(height + STRIP, -TITLE)
    axes.text(14, -TITLE / 2, title, fontsize=12, va="center", weight="bold")
    for name, at in zip(places, camera.pixels(list(places.values()))):
        _mark(axes, name, at)
    _scale(axes, camera, np.mean(list(places.values()), axis=0), width, height)
    if handles:
        axes.legend(
            handles=handles,
            loc="center left",
            bbox_to_anchor=(0, STRIP / 2 / whole),
            ncol=len(handles),
            frameon=False,
            fontsize=10,
            handlelength=2.6,
        )
    out = io.BytesIO()
    canvas.print_png(out)
    return Image.open(out).convert("RGB")


def line(label, color, pixels, below=None, wider=0.0):
    """A line of the key: color (0 to 255) and width as in the picture, and of what is below."""
    effects = [withStroke(linewidth=wider * _POINT, foreground=_rgb(below))] if below else None
    look = {"color": _rgb(color), "linewidth": pixels * _POINT, "path_effects": effects}
    return Line2D([], [], label=label, **look)


def path(planner):
    """The path of a planner, for the key."""
    return line(f"path: {planner.title}", planner.color, PATH, HALO, HALO_WIDTH)


def track(planner):
    """The track of the robot on the path of a planner, for the key."""
    return line("track of the robot", TRACK_COLOR, TRACK, planner.color, PATH)


def isoline(step):
    """Lines of equal cost, for the key; step: from one to the next [m]."""
    label = f"equal cost to the goal, every {step:g} m (white where it is dark)"
    return line(label, (0, 0, 0), ISOLINE)


def robot(times):
    """The robot, for the key; times: by how much it is enlarged."""
    label = "robot" if times == 1 else f"robot, drawn at {times} times its size"
    look = {"markerfacecolor": _ROBOT, "markeredgecolor": _FRONT, "markeredgewidth": 2}
    return Line2D([], [], marker="o", markersize=10, linestyle="", label=label, **look)


def _rgb(color):
    return tuple(value / 255 for value in color)


def _mark(axes, name, at):
    """A ring around a place, in which there is room for the robot, and the name beside it."""
    for color, points in (("black", 4.0), ("white", 2.0)):
        look = {"markerfacecolor": "none", "markeredgecolor": color, "markeredgewidth": points}
        axes.plot(*at, marker="o", markersize=RING * _POINT, **look)
    axes.annotate(
        name,
        at,
        xytext=(0, -RING / 2 - 10),
        textcoords="offset pixels",
        ha="center",
        va="top",
        fontsize=11,
        bbox={"facecolor": "white", "edgecolor": "black", "boxstyle": "round,pad=0.25"},
    )


def _scale(axes, camera, middle, width, height):
    """A bar as long as a round length is at the middle of the way, across the picture."""
    pixel = camera.meters(middle[None])[0]
    meters = round_length(_SCALE * pixel)
    right, y = width - 20, height + STRIP * 0.7
    axes.plot([right - meters / pixel, right], [y, y], color="black", linewidth=4, marker="|")
    label = f"{meters:g} m, halfway from start to goal"
    axes.text(right, height + STRIP * 0.5, label, fontsize=10, ha="right", va="bottom")
