"""Which layers close the ground that a plan does not get over."""

from typing import List, Mapping

import numpy as np

from mesh_map.costs.layer import LayerResult
from mesh_map.geometry.topology import Topology
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.body.robot_shape import MAX_DISTANCE
from mesh_navigation.surface.face_points import FacePoint
from mesh_navigation.surface.slowness import CostSnapshot, passable


def rim(topology: Topology, reached: np.ndarray) -> np.ndarray:
    """(K,) int64, ascending: the vertices beside those that were reached, (V,) bool."""
    around = _neighbors(topology, np.flatnonzero(reached))
    return around[~reached[around]]


def at_goal(mesh_map: MeshMap, position: np.ndarray, snapshot: CostSnapshot) -> np.ndarray:
    """(K,) int64: the vertices that close a goal; none where it is off the map.

    Args:
        mesh_map: the map.
        position: (3,) m, of the goal.
        snapshot: what may be passed.
    """
    found = mesh_map.closest_face(position, MAX_DISTANCE)
    if found is None:
        return np.zeros(0, np.int64)
    corners = FacePoint.at(mesh_map, found.face, found.position).corners
    return corners[snapshot.passable[corners].argmin() :][:1]


def blocking_layers(
    topology: Topology,
    results: Mapping[str, LayerResult],
    costs: np.ndarray,
    snapshot: CostSnapshot,
    vertices: np.ndarray,
    nearest: bool = False,
) -> List[str]:
    """Names of the layers that close these vertices, in their order: in which they are lethal or
    unknown, or cost something where the limit is exceeded; and of closed ground around what is
    lethal or unknown, the layers in which that is.

    Args:
        topology: of the map.
        results: of its layers.
        costs: (V,) of the map.
        snapshot: what the robot's middle may pass.
        vertices: (K,) indices; those that may be passed do not count.
        nearest: of what is lethal around them, only the nearest counts.
    """
    vertices = np.asarray(vertices, np.int64)
    near = vertices[~snapshot.passable[vertices]]
    costly = near[np.isfinite(costs[near]) & ~passable(costs[near], snapshot.cost_limit)]
    lethal = near[:0]
    seen = np.zeros(len(costs), np.bool_)
    while len(near) and not (nearest and len(lethal)):
        seen[near] = True
        is_lethal = ~np.isfinite(costs[near])
        lethal = np.union1d(lethal, near[is_lethal])
        around = _neighbors(topology, near[~is_lethal])
        near = around[~seen[around] & ~snapshot.passable[around]]
    return [
        name
        for name, result in results.items()
        if np.any(result.lethal[lethal] | np.isnan(result.costs[lethal]))
        or np.any(result.costs[costly] > 0)
    ]


def _neighbors(topology: Topology, vertices: np.ndarray) -> np.ndarray:
    """(N,) int64, ascending: of all these vertices."""
    return np.unique(topology.neighbors[topology.neighbor_places(vertices)]).astype(np.int64)
