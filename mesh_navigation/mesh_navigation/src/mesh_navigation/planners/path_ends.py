"""Where a path may begin and end: checked poses, and what is near a goal that cannot be reached."""

from typing import Dict, Hashable, List, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.costs.cleared_costs import ClearedCosts
from mesh_map.distance.surface_path import SurfacePath
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.path import SAME_POINT
from mesh_navigation.base.pose import number_text, vector_text
from mesh_navigation.planners.escape_paths import EscapePath
from mesh_navigation.plugins.planner import PlanFailure
from mesh_navigation.surface.face_points import FacePoint, find_face_point, obstacle_at
from mesh_navigation.surface.slowness import CostSnapshot


class PathEnd(NamedTuple):
    """Start or goal on the surface."""

    face_point: FacePoint
    corner_paths: List[Tuple[int, float]]
    """Passable corners of its face with the length of the straight way to each (m)."""
    remark: str = ""
    """What to tell where this is not the place asked for."""
    lead: Optional[SurfacePath] = None
    """Of a start on closed ground: the way from there to this one."""

    @property
    def position(self) -> np.ndarray:
        """(3,) m."""
        return self.face_point.position

    @property
    def vertices(self) -> List[int]:
        """The passable corners."""
        return [vertex for vertex, _ in self.corner_paths]

    @property
    def whole(self) -> bool:
        """Whether its face may be crossed anywhere."""
        return len(self.corner_paths) == 3

    @property
    def key(self) -> Hashable:
        """Equal for places from which a search finds the same."""
        return self.face_point.face, self.position.tobytes(), tuple(self.vertices)

    def sees(self, other: "PathEnd") -> bool:
        """Whether the straight way to another place of the same face may be taken.

        It may where the face may be crossed anywhere. Where a corner is blocked, all of the way has
        to be nearer to the same passable corner.
        """
        if self.face_point.face != other.face_point.face:
            return False
        here, there = self._distances(), other._distances()
        blocked = [vertex for vertex in here if vertex not in self.vertices]
        return any(
            all(here[near] <= here[far] and there[near] <= there[far] for far in blocked)
            for near in self.vertices
        )

    def _distances(self) -> Dict[int, float]:
        return dict(zip(self.face_point.corners.tolist(), self.face_point.distances.tolist()))


def find_path_end(
    mesh_map: MeshMap,
    position: np.ndarray,
    snapshot: CostSnapshot,
    what: str,
    outcome: int,
    cleared: Optional[ClearedCosts] = None,
) -> PathEnd:
    """The place of the surface that is nearest to a position.

    If that is at an edge or a vertex, or several surfaces are there, as the bottom of a thing that
    stands on the floor, in a face there that may be crossed, where there is one.

    Args:
        mesh_map: the map.
        position: (3,) m.
        snapshot: what may be passed.
        what: "start" or "goal", for the message.
        outcome: of a failure.
        cleared: what the snapshot is of; None: of the map as it is.

    Raises:
        PlanFailure: it is too far from the surface, or blocked.
    """
    face_point = find_face_point(mesh_map, position, what, outcome)
    place = _path_end(face_point, snapshot)
    if place.whole:
        return place
    found = mesh_map.spatial_index.closest(
        point=face_point.position, max_distance=SAME_POINT, mask=snapshot.open_faces
    )
    if found is not None:
        return _path_end(FacePoint.at(mesh_map, *found[:2]), snapshot)
    if not snapshot.passable[face_point.corners[0]]:
        text = blocked_text(mesh_map, face_point, snapshot, cleared)
        raise PlanFailure(outcome, f"{what} {text}")
    return place


def blocked_text(
    mesh_map: MeshMap,
    face_point: FacePoint,
    snapshot: CostSnapshot,
    cleared: Optional[ClearedCosts] = None,
) -> str:
    """Where it is, and why nobody may stand there, as the end of a sentence; arguments as of
    `find_path_end`."""
    vertex = int(face_point.corners[0])
    cost, limit = float(snapshot.costs[vertex]), snapshot.cost_limit
    return (
        f"{vector_text(face_point.position)} is blocked: its nearest vertex {vertex}, "
        f"{face_point.distances[0]:.2f} m away, is "
        f"{obstacle_at(mesh_map, vertex, cost, limit, cleared)}"
    )


def escaped_path_end(mesh_map: MeshMap, escape: EscapePath, snapshot: CostSnapshot) -> PathEnd:
    """Where a way out of closed ground ends; the path leads there first."""
    place = mesh_map.vertices[escape.vertex].astype(np.float64)
    end = find_path_end(mesh_map, place, snapshot, "", GetPathOutcome.INVALID_START)
    remark = f"; it begins on closed ground, which it leaves after {escape.path.length:.2f} m"
    return end._replace(lead=escape.path, remark=remark)


def nearest_path_end(
    mesh_map: MeshMap,
    position: np.ndarray,
    tolerance: float,
    reached: np.ndarray,
    snapshot: CostSnapshot,
    failure: PlanFailure,
) -> PathEnd:
    """What to take for a goal that cannot be reached: the nearest place within the tolerance.

    Args:
        mesh_map: the map.
        position: (3,) m, the goal.
        tolerance: m.
        reached: (V,) bool: vertices to which a way leads from the start.
        snapshot: what may be passed.
        failure: why it is not the goal itself.

    Raises:
        PlanFailure: nothing can be reached within the tolerance; that failure, with more words.
    """
    best, distance = None, tolerance
    faces = reached[mesh_map.faces].all(axis=1)
    found = mesh_map.spatial_index.closest(point=position, max_distance=tolerance, mask=faces)
    if found is not None:
        best = _path_end(FacePoint.at(mesh_map, found.face, found.position), snapshot)
        distance = found.distance
    distances = np.linalg.norm(mesh_map.vertices - position, axis=1)
    near = np.flatnonzero((distances <= tolerance) & reached)
    if len(near) and distances[near].min() < distance - 1e-6:
        vertex = int(near[np.argmin(distances[near])])
        best, distance = _path_end_at_vertex(mesh_map, vertex), distances[vertex]
    if best is None:
        count = int(np.count_nonzero(distances <= tolerance))
        raise PlanFailure(
            failure.outcome,
            f"{failure.message}; of {count} vertices within the tolerance of "
            f"{number_text(tolerance)} m none can be reached",
            failure.potential,
        )
    remark = (
        f"; it ends {number_text(distance)} m from the goal "
        f"(tolerance {number_text(tolerance)} m), because {failure.message}"
    )
    return best._replace(remark=remark)


def _path_end(face_point: FacePoint, snapshot: CostSnapshot) -> PathEnd:
    usable = snapshot.passable[face_point.corners]
    corners = zip(face_point.corners[usable], face_point.distances[usable])
    return PathEnd(face_point, [(int(vertex), float(distance)) for vertex, distance in corners])


def _path_end_at_vertex(mesh_map: MeshMap, vertex: int) -> PathEnd:
    face = int(mesh_map.topology.faces_of(vertex)[0])
    position = mesh_map.vertices[vertex].astype(np.float64)
    return PathEnd(FacePoint.at(mesh_map, face, position), [(vertex, 0.0)])
