"""Colors of numbers, as the displays in RViz have them (piecewise linear between equal stops)."""
from typing import Tuple

import numpy as np

RAINBOW = np.array([[1, 0, 1], [0, 0, 1], [0, 1, 1], [0, 1, 0], [1, 1, 0], [1, 0, 0]], float)
RED_GREEN = np.array([[0, 1, 0], [1, 1, 0], [1, 0, 0]], float)
SCALES = {"rainbow": RAINBOW, "redgreen": RED_GREEN}
# far from all colors of all scales; the same as in RViz
UNKNOWN = (104 / 255, 78 / 255, 40 / 255)
LETHAL = (255 / 255, 20 / 255, 147 / 255)


def scale_colors(stops: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """(N, 3) red, green, blue from 0 to 1 of positions (N,); below 0 is 0, above 1 is 1."""
    at = np.linspace(0, 1, len(stops))
    return np.stack([np.interp(positions, at, stops[:, i]) for i in range(3)], axis=1)


def value_colors(stops: np.ndarray, limits: Tuple[float, float], values: np.ndarray) -> np.ndarray:
    """(N, 3) of values (N,): NaN is UNKNOWN, +inf LETHAL, -inf the scale's first color."""
    low, high = limits
    span = high - low or np.inf  # one value only has the first color, as in RViz
    finite = np.where(np.isfinite(values), values, low)
    colors = scale_colors(stops, (finite - low) / span)
    colors[np.isnan(values)] = UNKNOWN
    colors[values == np.inf] = LETHAL
    return colors


def finite_limits(values: np.ndarray) -> Tuple[float, float]:
    """The least and greatest finite value; (0, 0) if there is none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
