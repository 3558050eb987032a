"""What is free around a place, straight over the surface."""

import math
from typing import Any, List, NamedTuple, Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk import WalkEnd
from mesh_map.spatial.hits import NO_FACE, SurfacePoint

from mesh_navigation.controllers.local_costs import LocalCosts
from mesh_navigation.controllers.surface_pose import MAX_STEPS, SurfacePose
from mesh_navigation.controllers.sweep import Sweep
from mesh_navigation.controllers.vector3 import Vector3, cross, inside, minus, unit, vector3
from mesh_navigation.controllers.local_path import LocalPath

_THERE = 0.01  # m from a place to where the line to it ends
_HERE = 1e-4  # m; what is nearer is here
_STEP = 0.1  # m, of the straight pieces that stand for an arc
_MOST_STEPS = 8
_TURN = 0.1  # rad, of the headings that stand for a turn on the spot


class View(NamedTuple):
    """The straight way to a place."""

    distance: float
    """m."""
    blocked: Optional[float]
    """m to where it is blocked, or leaves the surface; None: it is free."""
    reason: str


class Corridor(NamedTuple):
    """A place of a way, and how much room is beside it."""

    middle: np.ndarray
    """(3,) m: the place, moved to where there is room on both sides, if there is."""
    sides: List[np.ndarray]
    """Places left and right of it, within the clearance."""


class Sight:
    """From where the robot stands, at one moment."""

    def __init__(
        self,
        geometry: MeshGeometry,
        local_costs: LocalCosts,
        surface_pose: SurfacePose,
        sweep: Sweep = Sweep(),
    ) -> None:
        self._geometry, self._walker = geometry, geometry.walker
        self._local_costs, self.surface_pose, self.sweep = local_costs, surface_pose, sweep

    @property
    def has_obstacles(self) -> bool:
        """Whether something is near that the robot's body could touch."""
        return bool(len(self._local_costs.obstacles.points))

    def look(self, point: np.ndarray) -> View:
        """The straight way to a place (3,) (m)."""
        surface_pose = self.surface_pose
        straight = math.dist(point, surface_pose.position)
        if straight < _HERE:
            return View(straight, None, "")
        for up in (
            surface_pose.up,
            surface_pose.normal,
            self._geometry.up,
        ):  # one of them where it bends
            line = self._walker.line(
                start=surface_pose, target=point, up=up, max_steps=MAX_STEPS, path=True
            )
            missed = math.dist(line.position, point)
            if missed <= _THERE:
                blocked = None
                if len(line.path.faces):
                    blocked = self._local_costs.first_blocked(line.path.points, line.path.faces)
                return View(line.length + missed, blocked, "is blocked")
        return View(straight, min(line.length, straight), "leaves the surface")

    def corridor(self, way: LocalPath, length: float, clearance: float) -> Corridor:
        """What is beside a place of a way.

        Args:
            way: ahead of the robot.
            length: along it, where the place is (m).
            clearance: that is looked for on both sides (m).
        """
        middle = way.at(length)
        segment = way.segment_at(length)
        if segment is None or way.faces[segment] == NO_FACE or not clearance > 0.0:
            return Corridor(middle, [])
        face = int(way.faces[segment])
        ahead = unit(minus(vector3(way.points[segment + 1]), vector3(way.points[segment])))
        if ahead is None:
            return Corridor(middle, [])
        corners = self._geometry.vertices[self._geometry.faces[face]].astype(np.float64)
        place = SurfacePoint(face, middle, inside(corners, middle), 0.0)
        left = cross(self.surface_pose.up, ahead)
        goal = way.arrives and length >= way.length
        ways = [self._beside(place, left, sign * 2 * clearance) for sign in (1.0, -1.0)]
        room = [found.length for found in ways]
        if goal:
            shift = 0.0
        elif sum(room) < 2 * clearance:
            shift = (room[0] - room[1]) / 2
        else:
            shift = max(clearance - room[1], 0.0) - max(clearance - room[0], 0.0)
        if shift:
            middle = ways[0].at(shift) if shift > 0.0 else ways[1].at(-shift)
        sides = [
            found.at(min(max(found.length - 1e-3, 0.0), clearance + sign * shift))
            for found, sign in zip(ways, (1.0, -1.0))
        ]
        return Corridor(middle, sides)

    def free_arc(self, curvature: float, length: float) -> Optional[float]:
        """How far an arc along the heading leads over free ground (m) if not all of it does, or
        until the footprint touches something; None: all of it is free.

        Args:
            curvature: rad/m, to the left.
            length: m.
        """
        steps = 1 if curvature == 0.0 else min(max(math.ceil(length / _STEP), 2), _MOST_STEPS)
        if not self.sweep.is_empty:
            steps = max(math.ceil(length / _STEP), 2)
        step = length / steps
        place, heading = self.surface_pose, self.surface_pose.heading
        points, faces, walked, ended = [], [], 0.0, False
        stands = [(place.position, place.normal, heading)]
        for _ in range(steps):
            heading = _turned(heading, vector3(place.normal), curvature * step / 2)
            walk = self._walker.walk(
                start=place, length=step, direction=heading, max_steps=MAX_STEPS, path=True
            )
            if len(walk.path.faces):
                points.append(walk.path.points[:-1])
                faces.append(walk.path.faces)
            walked += walk.length
            place = walk
            heading = _turned(vector3(walk.direction), vector3(walk.normal), curvature * step / 2)
            stands.append((walk.position, vector3(walk.normal), heading))
            if walk.end != WalkEnd.ARRIVED:
                ended = True
                break
        points.append(place.position[None])
        found = [walked] if ended else []
        if faces:
            blocked = self._local_costs.first_blocked(np.concatenate(points), np.concatenate(faces))
            if blocked is not None:
                found.append(blocked)
        touch = self.sweep.first_touch(stands)
        if touch is not None:
            found.append((touch - 1) * step)
        return min(found, default=None)

    def can_turn(self, angle: float) -> bool:
        """Whether the footprint touches nothing while it turns on the spot (rad)."""
        place = self.surface_pose
        turns = np.linspace(0.0, angle, math.ceil(abs(angle) / _TURN) + 1)
        stands = [
            (place.position, place.normal, _turned(place.heading, place.normal, turn))
            for turn in turns.tolist()
        ]
        return self.sweep.first_touch(stands) is None

    def _beside(self, place: SurfacePoint, left: Any, length: float) -> LocalPath:
        """The free way to one side."""
        walk = self._walker.walk(
            start=place,
            direction=left,
            length=length,
            up=self.surface_pose.up,
            max_steps=MAX_STEPS,
            path=True,
        )
        if not len(walk.path.faces):
            return LocalPath.through(place.position[None], walk.path.faces, False)
        way = LocalPath.through(walk.path.points, walk.path.faces, False)
        blocked = self._local_costs.first_blocked(way.points, way.faces)
        if blocked is None:
            return way
        kept = max(int(way.travelled.searchsorted(blocked)), 1)
        points = np.concatenate([way.points[:kept], way.at(blocked)[None]])
        return LocalPath.through(points, way.faces[:kept], False)


def _turned(heading: Vector3, normal: Vector3, angle: float) -> Vector3:
    left = cross(normal, heading)
    c, s = math.cos(angle), math.sin(angle)
    return (
        c * heading[0] + s * left[0],
        c * heading[1] + s * left[1],
        c * heading[2] + s * left[2],
    )
