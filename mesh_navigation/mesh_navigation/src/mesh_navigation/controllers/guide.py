"""Which way to go from where the robot is: down the field of the plan, or along its path."""

import math
from typing import Any, List, NamedTuple, Optional

import numpy as np

from mesh_map.distance.surface_path import FieldTracer
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk import WalkEnd
from mesh_map.map.queries import SurfaceQueries
from mesh_map.spatial.hits import NO_FACE, SurfacePoint, SurfacePoints

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.path import SAME_POINT
from mesh_navigation.base.pose import number_text, vector_text
from mesh_navigation.controllers.local_costs import LocalCosts
from mesh_navigation.controllers.surface_pose import MAX_STEPS, SAME_SHEET, SurfacePose
from mesh_navigation.controllers.vector3 import inside
from mesh_navigation.controllers.local_path import LocalPath
from mesh_navigation.plugins.controller import ControlFailure, ControllerPlan

_BACK, _AHEAD = 0.5, 2.0  # m around the last place on the path, where the next one is looked for
_RETURN = 0.5  # m before the point of the path that is nearest, to where it may have to go back
_BEYOND = 0.1  # m behind the end of a lead that count as the lead
_AS_NEAR = 0.1  # m: parts of the path of which one is so much nearer are as near


class Nearest(NamedTuple):
    """The point of a path that is nearest to the robot."""

    index: int
    """Of the segment."""
    position: np.ndarray
    """(3,) m."""
    travelled: float
    """m from the beginning of the path."""
    distance: float
    """m from the robot, straight."""


class Guidance(NamedTuple):
    """The way to go."""

    paths: List[LocalPath]
    """The next one is for where nothing of those before can be seen."""
    remark: str = ""
    """One sentence if it is not what was asked for."""
    lead: float = 0.0
    """How far the plan leads over closed ground, out of it (m)."""


class Guide:
    """Of one plan: its path, laid over the surface, and its field.

    Remembers where on the path the robot was, so that ways that cross are told apart.

    Attributes:
        start: (3,) m, where the path begins.
        goal: where it ends.
    """

    def __init__(
        self,
        geometry: MeshGeometry,
        plan: ControllerPlan,
        costs: np.ndarray,
        distance: float,
        clearance: float,
        cost_limit: float = math.inf,
    ) -> None:
        """Args:
            geometry: of the map.
            plan: that is to be followed.
            costs: (V,) for the robot's middle: corners are not rounded onto blocked ground.
            distance: from the surface that is allowed (m).
            clearance: by which corners are rounded (m).
            cost_limit: what costs more is blocked.

        Raises:
            ControlFailure: INVALID_PATH, a pose is off the map.
        """
        self._geometry, self._field = geometry, plan.field
        self._tracer = None if plan.field is None else FieldTracer.of(geometry)
        positions = plan.poses[:, :3]
        places = _on_open_ground(geometry, _places(geometry, positions, distance), costs)
        last = len(positions) - 1
        self.goal = SurfacePoint(
            int(places.faces[last]),
            places.positions[last],
            places.barycentric[last],
            float(places.distances[last]),
        )
        self._path = _laid_out(geometry, places)
        self._lead = 0.0 if plan.field is None else plan.field.lead
        self.start = self._path.points[0]
        local_costs = LocalCosts(
            geometry, costs, self.goal.face, self.goal.position, cost_limit, lead=self._lead
        )
        if clearance > 0.0 and len(positions) > 2:
            wide = _laid_out(geometry, rounded(geometry, places, clearance))
            if is_free(local_costs, wide):
                self._path = wide
        self._travelled = -1.0  # not known yet

    def guidance(
        self, surface_pose: SurfacePose, follow_field: bool, length: float, max_distance: float
    ) -> Guidance:
        """The way to go from here.

        Args:
            surface_pose: where the robot is.
            follow_field: True: from here down the field where there is one; else along the path.
            length: at which the way may be cut off (m).
            max_distance: from the path that is allowed when it is followed (m).

        Raises:
            ControlFailure: MISSED_PATH, the path is too far away.
        """
        remark, lead = "", self._lead_left(surface_pose, max_distance)
        if follow_field:
            way = self._down_the_field(surface_pose, length)
            if way is not None:
                return Guidance([way], lead=lead)
            remark = "the plan has no field"
            if self._field is not None:
                remark = (
                    f"the field of the plan does not reach {vector_text(surface_pose.position)}"
                )
            remark += ": its path is followed"
        nearest = self.nearest(surface_pose.position, max_distance)
        if nearest.distance > max_distance:
            raise ControlFailure(
                ExePathOutcome.MISSED_PATH,
                f"the robot at {vector_text(surface_pose.position)} is {nearest.distance:.2f} m "
                f"from the path, allowed are {max_distance:.2f} m (max_path_distance); the path is "
                f"nearest at {vector_text(nearest.position)}",
            )
        back = self.before(nearest, _RETURN)
        paths = [self.ahead(nearest, length), self.ahead(back, length + _RETURN)]
        return Guidance(paths, remark if not lead else "", lead)

    def _lead_left(self, surface_pose: SurfacePose, max_distance: float) -> float:
        if not self._lead:
            return 0.0
        nearest = self.nearest(surface_pose.position, max_distance)
        left = self._lead + _BEYOND - nearest.travelled
        if left <= 0.0 or nearest.distance > max_distance:
            return 0.0
        return left + nearest.distance

    def has_path_ahead(
        self, surface_pose: SurfacePose, follow_field: bool, radius: float, max_distance: float
    ) -> bool:
        """Whether the path leads away once more from the goal, beside which the robot is, farther
        than a radius (m): paths of other programs may be loops, those of fields are none."""
        if follow_field and self._field is not None:
            return False
        nearest = self.nearest(surface_pose.position, max_distance)
        return nearest.distance <= max_distance and self.comes_back(nearest, radius)

    def _down_the_field(self, surface_pose: SurfacePose, length: float) -> Optional[LocalPath]:
        if self._tracer is None:
            return None
        path = self._tracer.path(self._field, surface_pose, max_length=length)
        if path is None:
            return None
        arrives = bool((path.points[-1] == self._field.goal_position).all())
        return LocalPath.through(path.points, path.faces, arrives)

    def nearest(self, position: np.ndarray, max_distance: float) -> Nearest:
        """Where on the path the robot is: near to where it was before, or anywhere if that is too
        far from the path.

        Args:
            position: (3,) m, of the robot on the surface.
            max_distance: that is not too far (m).
        """
        found = None
        if self._travelled >= 0.0:
            found = self._nearest(position, self._travelled - _BACK, self._travelled + _AHEAD)
        if found is None or found.distance > max_distance:
            found = self._nearest(position, -np.inf, np.inf)
        self._travelled = found.travelled
        return found

    def _nearest(self, position: np.ndarray, begin: float, end: float) -> Nearest:
        points, travelled = self._path.points, self._path.travelled
        if len(points) == 1:
            return Nearest(0, points[0], 0.0, float(np.linalg.norm(points[0] - position)))
        first = max(int(travelled.searchsorted(begin)) - 1, 0)
        last = min(int(travelled.searchsorted(end)) + 1, len(points))
        first = min(first, last - 2)
        starts = points[first : last - 1]
        steps = points[first + 1 : last] - starts
        squares = np.einsum("ij,ij->i", steps, steps)
        shares = np.einsum("ij,ij->i", position - starts, steps) / np.maximum(squares, 1e-300)
        nearest = starts + np.minimum(np.maximum(shares, 0.0), 1.0)[:, None] * steps
        gaps = nearest - position
        distances = np.sqrt(np.einsum("ij,ij->i", gaps, gaps))
        best = self._of_the_part(distances, travelled[first : last - 1])
        index = first + best
        length = float(travelled[index]) + math.dist(nearest[best], points[index])
        return Nearest(index, nearest[best], length, float(distances[best]))

    def _of_the_part(self, distances: np.ndarray, travelled: np.ndarray) -> int:
        """The nearest segment; where the path comes by more than once, of the part that is nearest,
        along the path, to where the robot was, or to its beginning."""
        near = np.flatnonzero(distances <= distances.min() + _AS_NEAR)
        if near[-1] - near[0] < len(near):  # one part: most often
            return int(distances.argmin())
        parts = np.split(near, np.flatnonzero(np.diff(near) > 1) + 1)
        gaps = [np.abs(travelled[part] - self._travelled).min() for part in parts]
        part = parts[int(np.argmin(gaps))]
        return int(part[np.argmin(distances[part])])

    def comes_back(self, nearest: Nearest, radius: float) -> bool:
        """Whether from there on the path leads farther from its end than a radius (m)."""
        gaps = self._path.points[nearest.index + 1 :] - self._path.points[-1]
        return bool(np.any(np.einsum("ij,ij->i", gaps, gaps) > radius * radius))

    def before(self, nearest: Nearest, length: float) -> Nearest:
        """The point of the path that comes this length (m) before another one."""
        travelled = max(nearest.travelled - length, 0.0)
        index = max(int(self._path.travelled.searchsorted(travelled)) - 1, 0)
        return Nearest(index, self._path.at(travelled), travelled, np.nan)

    def ahead(self, nearest: Nearest, length: float) -> LocalPath:
        """The path from there on.

        Args:
            nearest: where it begins.
            length: at which it is cut off, or somewhat after (m).
        """
        end = nearest.travelled + length
        last = min(int(self._path.travelled.searchsorted(end)) + 1, len(self._path.points))
        after = nearest.index + 1
        points = np.concatenate([nearest.position[None], self._path.points[after:last]])
        faces = self._path.faces[nearest.index : last - 1]
        return LocalPath.through(points, faces, last == len(self._path.points))

    def hint(self, position: np.ndarray, radius: float) -> Any:
        """The place of the path that is nearest to a position, to look for the robot from there.

        None where it is farther away than the radius (m), or the path has no surface.
        """
        found = self._nearest(position, -np.inf, np.inf)
        if found.distance > radius:
            return None
        if len(self._path.faces) == 0:
            return self.goal
        face = int(self._path.faces[found.index])
        if face == NO_FACE:
            return None
        corners = self._geometry.vertices[self._geometry.faces[face]].astype(np.float64)
        weights = inside(corners, found.position)
        return SurfacePoint(face, found.position, weights, found.distance)


def _places(geometry: MeshGeometry, positions: np.ndarray, distance: float) -> SurfacePoints:
    queries = SurfaceQueries(geometry)
    places = queries.carry(positions, max_distance=distance)
    off = np.flatnonzero(places.faces == NO_FACE)
    if not len(off):
        return places
    index, count = int(off[0]), len(positions)
    nearest = queries.carrying_face(positions[index], max_distance=np.inf)
    how_far = "far" if nearest is None else f"{number_text(nearest.distance)} m"
    raise ControlFailure(
        ExePathOutcome.INVALID_PATH,
        f"pose {index} of {count} of the path, {vector_text(positions[index])}, is {how_far} from "
        f"the map, allowed are {distance:.2f} m (max_search_distance; {len(off)} such poses)",
    )


def _on_open_ground(
    geometry: MeshGeometry, places: SurfacePoints, costs: np.ndarray
) -> SurfacePoints:
    """The same places; where several surfaces are, those in faces that are not lethal."""
    corners = geometry.faces[places.faces].astype(np.int64)
    nearest = corners[np.arange(len(corners)), np.argmax(places.barycentric, axis=1)]
    closed = np.flatnonzero(~np.isfinite(costs[nearest]))
    if not len(closed):
        return places
    found = geometry.spatial_index.closest_batch(
        points=places.positions[closed],
        max_distance=SAME_POINT,
        mask=np.isfinite(costs)[geometry.faces].all(axis=1),
    )
    other = found.faces != NO_FACE
    columns = [column.copy() for column in places[:3]]
    for column, there in zip(columns, found[:3]):
        column[closed[other]] = there[other]
    return SurfacePoints(*columns, places.distances)


def is_free(local_costs: LocalCosts, way: LocalPath) -> bool:
    """Whether all of a way can be driven: no part is blocked or leaves the surface."""
    if not len(way.faces):
        return True
    return bool(np.all(way.faces != NO_FACE)) and (
        local_costs.first_blocked(way.points, way.faces) is None
    )


def _laid_out(geometry: MeshGeometry, places: SurfacePoints) -> LocalPath:
    """The polyline through places, over the faces between them; where the surface does not lead
    from one to the next, straight, without a face."""
    starts = SurfacePoints(*(column[:-1] for column in places))
    points, faces = [places.positions[:1]], [np.zeros(0, dtype=np.int64)]
    if len(starts.faces):
        ups = np.broadcast_to(geometry.up, starts.positions.shape)
        walks = geometry.walker.line_batch(
            starts=starts,
            targets=places.positions[1:],
            ups=ups,
            max_steps=MAX_STEPS,
            paths=True,
        )
        missed = np.linalg.norm(walks.positions - places.positions[1:], axis=1)
        leads = (walks.ends == WalkEnd.ARRIVED) & (missed <= SAME_SHEET)
        for index, way in enumerate(walks.paths):
            target = places.positions[index + 1 : index + 2]
            if leads[index] and len(way.faces):
                points += [way.points[1:-1], target]
                faces.append(way.faces.astype(np.int64))
            else:
                points.append(target)
                same = places.faces[index] == places.faces[index + 1]
                faces.append(np.array([places.faces[index] if same else NO_FACE], dtype=np.int64))
    return LocalPath.through(np.concatenate(points), np.concatenate(faces), arrives=True)


_REACH = 0.3  # m before and behind a place, between which the path bends there


def rounded(geometry: MeshGeometry, places: SurfacePoints, clearance: float) -> SurfacePoints:
    """Places of a path, those at bends moved outwards.

    Shortest paths touch what they go around, at the inner side of their bends: a hole, a slit, or
    where the next storey begins. Each place moves by the clearance times 2 sin(bend / 2), as far as
    there is surface; the first and the last stay.

    Args:
        geometry: of the map.
        places: (N) of the path, all on the map.
        clearance: m.
    """
    points = places.positions
    if len(points) < 3 or not clearance > 0.0:
        return places
    before, behind = _directions(points)
    outwards = before - behind
    bends = np.minimum(np.linalg.norm(outwards, axis=1), 1.0)
    bends[~(before.any(axis=1) & behind.any(axis=1))] = 0.0  # the ends, also where they repeat
    usable = np.flatnonzero(bends > 0.1)
    if not len(usable):
        return places
    walks = geometry.walker.walk_batch(
        starts=SurfacePoints(*(column[usable] for column in places)),
        lengths=clearance * bends[usable],
        directions=outwards[usable],
    )
    columns = [column.copy() for column in places[:3]]
    for column, moved in zip(columns, (walks.faces, walks.positions, walks.barycentric)):
        column[usable] = moved
    return SurfacePoints(*columns, places.distances)


def _directions(points: np.ndarray) -> tuple:
    """(N,3) unit vectors to each point from `_REACH` before it, and from it to as far behind."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.append(0.0, np.cumsum(steps))

    def at(lengths: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(lengths, travelled, points[:, axis]) for axis in range(3)], 1)

    chords = points - at(travelled - _REACH), at(travelled + _REACH) - points
    return tuple(
        chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-9) for chord in chords
    )
