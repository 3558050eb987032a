"""The edges of faces, each with the sides of the faces that meet there."""
from typing import NamedTuple

import numpy as np


class Edges(NamedTuple):
    """The three sides of each face, sorted so that the sides at one edge are beside each other.

    low, high: (3N,) int64 vertices, low < high; forward: (3N,) the face runs from low to high;
    side: (3N,) 3 * face + number; start: (E,) first of each edge; count: (E,) sides of each edge.
    """

    low: np.ndarray
    high: np.ndarray
    forward: np.ndarray
    side: np.ndarray
    start: np.ndarray
    count: np.ndarray


def edges_of(faces: np.ndarray, kept: np.ndarray) -> Edges:
    """The edges of the kept faces (indices) of faces (F, 3)."""
    tail = faces[kept].astype(np.int64)
    head = np.roll(tail, -1, axis=1).ravel()
    tail = tail.ravel()
    side = (3 * kept[:, None] + np.arange(3)).ravel()
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    key = (low.astype(np.uint64) << np.uint64(32)) | high.astype(np.uint64)
    order = np.argsort(key, kind="stable")
    key = key[order]
    start = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])) if len(key) else order
    count = np.diff(np.concatenate([start, [len(key)]]))
    return Edges(low[order], high[order], (tail < head)[order], side[order], start, count)
