"""What a cloud of points says about the space between the sensor and what it measured."""

from typing import Any

import numpy as np


class CloudView:
    """A range image of one cloud, seen from the sensor.

    Directions are divided into cells of nearly the same width in both angles (fewer columns in rows
    far from the horizon). In each, what counts is how far the farthest measurement is, and how near
    the nearest one that could hide something: all but those on the ground, which in a flat view lie
    before and below whatever stands on it.

    A point is seen past where something in its cell was measured beyond it, and nothing in the cell
    at it or before it. Where nothing was measured, nothing is known.
    """

    def __init__(self, offsets: Any, ground: Any, cell_angle: float) -> None:
        """Args:
        offsets: (N, 3) finite, from the sensor to the points, meters.
        ground: (N,) bool, points that hide nothing.
        cell_angle: width of a cell in radians.
        """
        self._rows = max(int(np.ceil(np.pi / cell_angle)), 1)
        middles = (np.arange(self._rows) + 0.5) / self._rows * np.pi - np.pi / 2
        columns = np.ceil(2 * np.pi / cell_angle * np.cos(middles)).astype(np.int64)
        self._columns = np.maximum(columns, 1)
        self._starts = np.cumsum(self._columns) - self._columns
        self._offsets = np.asarray(offsets, np.float64)
        self._ground = np.asarray(ground, np.bool_)
        self._ranges = _lengths(self._offsets)
        self._cells = self._cells_of(self._offsets, self._ranges)

    def sees_past(self, offsets: Any, margin: float) -> np.ndarray:
        """Whether each of M points is seen past, (M,) bool.

        Args:
            offsets: (M, 3) finite, from the sensor to the points, meters.
            margin: meters that a measurement has to be beyond a point.
        """
        asked = np.asarray(offsets, np.float64)
        ranges = _lengths(asked)
        cells = self._cells_of(asked, ranges)
        count = int(self._starts[-1] + self._columns[-1])
        of_interest = np.zeros(count, np.bool_)
        of_interest[cells] = True
        seen = of_interest[self._cells] & (self._ranges > 0)
        hiding = seen & ~self._ground
        farthest, nearest = np.full(count, -np.inf), np.full(count, np.inf)
        np.maximum.at(farthest, self._cells[seen], self._ranges[seen])
        np.minimum.at(nearest, self._cells[hiding], self._ranges[hiding])
        beyond = ranges + margin
        return (ranges > 0) & (farthest[cells] > beyond) & (nearest[cells] > beyond)

    def _cells_of(self, offsets: np.ndarray, ranges: np.ndarray) -> np.ndarray:
        elevation = np.arcsin(np.clip(offsets[:, 2] / np.where(ranges > 0, ranges, 1.0), -1, 1))
        azimuth = np.arctan2(offsets[:, 1], offsets[:, 0])
        row = _numbered(elevation / np.pi + 0.5, self._rows)
        column = _numbered(azimuth / (2 * np.pi) + 0.5, self._columns[row])
        return self._starts[row] + column


def _lengths(offsets: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("ij,ij->i", offsets, offsets))


def _numbered(share: np.ndarray, count: Any) -> np.ndarray:
    """The cell of `count` equal ones from 0 to 1 in which each share lies."""
    return np.minimum((share * count).astype(np.int64), count - 1)
