"""What planners have in common that search from the goal over the whole surface."""

from contextlib import contextmanager
from typing import Any, Iterator, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.base.parameter import Parameter
from mesh_map.costs.cleared_costs import ClearedCosts
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.path import path_length, path_poses, spaced_out
from mesh_navigation.base.pose import Pose, vector_text
from mesh_navigation.base.recent import Recent
from mesh_navigation.body.body import Body
from mesh_navigation.body.near_obstacles import TOLERANCE
from mesh_navigation.planners.blocking_layers import at_goal, blocking_layers, rim
from mesh_navigation.planners.path_ends import (
    PathEnd,
    blocked_text,
    find_path_end,
    nearest_path_end,
    escaped_path_end,
)
from mesh_navigation.planners.escape_paths import EscapePaths
from mesh_navigation.plugins.planner import (
    MeshPlanner,
    PlanFailure,
    PlanField,
    PlanResult,
    stop_if_canceled,
)
from mesh_navigation.surface.face_points import find_face_point
from mesh_navigation.surface.slowness import CostSnapshot, CostSnapshots
from mesh_navigation.surface.up_normals import face_up_normals

PARAMETERS = (
    Parameter("cost_limit", 1.0, 0.0, 10.0, "highest cost of a vertex that may be passed"),
    Parameter("goal_dist_offset", 0.3, 0.0, None, "search this far beyond the start (m, weighted)"),
    Parameter(
        "publish_vector_field", False, description="compute and publish directions at vertices"
    ),
    Parameter("publish_face_vectors", False, description="compute and publish directions in faces"),
)


# A field of a million vertices takes some dozens of megabytes.
_KEPT, _KEPT_CLEARED = 3, 1


# m between two poses where a way leads out of closed ground, for planners without step_width.
_LEAD_STEP = 0.4


class GivenCosts(NamedTuple):
    """Costs to plan on, of now or without what sensors see, and what is remembered of them."""

    planning: PlanningCosts
    body: Body
    """Follows changes of these costs."""
    snapshots: CostSnapshots
    fields: "Recent[CachedField]"
    """Of the last goals."""
    cleared: Optional[ClearedCosts] = None
    """What they are of; None: of the map as it is."""


class Search(NamedTuple):
    """What one plan works with, all of one moment."""

    values: Mapping[str, Any]
    """Of the parameters."""
    snapshot: CostSnapshot
    basis: Any
    """What a field is computed from, as the planner knows it."""
    flag: CancelFlag
    given: GivenCosts


class RawPath(NamedTuple):
    """A path before it is made of poses."""

    points: np.ndarray
    """(N,3) m, N at least 2."""
    normals: np.ndarray
    """(N,3) of the surface there, pointing up."""
    cost: float
    remark: str = ""
    """For people, to follow the message of the result; empty, or beginning with "; "."""


class CachedField(NamedTuple):
    """A field between two plans."""

    field: Any
    search: Search
    """The last one that it was brought up to date for."""
    is_mended: bool = False
    """Whether costs have changed since it was computed."""


# Failures that another goal need not have.
_OF_THE_GOAL = (GetPathOutcome.INVALID_GOAL, GetPathOutcome.NO_PATH_FOUND)


def _are_equal(costs: np.ndarray, others: np.ndarray) -> bool:
    if costs is others:
        return True
    differ = np.flatnonzero(costs != others)  # NaN does, too
    return bool(np.isnan(costs[differ]).all() and np.isnan(others[differ]).all())


class SurfacePlanner(MeshPlanner):
    """From start and goal to a path, apart from the search itself.

    A planner overrides the methods below "The search". Fields of the last goals are kept: a new
    start extends them, and where few costs have changed they are repaired. A plan takes a field out
    and puts it back: nobody else has it meanwhile, so it does not change under the plan. Another
    plan to the same goal at the same time makes one of its own. A plan that fails in the middle of
    a change does not put the field back.
    """

    parameters = PARAMETERS

    def initialize(self, name: str, mesh_map: MeshMap, given: Mapping[str, Any] = {}) -> list:
        complaints = super().initialize(name, mesh_map, given)
        mesh_map.spatial_index  # now rather than during the first plan
        self.body.costs(mesh_map.planning_costs().costs)
        self._now = GivenCosts(
            mesh_map.planning_costs(), self.body, CostSnapshots(mesh_map.geometry), Recent(_KEPT)
        )
        self._cleared = GivenCosts(
            self._now.planning,
            Body(mesh_map.geometry, self.body.shape),
            CostSnapshots(mesh_map.geometry),
            Recent(_KEPT_CLEARED),
        )
        self._prepare()
        return complaints

    def plan(
        self, start: Pose, goal: Pose, tolerance: float, cancellation: Cancellation
    ) -> PlanResult:
        flag, values = CancelFlag(), self.values
        with cancellation.calling(flag.set):
            try:
                now = self._now._replace(planning=self.map.planning_costs())
                search = self._begin(values, flag, now)
                try:
                    result = self._plan(start, goal, tolerance, search)
                except PlanFailure as failure:
                    raise self._lasting(failure, start, goal, tolerance, search) or failure
            except Canceled:
                stop_if_canceled(cancellation)
                raise
        stop_if_canceled(cancellation)
        return result

    def _plan(self, start: Pose, goal: Pose, tolerance: float, search: Search) -> PlanResult:
        escapes = self._escapes(start, search)
        origin = self._origin(start, search, escapes)
        try:
            target = find_path_end(
                self.map,
                goal.position,
                search.snapshot,
                "goal",
                GetPathOutcome.INVALID_GOAL,
                search.given.cleared,
            )
            self._check_room(search, target)
            return self._result_from(search, origin, escapes, target, goal)
        except PlanFailure as failure:
            if tolerance == 0.0 or failure.outcome not in _OF_THE_GOAL:
                raise
            reached = self._reached(search, origin, escapes)
            target = nearest_path_end(
                self.map, goal.position, tolerance, reached, search.snapshot, failure
            )
        return self._result_from(search, origin, escapes, target, goal)

    def _escapes(self, start: Pose, search: Search) -> Optional[EscapePaths]:
        """Of a start on ground that is closed, but neither lethal nor unknown; None of others.

        Raises:
            PlanFailure: INVALID_START, it is too far from the surface.
        """
        place = find_face_point(self.map, start.position, "start", GetPathOutcome.INVALID_START)
        snapshot, nearest = search.snapshot, place.corners[0]
        if snapshot.passable[nearest] or not np.isfinite(snapshot.costs[nearest]):
            return None
        return EscapePaths(self.map, place, snapshot, search.given.body, search.flag)

    def _origin(self, start: Pose, search: Search, escapes: Optional[EscapePaths]) -> PathEnd:
        """Where a path over open ground begins.

        Raises:
            PlanFailure: INVALID_START.
        """
        outcome, snapshot = GetPathOutcome.INVALID_START, search.snapshot
        cleared = search.given.cleared
        if escapes is None:
            return find_path_end(self.map, start.position, snapshot, "start", outcome, cleared)
        escape = escapes.to(snapshot.passable)
        if escape is None:
            text = blocked_text(self.map, escapes.start, snapshot, cleared)
            text = f"start {text}; from there no ground can be reached that may be passed"
            raise PlanFailure(outcome, text)
        return escaped_path_end(self.map, escape, snapshot)

    def _result_from(
        self,
        search: Search,
        origin: PathEnd,
        escapes: Optional[EscapePaths],
        target: PathEnd,
        goal: Pose,
    ) -> PlanResult:
        """As `_result`; from closed ground by a longer way out, where the shortest one leads to
        open ground that does not go on to the goal."""
        try:
            return self._result(search, origin, target, goal)
        except PlanFailure as failure:
            if escapes is None or failure.potential is None:
                raise
            escape = escapes.to(search.snapshot.passable & np.isfinite(failure.potential))
            if escape is None:
                raise
        return self._result(
            search, escaped_path_end(self.map, escape, search.snapshot), target, goal
        )

    def _reached(
        self, search: Search, origin: PathEnd, escapes: Optional[EscapePaths]
    ) -> np.ndarray:
        """(V,) bool: open ground to which a path may lead."""
        snapshot = search.snapshot
        if escapes is not None:
            costs, limit, factor = escapes.opened(), snapshot.cost_limit, snapshot.cost_factor
            opened = CostSnapshot(self.map.geometry, costs, limit, factor)
            search = search._replace(snapshot=opened)
        return np.isfinite(self._solved(search, origin, None).potential) & snapshot.passable

    def _lasting(
        self, failure: PlanFailure, start: Pose, goal: Pose, tolerance: float, search: Search
    ) -> Optional[PlanFailure]:
        """The failure of the same plan without what sensors see, if that fails for the goal, too.

        Raises:
            Canceled: by the flag.
        """
        if failure.outcome not in _OF_THE_GOAL:
            return None
        cleared, values, flag = self.map.cleared_costs(), search.values, search.flag
        if not _are_equal(cleared.planning.costs, search.given.planning.costs):
            given = self._cleared._replace(planning=cleared.planning, cleared=cleared)
            search = self._begin(values, flag, given)
            try:
                self._plan(start, goal, tolerance, search)
                return None
            except PlanFailure as other:
                if other.outcome not in _OF_THE_GOAL:
                    return None
                failure = other
        names = self._blocking(failure, goal, search, cleared)
        text = failure.message
        if names:
            text += f"; whatever sensors see, it is blocked by layer{'s' * (len(names) > 1)} "
            text += ", ".join(names)
        return PlanFailure(failure.outcome, text, failure.potential, lasting=True)

    def _blocking(
        self, failure: PlanFailure, goal: Pose, search: Search, cleared: ClearedCosts
    ) -> List[str]:
        """The layers that a goal cannot be reached for."""
        is_goal = failure.outcome == GetPathOutcome.INVALID_GOAL
        if is_goal:
            vertices = at_goal(self.map, goal.position, search.snapshot)
        elif failure.potential is not None:
            vertices = rim(self.map.topology, np.isfinite(failure.potential))
        else:
            return []  # other parts of the mesh
        return blocking_layers(
            self.map.topology,
            cleared.results,
            cleared.planning.costs,
            search.snapshot,
            vertices,
            nearest=is_goal,
        )

    def _result(self, search: Search, origin: PathEnd, target: PathEnd, goal: Pose) -> PlanResult:
        """The result of a plan that succeeds.

        Raises:
            PlanFailure: NO_PATH_FOUND.
            Canceled: by the flag.
        """
        self._check_component(origin, target)
        with self._reaching(search, origin, target) as field:
            if not np.any(field.reaches(origin.vertices)):
                raise self._not_reached(search, origin, target, field.potential)
            track = self._led(search, origin, self._track(search, origin, target, field))
            vectors, face_vectors = self._vectors(search, target, field)
            potential = field.potential
            plan_field = self._plan_field(target, field)
            if origin.lead is not None:
                plan_field = plan_field._replace(lead=origin.lead.length)
        length = path_length(track.points)
        straight = float(np.linalg.norm(track.points[-1] - track.points[0]))
        poses = path_poses(track.points, track.normals, goal.heading)
        cost = f", cost {track.cost:.2f}" if abs(track.cost - length) > 0.005 else ""
        return PlanResult(
            outcome=GetPathOutcome.SUCCESS,
            message=f"path of {length:.2f} m with {len(poses)} poses{cost}, straight it would be "
            f"{straight:.2f} m{origin.remark}{target.remark}{track.remark}",
            poses=poses,
            cost=track.cost,
            potential=potential,
            vector_field=vectors,
            face_vectors=face_vectors,
            plan_field=plan_field,
        )

    def _check_room(self, search: Search, target: PathEnd) -> None:
        """
        Raises:
            PlanFailure: INVALID_GOAL, the robot's body would touch something there.
        """
        if target.whole:  # where all of its face is open, the radius is kept along the surface
            return
        place, radius = target.position, self.body.radius
        near = search.given.body.obstacles(search.snapshot.costs, place, TOLERANCE)
        distance = float(near.distances(place[None])[0])
        if distance < radius - TOLERANCE:
            raise PlanFailure(
                GetPathOutcome.INVALID_GOAL,
                f"goal {vector_text(place)} is {distance:.2f} m from lethal or unknown ground, the "
                f"robot's radius is {radius:.2f} m",
            )

    def _led(self, search: Search, origin: PathEnd, track: RawPath) -> RawPath:
        """The path, from a start on closed ground."""
        lead = origin.lead
        if lead is None:
            return track
        step = search.values.get("step_width", _LEAD_STEP)
        points, segments = spaced_out(lead.points, step)
        normals = face_up_normals(self.map.geometry, lead.faces[segments[:-1]])
        return RawPath(
            np.concatenate([points[:-1], track.points]),
            np.concatenate([normals, track.normals]),
            track.cost + lead.length,
            track.remark,
        )

    def _not_reached(
        self, search: Search, origin: PathEnd, target: PathEnd, potential: np.ndarray
    ) -> PlanFailure:
        """The failure of a search that has seen everything around the goal, but not the start."""
        snapshot, number = search.snapshot, self._component(target)
        size = np.count_nonzero(self.map.topology.components == number - 1)
        reached = int(np.count_nonzero(np.isfinite(potential)))
        return PlanFailure(
            GetPathOutcome.NO_PATH_FOUND,
            f"no path: {reached} of {size} vertices of component "
            f"{number} can be reached from the goal, none of them at the start "
            f"{vector_text(origin.position)}; {snapshot.blocked_count} vertices of the map are "
            f"lethal, unknown or over the cost limit {snapshot.cost_limit:.3g}",
            potential,
        )

    def _component(self, place: PathEnd) -> int:
        """The number of the connected part of the mesh with this place, from 1 for people."""
        return int(self.map.topology.components[place.face_point.corners[0]]) + 1

    def _check_component(self, origin: PathEnd, target: PathEnd) -> None:
        """
        Raises:
            PlanFailure: start and goal are in different ones.
        """
        start, goal = self._component(origin), self._component(target)
        if start != goal:
            raise PlanFailure(
                GetPathOutcome.NO_PATH_FOUND,
                f"no path: start is in component {start} of {self.map.topology.component_count}, "
                f"goal in component {goal}",
            )

    @contextmanager
    def _reaching(self, search: Search, origin: PathEnd, target: PathEnd) -> Iterator[Any]:
        """The field of a goal, final around the start; nobody else changes it meanwhile."""
        fields = search.given.fields
        held, field, is_mended = fields.take(target.key), None, False
        if held is not None and self._updated(search, target, held):
            field, offset = held.field, search.values["goal_dist_offset"]
            field.extend(origin.vertices, offset=offset, cancel=search.flag)
            is_mended = held.is_mended or held.search.snapshot is not search.snapshot
            if is_mended and not np.any(field.reaches(origin.vertices)):
                field = None  # slivers may have kept it from what a new one reaches
        if field is None:
            field, is_mended = self._solved(search, target, origin.vertices), False
        try:
            yield field
        finally:
            fields.put(target.key, CachedField(field, search, is_mended))

    # The search.

    def _prepare(self) -> None:
        """What is to be done once for a map."""

    def _begin(self, values: Mapping[str, Any], flag: CancelFlag, given: GivenCosts) -> Search:
        """What a plan needs, of one moment."""
        raise NotImplementedError

    def _solved(self, search: Search, target: PathEnd, vertices: Optional[List[int]]) -> Any:
        """A field from a place, final `goal_dist_offset` beyond these vertices; None: everywhere.

        Raises:
            Canceled: by the flag.
        """
        raise NotImplementedError

    def _updated(self, search: Search, target: PathEnd, held: CachedField) -> bool:
        """Brings a field to what the search is based on. False: it has to be computed anew.

        Raises:
            Canceled: by the flag; the field is then of no use any more.
        """
        raise NotImplementedError

    def _track(self, search: Search, origin: PathEnd, target: PathEnd, field: Any) -> RawPath:
        """The path down a field that reaches the start."""
        raise NotImplementedError

    def _plan_field(self, target: PathEnd, field: Any) -> PlanField:
        """A copy of a field, which does not change when the field does."""
        raise NotImplementedError

    def _vectors(
        self, search: Search, target: PathEnd, field: Any
    ) -> Tuple[Optional[np.ndarray], Optional[np.ndarray]]:
        """Directions at vertices and in faces, None unless asked for."""
        raise NotImplementedError
