"""The picture with all that explains it, as PNG: title, axes in meters, scale, bar, legend."""
import io
import logging
import math
import warnings
from typing import Any, Callable, Sequence, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render import paint_mesh
from mesh_msgs_hdf5.rendering.render_camera import Camera, axis_names, look_at, view_axes
from mesh_msgs_hdf5.rendering.render_scale import scale_colors

SMALLEST, LARGEST = 200, 8000  # pixels along a side of the picture
_DPI = 100
_LEFT, _BOTTOM, _TOP, _RIGHT, _BAR = 75, 62, 40, 20, 110  # margins in pixels
# Of the legend: most entries, most letters of one and of the title, points of their height, pixels
# around them with the patch of color, between the mesh's place and them.
_ENTRIES, _LETTERS, _TITLE_LETTERS, _POINTS, _AROUND, _BESIDE = 24, 28, 34, 8, 34, 8


def picture_png(
    mesh: Mesh,
    paint,
    view: Tuple[float, float],
    size: Tuple[int, int],
    title: str,
    progress: Callable[[float], None] = lambda part: None,
    overlay: Callable[[Any, Camera], None] = lambda axes, camera: None,
    footer: str = "",
) -> bytes:
    """A PNG of size (width, height) pixels of a mesh in a paint, seen from a view (see look_at).

    overlay: draws more into the matplotlib axes, which are in meters along right and up of the
    camera. footer: instead of the counts of the mesh.
    """
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    inner = _inner(size, paint.legend, axis_names(view_axes(*view))[0] != "")
    camera = look_at(mesh.vertices, view, inner[2], inner[3])
    picture = paint_mesh(mesh, camera, paint, progress)
    # only now: this takes longer than painting a small mesh
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = size
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    box = [inner[0] / width, inner[1] / height, inner[2] / width, inner[3] / height]
    axes = figure.add_axes(box)
    axes.imshow(picture, extent=camera.extent, interpolation="nearest", aspect="auto")
    _axes(axes, camera)
    overlay(axes, camera)
    _scale_bar(axes, camera)
    middle = inner[0] + inner[2] // 2
    axes.set_title(_plain(title, min(100, 2 * min(middle, width - middle) // 9)), fontsize=11)
    _legend(figure, axes, paint.legend, inner, size)
    figure.text(
        8 / width,
        8 / height,
        _plain(footer or _footer(mesh), min(160, width // 7)),
        fontsize=7.5,
        color="0.35",
    )
    out = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # characters that the font does not have
        canvas.print_png(out)
    return out.getvalue()


def _inner(size: Sequence[int], legend, numbered: bool) -> Tuple[int, int, int, int]:
    """Left, bottom, width and height of the mesh's place in pixels."""
    left, bottom = (_LEFT, _BOTTOM) if numbered else (_RIGHT, _RIGHT + 10)
    right = _BAR if legend.limits is not None else _RIGHT
    if legend.entries:
        right = max(right, _legend_width(legend))
    width, height = size
    return left, bottom, max(40, width - left - right), max(40, height - bottom - _TOP)


def _legend_width(legend) -> int:
    """Pixels that the entries need beside the mesh's place, and the title above them."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    texts = [_short(text, _LETTERS) for text, _ in legend.entries]
    if legend.limits is None:
        texts.append(_short(legend.title, _TITLE_LETTERS))
    font, measure = FontProperties(size=_POINTS), text_to_path.get_text_width_height_descent
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # characters that the font does not have
        widths = [measure(text, font, False)[0] for text in texts]
    return math.ceil(max(widths) * _DPI / 72) + _AROUND + _BESIDE


def _short(text, most):
    text = one_line(text)
    return text if len(text) <= most else text[: most - 3] + "..."


def _plain(text, most):
    """Text as it is: matplotlib would take $ for a formula."""
    return _short(text, most).replace("$", r"\$")


def _footer(mesh):
    text = "%d vertices, %d faces, frame %s" % (len(mesh.vertices), len(mesh.faces), mesh.frame_id)
    if any(mesh.origin) or mesh.crs:
        text += ", origin %s %s" % (" ".join("%.12g" % value for value in mesh.origin), mesh.crs)
    return text


def _axes(axes, camera: Camera):
    names = axis_names(camera.axes)
    if names[0]:
        axes.set_xlabel(names[0] + " [m]", fontsize=9)
        axes.set_ylabel(names[1] + " [m]", fontsize=9)
        axes.tick_params(labelsize=8)
        axes.ticklabel_format(useOffset=False, style="plain")
        axes.grid(True, linewidth=0.4, alpha=0.35)
        axes.set_axisbelow(True)
        return
    axes.set_xticks([])
    axes.set_yticks([])
    # where the axes of the frame point to, in the upper left corner
    left, right, bottom, top = camera.extent
    length = 0.06 * min(right - left, top - bottom)
    at = np.array([left + 2 * length, top - 2 * length])
    for i, color in enumerate(("red", "green", "blue")):
        tip = at + length * camera.axes[:2, i]
        axes.annotate("", tip, at, arrowprops={"arrowstyle": "->", "color": color, "lw": 1.5})
        axes.text(*(at + 1.35 * length * camera.axes[:2, i]), "xyz"[i], **_text(9, color))


def _text(size, color="black"):
    return {"fontsize": size, "color": color, "ha": "center", "va": "center"}


def _scale_bar(axes, camera: Camera):
    left, right, bottom, top = camera.extent
    length = round_length((right - left) / 4)
    x, y = left + 0.03 * (right - left), bottom + 0.03 * (top - bottom)
    for color, thickness in (("white", 6), ("black", 3)):  # also over the mesh
        ends = [x, x + length], [y, y]
        axes.plot(*ends, color=color, linewidth=thickness, solid_capstyle="butt")
    name = "%g km" % (length / 1000) if length >= 1000 else "%g m" % length
    middle = x + length / 2, y + 0.01 * (top - bottom)
    plate = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1}
    axes.annotate(name, middle, **dict(_text(9), va="bottom"), bbox=plate)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)


def round_length(most):
    """The greatest 1, 2 or 5 times a power of ten that is not above most."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(power * step for step in (5, 2, 1) if power * step <= most or step == 1)


def _legend(figure, axes, legend, inner, size):
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.patches import Patch

    width, height = size
    below = 0
    if legend.entries:
        shown = list(legend.entries)
        rows = min(_ENTRIES, max(2, inner[3] // 18 - 1))
        if len(shown) > rows:
            more = "and %d more" % (len(shown) - rows + 1)
            shown = shown[: rows - 1] + [(more, (1.0, 1.0, 1.0))]
        below = 18 * len(shown) + 20
        axes.legend(
            handles=[Patch(color=color, label=_plain(text, _LETTERS)) for text, color in shown],
            title=None if legend.limits else _plain(legend.title, _TITLE_LETTERS),
            loc="lower left" if legend.limits else "upper left",
            bbox_to_anchor=(1.0 + _BESIDE / inner[2], 0 if legend.limits else 1),
            borderaxespad=0,
            fontsize=_POINTS,
            title_fontsize=_POINTS,
            frameon=False,
            handlelength=1.2,
        )
    if legend.limits is None:
        return
    low, high = legend.limits
    if low == high:  # a bar needs a length
        high = low + (abs(low) or 1.0) * 1e-6
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}
    colors = ListedColormap(scale_colors(legend.stops, np.linspace(0, 1, 256)))
    box = [inner[0] + inner[2] + 16, inner[1] + below, 16, max(30, inner[3] - below)]
    bar = figure.colorbar(
        ScalarMappable(Normalize(low, high), colors),
        cax=figure.add_axes([box[0] / width, box[1] / height, box[2] / width, box[3] / height]),
        extend=extend[tuple(map(int, legend.beyond))],
    )
    bar.ax.tick_params(labelsize=8)
    bar.set_label(_plain(legend.title, max(4, min(60, int(box[3]) // 8))), fontsize=9)
    if legend.limits[0] == legend.limits[1]:
        bar.set_ticks([low])
        bar.set_ticklabels(["%g" % low])
