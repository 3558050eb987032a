"""Where the surface is blocked at one moment."""

import copy
import math
from typing import Iterator, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.surface import barycentric_coordinates
from mesh_map.spatial.hits import NO_FACE

from mesh_navigation.body.near_obstacles import NO_OBSTACLES, NearObstacles

# A robot that stands on blocked ground may leave it by a way this short (m): it was pushed there,
# or what was marked is next to it. Ground that only costs too much it may also leave by a longer
# one, over costs that fall within this length, and fall on.
ESCAPE, FALL = 0.2, 0.5


class Stretch(NamedTuple):
    """A part of a way that is blocked."""

    begin: float
    """m, along the way."""
    end: float
    cost: float
    """Of the ground there; inf where it is lethal or unknown."""


class LocalCosts:
    """The costs of one moment, looked at only where a way goes.

    A point is blocked where the corner with the largest weight in its face (barycentric
    coordinates) is lethal or unknown, or costs more than the limit. In the face of the goal nothing
    is, unless the corner nearest to the goal is: that is how planners tell whether a goal is
    blocked. Where a body has obstacles, a point that is too near to them is blocked, too.
    """

    def __init__(
        self,
        geometry: MeshGeometry,
        costs: np.ndarray,
        goal_face: int,
        goal: np.ndarray,
        cost_limit: float = math.inf,
        obstacles: NearObstacles = NO_OBSTACLES,
        lead: float = 0.0,
    ) -> None:
        """Args:
        geometry: of the map.
        costs: (V,) of the map; what is not finite is blocked.
        goal_face: the face of the goal.
        goal: (3,) its position (m).
        cost_limit: what costs more is blocked.
        obstacles: of the robot's body.
        lead: how far ground that only costs too much is not blocked (m), because the plan leads
            out of it.
        """
        self._lead = lead
        self._vertices, self._faces, self._costs = geometry.vertices, geometry.faces, costs
        self._limit, self.obstacles = min(cost_limit, np.finfo(np.float32).max), obstacles
        corners = geometry.faces[goal_face]
        distances = [math.dist(corner, goal) for corner in geometry.vertices[corners].tolist()]
        free = costs[corners[distances.index(min(distances))]] <= self._limit
        self._open_face = goal_face if free else NO_FACE

    def keeping(self, distance: float) -> "LocalCosts":
        """The same, with another distance to keep from obstacles (m)."""
        made = copy.copy(self)
        made.obstacles = self.obstacles.keeping(distance)
        return made

    def first_blocked(self, points: np.ndarray, faces: np.ndarray) -> Optional[float]:
        """How far it is along a way to where it is blocked (m), None if it is nowhere.

        A way that begins on blocked ground may leave it, see `ESCAPE`; over ground that only costs
        too much, as far as the plan leads.

        Args:
            points: (N,3) m.
            faces: (N - 1,) the face in which point i to i + 1 lies; NO_FACE where there is none.
        """
        found = self._first_closed(points, faces), self.obstacles.first_near(points, faces)
        return min((length for length in found if length is not None), default=None)

    def _first_closed(self, points: np.ndarray, faces: np.ndarray) -> Optional[float]:
        # take() is faster than indices in brackets; NO_FACE, which _blocked leaves out, is clipped.
        corners = self._faces.take(faces, axis=0, mode="clip")
        costs = self._costs.take(corners)
        free = costs <= self._limit
        if free.all():
            return None
        costs = np.where(np.isnan(costs), np.inf, costs)
        end_of_escape, cost, fallen = 0.0, math.inf, 0.0
        for stretch in self._blocked(points, faces, free, costs):
            if stretch.begin < self._lead and math.isfinite(stretch.cost):
                end_of_escape, cost, fallen = stretch.end, stretch.cost, stretch.end
                continue
            if stretch.begin > end_of_escape + 1e-6 or stretch.cost > cost:
                return stretch.begin
            if stretch.cost < cost:
                cost, fallen = stretch.cost, stretch.begin
            end_of_escape = stretch.end
            if end_of_escape - fallen > (FALL if math.isfinite(cost) else ESCAPE):
                return 0.0
        return None

    def _blocked(
        self, points: np.ndarray, faces: np.ndarray, free: np.ndarray, costs: np.ndarray
    ) -> Iterator[Stretch]:
        """The stretches that are blocked, in each face by itself, in the order of the way."""
        mixed = ~free.all(axis=1) & (faces != NO_FACE) & (faces != self._open_face)
        chosen = np.flatnonzero(mixed)
        if not len(chosen):
            return
        lengths = np.sqrt(np.square(points[1:] - points[:-1]).sum(axis=1))
        begins = np.cumsum(lengths) - lengths
        corners = self._vertices[self._faces[faces[chosen]]][:, None].astype(np.float64)
        ends = np.stack([points[chosen], points[chosen + 1]], axis=1)
        around = barycentric_coordinates(ends, *np.moveaxis(corners, 2, 0))
        # Numbers of Python are faster than those of NumPy, one by one.
        columns = (begins, lengths, free, costs)
        rows = zip(*(column[chosen].tolist() for column in columns), around.tolist())
        for start, length, is_free, cost, (first, last) in rows:
            parts = []
            for corner in range(3):
                part = None if is_free[corner] else _largest(first, last, corner)
                if part is not None:
                    parts.append((*part, cost[corner]))
            for begin, end, highest in sorted(parts):
                yield Stretch(start + begin * length, start + end * length, highest)


def _largest(
    first_weights: Sequence[float], last_weights: Sequence[float], corner: int
) -> Optional[Tuple[float, float]]:
    """Where between two points (0 to 1), of which the weights of three corners are given, one
    corner's weight is the largest; None: nowhere."""
    begin, end = 0.0, 1.0
    for other in range(3):
        if other == corner:
            continue
        first = first_weights[corner] - first_weights[other]
        last = last_weights[corner] - last_weights[other]
        if first < 0.0 and last < 0.0:
            return None
        if first < 0.0:
            begin = max(begin, first / (first - last))
        elif last < 0.0:
            end = min(end, first / (first - last))
    return (begin, end) if begin < end else None
