"""Costs as the middle of a robot has to take them: what is nearer to lethal ground than its
inscribed radius is closed."""

import threading
from typing import Optional

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.geometry.mesh_geometry import MeshGeometry

CLOSED = 100.0  # the least cost of ground that is closed: above any cost_limit


class ClosedGround:
    """Of one map, for one radius; from any thread.

    A path over vertices that are open and the edges and faces between them keeps the radius all
    along: of an edge that comes nearer, the end that is nearer to lethal ground is closed, too.
    Distances are along the surface, from lethal vertices and unknown ones.
    """

    def __init__(self, geometry: MeshGeometry, radius: float) -> None:
        """
        Args:
            geometry: of the map.
            radius: of the robot (m); 0: nothing is closed.
        """
        self._geometry, self._radius = geometry, radius
        self._lock = threading.Lock()
        self._distance: Optional[ObstacleDistance] = None
        self._least = np.zeros(0, np.float32)  # (V,) of the costs: 0 where the ground is open
        self._given: Optional[np.ndarray] = None
        self._costs: Optional[np.ndarray] = None

    def costs(self, costs: np.ndarray) -> np.ndarray:
        """(V,) float32, read-only: costs of the map, at least `CLOSED` where the ground is closed,
        falling with the distance from what is lethal. For the same array the same one.

        After a change of costs, only what is around it is looked at.

        Args:
            costs: (V,) of the map.
        """
        if not self._radius > 0.0:
            return costs
        with self._lock:
            if self._costs is None or costs is not self._given:
                self._follow(~np.isfinite(costs))
                self._given, self._costs = costs, read_only(np.maximum(costs, self._least))
            return self._costs

    def distances(self, costs: np.ndarray) -> np.ndarray:
        """(V,) float32: m along the surface from what is lethal or unknown; +inf from the radius
        and the length of the longest edge on, everywhere where the radius is 0.

        Args:
            costs: (V,) of the map, or what `costs` made of them.
        """
        if not self._radius > 0.0:
            return np.full(len(costs), np.inf, np.float32)
        with self._lock:
            if self._distance is None or (costs is not self._given and costs is not self._costs):
                self._follow(~np.isfinite(costs))
                self._given = self._costs = None
            assert self._distance is not None
            return self._distance.distances()

    def _follow(self, blocked: np.ndarray) -> None:
        topology = self._geometry.topology
        if self._distance is None:
            # Who is farther away than that has no edge that comes too near.
            farthest = self._radius + float(self._geometry.edge_lengths.max(initial=0.0))
            distance = ObstacleDistance(
                front=SurfaceFront.of(self._geometry), max_distance=farthest
            )
            distance.compute(blocked)
            self._distance, self._farthest = distance, np.float32(farthest)
            self._least = np.zeros(len(blocked), np.float32)
            changed = np.flatnonzero(np.isfinite(distance.distances()))
        else:
            changed = self._distance.update(blocked).astype(np.int64)
        if not len(changed):
            return
        around = topology.neighbors[topology.neighbor_places(changed)]
        vertices = np.union1d(changed, around).astype(np.int64)
        distances = np.minimum(self._distance.distances(), self._farthest)
        self._least[vertices] = self._least_costs(vertices, distances)

    def _least_costs(self, vertices: np.ndarray, distances: np.ndarray) -> np.ndarray:
        own = distances[vertices]
        closed = own < self._radius
        rest = vertices[~closed]
        closed[~closed] = self._has_close_edge(rest, distances)
        depth = np.maximum(1.0 - own / self._radius, 0.0)
        return np.where(closed, CLOSED * (1.0 + depth), 0.0).astype(np.float32)

    def _has_close_edge(self, vertices: np.ndarray, distances: np.ndarray) -> np.ndarray:
        """(K,) bool, of vertices (K,): which are the ends, nearer to what is lethal than the other
        ones, of edges that come nearer than the radius.

        What is lethal is outside of the circles around both ends with their distances, so that it
        is no nearer to the edge than where these circles meet.
        """
        topology = self._geometry.topology
        places = topology.neighbor_places(vertices)
        offsets = topology.neighbor_offsets
        counts = (offsets[vertices + 1] - offsets[vertices]).astype(np.int64)
        ends, others = np.repeat(vertices, counts), topology.neighbors[places].astype(np.int64)
        lengths = self._geometry.edge_lengths[topology.neighbor_edges[places]].astype(np.float64)
        near, far = distances[ends].astype(np.float64), distances[others].astype(np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            foot = (near * near - far * far + lengths * lengths) / (2.0 * lengths)
            between = (foot > 0.0) & (foot < lengths)
            close = between & (near * near - foot * foot < self._radius * self._radius)
        close &= (near < far) | ((near == far) & (ends < others))
        found = np.zeros(len(vertices), np.bool_)
        found[np.repeat(np.arange(len(vertices)), counts)[close]] = True
        return found
