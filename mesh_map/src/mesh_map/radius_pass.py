"""Statistics of the surroundings of each vertex: height difference, roughness, ridge."""

from typing import Dict, Set

import numpy as np

STATISTICS = ("height_difference", "roughness", "ridge")


class RadiusPass:
    """What is computed over the vertices around each vertex within a radius."""

    def __init__(self, geometry, radius: float) -> None:
        self._geometry = geometry
        self._radius = float(radius)
        self._wanted: Set[str] = set()
        self._results: Dict[str, np.ndarray] = {}

    def request(self, *wanted: str) -> None:
        """What will be asked for, so that one pass gives all of it."""
        for name in wanted:
            if name not in STATISTICS:
                raise ValueError("%r is none of %s" % (name, ", ".join(STATISTICS)))
        self._wanted.update(wanted)

    def height_difference(self) -> np.ndarray:
        return self._get("height_difference")

    def roughness(self) -> np.ndarray:
        return self._get("roughness")

    def ridge(self) -> np.ndarray:
        return self._get("ridge")

    def _get(self, name: str) -> np.ndarray:
        if name not in self._results:
            self._compute(self._wanted | {name})
        return self._results[name]

    def _compute(self, wanted: Set[str]) -> None:
        g = self._geometry
        t = g.topology
        count = len(g.vertices)
        p = g.vertices.astype(np.float64)
        n = g.vertex_normals.astype(np.float64)
        a, b = t.edges[:, 0], t.edges[:, 1]
        angle = np.arccos(np.clip(np.einsum("ij,ij->i", n[a], n[b]), -1, 1))
        degree = np.bincount(t.edges.ravel(), minlength=count)
        mean = np.bincount(t.edges.ravel(), np.repeat(angle, 2), count) / np.maximum(degree, 1)
        offsets = t.neighbor_offsets.astype(np.int64)
        seen = front = np.arange(count, dtype=np.int64) * (count + 1)
        while len(front):
            center, at = front // count, front % count
            lengths = offsets[at + 1] - offsets[at]
            first = np.repeat(offsets[at] - np.cumsum(lengths) + lengths, lengths)
            to = t.neighbors[first + np.arange(lengths.sum())].astype(np.int64)
            center = np.repeat(center, lengths)
            near = ((p[to] - p[center]) ** 2).sum(1) < self._radius**2
            front = np.setdiff1d(center[near] * count + to[near], seen)
            seen = np.union1d(seen, front)
        center, around = seen // count, seen % count
        starts = np.flatnonzero(np.diff(center, prepend=-1))
        h = p @ g.up
        found = {
            "height_difference": np.maximum.reduceat(h[around], starts)
            - np.minimum.reduceat(h[around], starts),
            "roughness": np.add.reduceat(mean[around], starts) / np.bincount(center),
            "ridge": np.add.reduceat(
                np.linalg.norm(p[around] + n[around] - p[center] - n[center], axis=1), starts
            )
            / np.maximum(np.bincount(center) - 1, 1),
        }
        for name in wanted:
            self._results[name] = found[name].astype(np.float32)
