"""The colors of a potential in a picture, with isolines."""

import math

import numpy as np
from mesh_msgs_hdf5.rendering.render_paint import PLAIN, Legend
from mesh_msgs_hdf5.rendering.render_scale import RAINBOW, finite_limits, value_colors

CLOSED = (0.38, 0.38, 0.38)
_LINES = 16  # of the potential in a picture, about
_LINE_WIDTH = 1.3  # pixels
_LINE_SHADE = 0.55  # of the color beside it
_STEEPEST = 8.0  # change of the potential per meter seen from above: lines get no wider there


class PotentialPaint:
    """A paint for mesh_msgs_hdf5.rendering (see render_paint there)."""

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        potential: np.ndarray,
        passable: np.ndarray,
        pixels: int,
    ) -> None:
        """
        Args:
            vertices, faces: (V,3) m and (F,3): what is shown.
            potential: (V,) inf where it is not known.
            passable: (V,) bool; other vertices are shown as closed.
            pixels: along the longer side of the picture.
        """
        self._faces, self._passable = faces, passable
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
        self.legend = Legend(title if bar else "no potential", bar, RAINBOW, tuple(entries))

    def colors(self, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(N,3) of points on the faces (N,) where the corners have the weights (N,3)."""
        corners = self._faces[face]
        known = self._known[corners]
        share = np.where(known, weights, 0)
        total = share.sum(axis=1)
        values = np.where(known, self._potential[corners], 0)
        value = (values * share).sum(axis=1) / np.where(total > 0, total, 1)
        colors = value_colors(RAINBOW, self._limits, value)
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
    """(F,) how much values (V,) change per meter seen from above; 0 where one is not known."""
    a, b, c = (vertices[faces[:, i], :2].astype(np.float64) for i in range(3))
    u, v, w = (values[faces[:, i]] for i in range(3))
    b, c, v, w = b - a, c - a, v - u, w - u
    area = b[:, 0] * c[:, 1] - c[:, 0] * b[:, 1]
    x = v * c[:, 1] - w * b[:, 1]
    y = w * b[:, 0] - v * c[:, 0]
    slopes = np.hypot(x, y) / np.where(area != 0, np.abs(area), np.inf)
    return np.minimum(np.nan_to_num(slopes, nan=0.0), _STEEPEST)
