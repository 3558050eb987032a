"""Where on the mesh a pose stands, and whether a robot may stand there."""

from typing import List, NamedTuple, Optional

import numpy as np

from mesh_map.costs.cleared_costs import ClearedCosts
from mesh_map.geometry.surface import barycentric_coordinates
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.pose import number_text, vector_text
from mesh_navigation.body.robot_shape import MAX_DISTANCE
from mesh_navigation.plugins.planner import PlanFailure
from mesh_navigation.surface.slowness import passable


class FacePoint(NamedTuple):
    """A point of the surface."""

    position: np.ndarray
    """(3,) float64, m."""
    face: int
    """The face it lies in."""
    corners: np.ndarray
    """(3,) vertices of that face, the nearest first."""
    distances: np.ndarray
    """(3,) float64, m: straight ways within the face from the point to these corners."""

    @classmethod
    def at(cls, mesh_map: MeshMap, face: int, position: np.ndarray) -> "FacePoint":
        """That of a point of a face."""
        position = np.asarray(position, dtype=np.float64)
        corners = mesh_map.faces[face].astype(np.int64)
        distances = np.linalg.norm(mesh_map.vertices[corners].astype(np.float64) - position, axis=1)
        order = np.argsort(distances, kind="stable")
        return cls(position, int(face), corners[order], distances[order])

    def weights(self, mesh_map: MeshMap) -> np.ndarray:
        """(3,) barycentric coordinates of the point, by corner; all at the nearest one where the
        face has no area."""
        corners = mesh_map.vertices[self.corners].astype(np.float64)
        weights = np.clip(barycentric_coordinates(self.position, *corners), 0.0, 1.0)
        if not np.isfinite(weights).all():
            return np.array([1.0, 0.0, 0.0])
        return weights / weights.sum()


def find_face_point(mesh_map: MeshMap, position: np.ndarray, what: str, outcome: int) -> FacePoint:
    """The closest point of the surface.

    Args:
        mesh_map: the map.
        position: (3,) m.
        what: "start" or "goal", for the message.
        outcome: of the failure if there is none.

    Raises:
        PlanFailure: no surface within `MAX_DISTANCE`.
    """
    found = mesh_map.closest_face(position, MAX_DISTANCE)
    if found is None:
        raise PlanFailure(outcome, _off_map(mesh_map, position, what))
    return FacePoint.at(mesh_map, found.face, found.position)


def _off_map(mesh_map: MeshMap, position: np.ndarray, what: str) -> str:
    where = f"{what} {vector_text(position)} is"
    nearest = mesh_map.closest_face(position, np.inf)
    if nearest is None:
        return f"{where} too far from the map to tell how far"
    distance = number_text(nearest.distance)
    return (
        f"{where} {distance} m from the map, allowed are {MAX_DISTANCE:.2f} m; "
        f"the surface is nearest at {vector_text(nearest.position)}"
    )


def obstacle_at(
    mesh_map: MeshMap,
    vertex: int,
    cost: float,
    cost_limit: float,
    cleared: Optional[ClearedCosts] = None,
) -> Optional[str]:
    """Why a vertex of this cost must not be passed, as a phrase with the layer's name, or None.

    Args:
        mesh_map: the map.
        vertex: the index.
        cost: for the robot's middle.
        cost_limit: what costs more is not passed.
        cleared: where the cost is of these; None: of the map as it is.
    """
    if passable(cost, cost_limit):
        return None
    if cleared is None:
        results = {name: layer.result for name, layer in mesh_map.layers.items()}
        costs = mesh_map.planning_costs().costs
    else:
        results, costs = dict(cleared.results), cleared.planning.costs
    if np.isnan(cost):
        culprits = [name for name, result in results.items() if np.isnan(result.costs[vertex])]
        return "unknown (NaN)" + _in_layers(culprits)
    if np.isinf(cost):
        culprits = [name for name, result in results.items() if result.lethal[vertex]]
        return "lethal" + _in_layers(culprits)
    if passable(costs[vertex], cost_limit):
        return "nearer than the robot's radius to lethal or unknown ground"
    culprits = [name for name, result in results.items() if result.costs[vertex] > 0]
    if np.isfinite(costs[vertex]):
        cost = float(costs[vertex])  # not what the body makes of it
    return f"of cost {cost:.3g}, over the cost limit {cost_limit:.3g}" + _in_layers(culprits)


def _in_layers(names: List[str]) -> str:
    if not names:
        return ""
    return f" in layer{'s' if len(names) > 1 else ''} {', '.join(names)}"
