"""Straight on over the surface, or not at all."""

import math
from typing import Any, List, Mapping, NamedTuple

import numpy as np
from mesh_map.base.parameter import Parameter
from mesh_map.geometry.walk import SurfaceWalk, WalkEnd
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import SurfacePoint
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.path import path_length, path_poses, spaced_out
from mesh_navigation.base.pose import Pose, vector_text
from mesh_navigation.body.robot_shape import MAX_DISTANCE
from mesh_navigation.plugins.planner import (
    MeshPlanner,
    PlanFailure,
    PlanResult,
    stop_if_canceled,
)
from mesh_navigation.surface.face_points import obstacle_at
from mesh_navigation.surface.slowness import passable
from mesh_navigation.surface.surface_corners import corners_of_pieces, nearest_corners
from mesh_navigation.surface.up_normals import face_up_normals

_AT_ONCE = 50_000  # faces that are walked over between two looks for a cancel
_THERE = 0.01  # m from the goal, as the walk is exact but for rounding


class Track(NamedTuple):
    """A way over the surface, as far as it may be gone, and why no farther."""

    points: np.ndarray
    """(N,3) m, N at least 2."""
    faces: np.ndarray
    """(N - 1,) the face in which point i to i + 1 lies."""
    obstacle: str
    """What is in the way behind its end, as the end of a sentence; empty where it is all there."""


class StraightPlanner(MeshPlanner):
    """The way of somebody who walks towards what he sees: straight as seen from above, up and down
    with the surface. Where that cannot be gone, there is no path.

    It crosses only faces whose three corners may be passed, so that it keeps the robot's radius all
    along; but a robot may leave the face in which it stands, nearest to corners that may be passed.
    """

    # What users may set; see mesh_map.base.parameter.
    parameters = (
        Parameter("cost_limit", 1.0, 0.0, 10.0, "highest cost of a vertex that may be passed"),
        Parameter("step_width", 0.4, 0.01, 10.0, "greatest distance between two poses (m)"),
    )

    def initialize(self, name: str, mesh_map: MeshMap, given: Mapping[str, Any] = {}) -> List[str]:
        """Prepare for work on a map, before the first plan has to wait for it."""
        complaints = super().initialize(name, mesh_map, given)
        mesh_map.spatial_index, mesh_map.geometry.walker
        self.body.costs(mesh_map.planning_costs().costs)
        return complaints

    def plan(
        self, start: Pose, goal: Pose, tolerance: float, cancellation: Cancellation
    ) -> PlanResult:
        """Straight from start to goal; see `MeshPlanner` for the contract."""
        # Parameters and costs may change meanwhile: one look at each, for all of the plan.
        values = self.values
        costs = self.body.costs(self.map.planning_costs().costs)
        begin = self._place(start.position, "start", GetPathOutcome.INVALID_START)
        end = self._place(goal.position, "goal", GetPathOutcome.INVALID_GOAL)
        closed = self._closed(begin, costs, values)
        if closed:
            text = f"start {vector_text(begin.position)} is blocked: the ground there is {closed}"
            raise PlanFailure(GetPathOutcome.INVALID_START, text)
        track = self._walked(begin, end, cancellation)
        lasting = bool(track.obstacle)  # whatever sensors see, the surface stays as it is
        track = self._as_far_as_open(track, costs, values)
        closed = self._closed(end, costs, values)
        missed = math.dist(track.points[-1], end.position)
        if closed or track.obstacle:
            outcome = GetPathOutcome.INVALID_GOAL if closed else GetPathOutcome.NO_PATH_FOUND
            text = f"the way straight on to {vector_text(end.position)} {track.obstacle}"
            if closed:
                text = f"goal {vector_text(end.position)} is blocked: the ground there is {closed}"
            if not missed <= tolerance:
                raise PlanFailure(outcome, text, lasting=lasting)
            return self._result(track, goal, values, f"; it ends {missed:.2f} m before it: {text}")
        return self._result(track, goal, values, "")

    def _place(self, position: np.ndarray, what: str, outcome: int) -> SurfacePoint:
        """The point of the surface that carries a pose."""
        place = self.map.closest_face(position, MAX_DISTANCE)
        if place is None:
            text = f"is farther than {MAX_DISTANCE:.2f} m from the map"
            raise PlanFailure(outcome, f"{what} {vector_text(position)} {text}")
        return place

    def _closed(self, place: SurfacePoint, costs: np.ndarray, values: Mapping[str, Any]) -> str:
        """Why nobody may stand at a place; empty if one may. Ground is what its nearest vertex is,
        here as for all planners."""
        (vertex,) = nearest_corners(self.map.geometry, [place.face], place.position[None])
        return self._obstacle(vertex, costs, values) or ""

    def _obstacle(self, vertex: int, costs: np.ndarray, values: Mapping[str, Any]) -> Any:
        return obstacle_at(self.map, int(vertex), costs[vertex], values["cost_limit"])

    def _walked(self, begin: SurfacePoint, end: SurfacePoint, cancellation: Cancellation) -> Track:
        """The way, whatever it costs."""
        geometry = self.map.geometry
        walk: Any = begin
        points, faces = [begin.position[None]], [np.zeros(0, np.int64)]
        while True:
            stop_if_canceled(cancellation)
            walk = geometry.walker.line(
                start=walk, target=end.position, up=geometry.up, max_steps=_AT_ONCE, path=True
            )
            points.append(walk.path.points[1:])
            faces.append(walk.path.faces.astype(np.int64))
            if walk.end != WalkEnd.STEPS:
                break
        way, crossed = np.concatenate(points), np.concatenate(faces)
        if not len(crossed):  # it is there already
            way, crossed = np.repeat(way, 2, axis=0), np.array([begin.face])
        return Track(way, crossed, _why_it_ends(walk, end))

    def _as_far_as_open(self, track: Track, costs: np.ndarray, values: Mapping[str, Any]) -> Track:
        """The way up to the first face that may not be crossed."""
        geometry, points, faces = self.map.geometry, track.points, track.faces
        corners = geometry.faces[faces].astype(np.int64)
        corners[0] = corners_of_pieces(geometry, faces[:1], points[:1], points[1:2])[0][0]
        closed = ~passable(costs[corners], values["cost_limit"])
        pieces = np.flatnonzero(closed.any(axis=1))
        if not len(pieces):
            return track
        first = int(pieces[0])
        kept = points[: first + 1] if first else np.repeat(points[:1], 2, axis=0)
        what = self._obstacle(corners[first][closed[first]][0], costs, values)
        where = f"after {path_length(kept):.2f} m, at {vector_text(kept[-1])}"
        return Track(
            kept, faces[: max(first, 1)], f"is blocked {where}: the ground there is {what}"
        )

    def _result(
        self, track: Track, goal: Pose, values: Mapping[str, Any], remark: str
    ) -> PlanResult:
        points, segments = spaced_out(track.points, values["step_width"])
        normals = face_up_normals(self.map.geometry, track.faces[segments])
        poses = path_poses(points, normals, goal.heading)
        length = path_length(track.points)
        return PlanResult(
            outcome=GetPathOutcome.SUCCESS,
            message=f"straight path of {length:.2f} m with {len(poses)} poses{remark}",
            poses=poses,
            cost=length,
        )


def _why_it_ends(walk: SurfaceWalk, end: SurfacePoint) -> str:
    """Why a walk did not come to its end; empty if it did."""
    where = vector_text(walk.position)
    if walk.end == WalkEnd.ARRIVED:
        if math.dist(walk.position, end.position) <= _THERE:
            return ""
        return f"leads above or below it, to {where}, on another storey"
    if walk.end == WalkEnd.BORDER:
        return f"ends at {where}, where the surface ends"
    return f"ends at {where}, where the surface bends away"
