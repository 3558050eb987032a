"""Back up the way the robot came."""

import math
from typing import List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.parameter import Parameter, Value
from mesh_map.geometry.walk import WalkEnd
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import SurfacePoint

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import RecoveryOutcome
from mesh_navigation.base.pose import Pose, rotate, vector_text
from mesh_navigation.base.progress_watch import ProgressWatch
from mesh_navigation.base.robot import STOP, Robot, RobotLost, RobotState, Velocity
from mesh_navigation.body.body import POINT, Body
from mesh_navigation.body.robot_shape import MAX_DISTANCE
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult
from mesh_navigation.surface.face_points import obstacle_at
from mesh_navigation.surface.slowness import passable
from mesh_navigation.surface.surface_corners import corners_along

PERIOD = 0.05  # s between two commands
ARRIVED = 0.01  # m from the end that are good enough
SLOWEST = 0.02  # m/s on the last centimeters
LOOKAHEAD = 0.3  # m, to the point of the way that is steered to
TURN_FIRST = math.radians(60)  # if that point is farther to the side, the robot turns on the spot
STUCK = 3.0  # s without getting on by MOVED m or TURNED rad
MOVED, TURNED = 0.02, 0.05
REACH = 0.5  # m; a trail that is farther away is not where the robot came from
_WINDOW = 1.0  # m, how far the way back is searched for where the robot is now


class ReversePath:
    """The last poses of a robot, from where it is to the oldest; straight back from there.

    Where it is, is told by `gone`, which only ever grows.
    """

    def __init__(self, pose: Pose, trail: List[Pose]) -> None:
        """
        Args:
            pose: of the robot.
            trail: its last poses, the newest first. Those that are newer than the one at which it
                is (or were left in another direction) are not behind it.
        """
        self._newer = 0
        points = []
        begin = _nearest(pose, trail)
        if begin is not None:
            if (trail[begin].position - pose.position) @ pose.heading > 0.0:
                begin += 1
            self._newer = begin
            points = [pose.position] + [known.position for known in trail[begin:]]
        self._points = np.array(points).reshape(-1, 3)
        steps = np.linalg.norm(np.diff(self._points, axis=0), axis=1)
        self._lengths = np.concatenate([[0.0], np.cumsum(steps)])
        self._segment = 0
        self._straight: Optional[np.ndarray] = None
        self._gone = 0.0
        self._gone_straight = 0.0

    @property
    def passed(self) -> int:
        """How many of the newest poses of the trail are not behind the robot any more."""
        return self._newer + self._segment

    def gone(self, position: np.ndarray) -> float:
        """How far the robot has gone back (m): along the way, then straight from its end."""
        if self._straight is None and self._segment < len(self._points) - 1:
            self._gone = max(self._gone, self._project(position))
        elif self._straight is None:
            self._straight = np.array(position)
        if self._straight is not None:
            self._gone_straight = float(np.linalg.norm(position - self._straight))
        return self._gone + self._gone_straight

    def target(self, ahead: float) -> Optional[np.ndarray]:
        """(3,) m: where to go from where the robot was last, so far on; None: straight back."""
        if self._segment >= len(self._points) - 1:
            return None
        wanted = self._lengths[self._segment] + ahead
        index = int(np.searchsorted(self._lengths, wanted))
        return self._points[min(index, len(self._points) - 1)]

    def _project(self, position: np.ndarray) -> float:
        """m along the points, of the one nearest to a position; notes the segment it is on."""
        begin = self._segment
        end = int(np.searchsorted(self._lengths, self._lengths[begin] + _WINDOW)) + 1
        points = self._points[begin : end + 1]
        sides = np.diff(points, axis=0)
        squared = np.maximum(np.einsum("ij,ij->i", sides, sides), 1e-18)
        shares = np.einsum("ij,ij->i", position - points[:-1], sides) / squared
        clipped = np.clip(shares, 0.0, 1.0)
        away = np.linalg.norm(points[:-1] + clipped[:, None] * sides - position, axis=1)
        best = int(np.argmin(away))
        self._segment = begin + best
        if self._segment == len(self._points) - 2 and shares[best] >= 1.0:
            self._segment += 1  # all of it is done
        return float(self._lengths[begin + best] + clipped[best] * np.sqrt(squared[best]))


def _nearest(pose: Pose, trail: List[Pose]) -> Optional[int]:
    """The pose of the trail at which the robot is, looking as then; None if it is at none."""
    best, distance = None, REACH
    heading = pose.heading
    for index, known in enumerate(trail):
        away = float(np.linalg.norm(known.position - pose.position))
        if away < distance and float(known.heading @ heading) > 0.0:
            best, distance = index, away
    return best


class FreePath(NamedTuple):
    """The ground in one direction."""

    length: float
    """m that are free; as much as was looked at where nothing is in the way."""
    obstacle: str
    """What is in the way, as a phrase; empty if nothing is."""


def free_path(
    mesh_map: MeshMap,
    start: SurfacePoint,
    direction: np.ndarray,
    length: float,
    body: Body = POINT,
) -> FreePath:
    """Look straight on over the surface.

    Ground is blocked where the nearest corner of its face is lethal or unknown. Blocked ground at
    the start itself does not count as long as free ground follows: who stands on it may leave it.

    Args:
        mesh_map: the map, with its costs of now.
        start: where the robot stands.
        direction: (3,), what of it is along the surface counts.
        length: how far to look (m).
        body: of the robot, whose middle keeps its radius; too near already, it may leave.
    """
    costs = mesh_map.planning_costs().costs
    walk = mesh_map.geometry.walker.walk(start=start, direction=direction, length=length, path=True)
    if walk.end == WalkEnd.NOWHERE or walk.path is None:
        return FreePath(0.0, f"there is no way on from {vector_text(start.position)}")
    along = corners_along(mesh_map.geometry, walk.path)
    free = passable(costs[along.vertices], np.inf)
    first = _first_blocked(free)
    obstacles = body.obstacles(costs, start.position, length)
    near = obstacles.first_near(walk.path.points, walk.path.faces)
    if near is not None and (first is None or near < along.entered[first]):
        return FreePath(near, f"lethal or unknown ground is within {body.radius:.2f} m of it")
    if first is not None:
        vertex = int(along.vertices[first])
        what = obstacle_at(mesh_map, vertex, float(costs[vertex]), np.inf)
        where = vector_text(mesh_map.vertices[vertex])
        return FreePath(float(along.entered[first]), f"vertex {vertex} at {where} is {what}")
    if walk.end != WalkEnd.ARRIVED:
        return FreePath(walk.length, f"the surface ends at {vector_text(walk.position)}")
    return FreePath(walk.length, "")


def _first_blocked(free: np.ndarray) -> Optional[int]:
    """Of (K,) bool, the first False that is not of a beginning which free ground follows."""
    begin = int(np.argmax(free)) if free.any() else 0
    blocked = np.flatnonzero(~free[begin:])
    return begin + int(blocked[0]) if len(blocked) else None


class _Run(NamedTuple):
    """What one run works with."""

    back: ReversePath
    values: Mapping[str, Value]
    watch: ProgressWatch


class BackUp(MeshRecovery):
    """Drives backwards along the robot's trail, steering; straight back where that ends.

    It stops before blocked ground and the end of the surface. What it has gone back is taken off
    the trail, so that the next time it goes on from there.
    """

    parameters = (
        Parameter("distance", 0.5, 0.0, 20.0, "how far (m)"),
        Parameter("speed", 0.2, 0.01, 5.0, "m/s"),
        Parameter("max_ang_velocity", 0.5, 0.05, 5.0, "rad/s"),
        Parameter("acceleration", 0.5, 0.05, 10.0, "of starting and stopping (m/s^2)"),
        Parameter("clearance", 0.2, 0.0, 5.0, "ground behind the robot that has to be free (m)"),
    )

    def run(self, robot: Robot, clock: Clock, cancellation: Cancellation) -> RecoveryResult:
        """Backs up; IMPASSABLE before blocked ground, FAILURE off the map or if it is stuck."""
        state = robot.awaited_state(clock, cancellation)
        way = _Run(ReversePath(state.pose, robot.trail.back()), self.values, ProgressWatch())
        gone = before = speed = 0.0
        try:
            while not cancellation.canceled:
                try:
                    state = robot.state()
                except RobotLost:
                    robot.trail.forget_last(way.back.passed)
                    state = robot.awaited_state(clock, cancellation)
                    # It may be elsewhere, where no trail leads back to the one of before.
                    back = ReversePath(state.pose, robot.trail.back())
                    before, speed, way = gone, 0.0, _Run(back, self.values, ProgressWatch())
                gone = before + way.back.gone(state.pose.position)
                end, velocity = self._next(way, state, gone, speed, clock.now())
                if end is not None:
                    return end
                robot.drive(velocity)
                speed = -velocity.x
                clock.wait_until(clock.now() + PERIOD, cancellation)
        finally:
            robot.drive(STOP)
            robot.trail.forget_last(way.back.passed)
        text = f"backing up stopped after {gone:.2f} m: {cancellation.reason}"
        return RecoveryResult(RecoveryOutcome.CANCELED, text)

    def _next(
        self, way: _Run, state: RobotState, gone: float, speed: float, now: float
    ) -> Tuple[Optional[RecoveryResult], Velocity]:
        """The end, or the next command."""
        values = way.values
        left = values["distance"] - gone
        if left <= ARRIVED:
            return RecoveryResult(RecoveryOutcome.SUCCESS, f"backed up by {gone:.2f} m"), STOP
        way.watch.got_on(state.pose, now, MOVED, TURNED)
        if way.watch.seconds(now) > STUCK:
            text = f"the robot does not get on for {STUCK:.0f} s, backed up by {gone:.2f} m"
            return RecoveryResult(RecoveryOutcome.FAILURE, text), STOP
        side, distance = _direction(state.pose, way.back.target(LOOKAHEAD))
        if abs(side) > TURN_FIRST:
            return None, Velocity(yaw=math.copysign(values["max_ang_velocity"], side))
        acceleration = values["acceleration"]
        fastest = min(values["speed"], speed + acceleration * PERIOD)
        free, end = self._free(state.pose, fastest, values, gone)
        if end is not None:
            return end, STOP
        fastest = min(fastest, max(SLOWEST, math.sqrt(2.0 * acceleration * min(left, free))))
        curvature = 2.0 * math.sin(side) / distance
        if abs(curvature) * fastest > values["max_ang_velocity"]:
            fastest = values["max_ang_velocity"] / abs(curvature)
        return None, Velocity(x=-fastest, yaw=fastest * curvature)

    def _free(
        self, pose: Pose, speed: float, values: Mapping[str, Value], gone: float
    ) -> Tuple[float, Optional[RecoveryResult]]:
        """How far the robot may still go (m), or the end if that is nothing."""
        start = self.map.closest_face(pose.position, MAX_DISTANCE)
        if start is None:
            text = (
                f"the robot at {vector_text(pose.position)} is off the map (no surface within "
                f"{MAX_DISTANCE:.2f} m), backed up by {gone:.2f} m"
            )
            return 0.0, RecoveryResult(RecoveryOutcome.FAILURE, text)
        stopping = speed * speed / (2.0 * values["acceleration"]) + 2.0 * speed * PERIOD
        clearance = values["clearance"]
        found = free_path(self.map, start, -pose.heading, clearance + stopping, self.body)
        if found.length <= clearance and found.obstacle:
            text = (
                f"{found.length:.2f} m behind the robot (clearance {clearance:.2f} m) "
                f"{found.obstacle}; backed up by {gone:.2f} m"
            )
            return 0.0, RecoveryResult(RecoveryOutcome.IMPASSABLE, text)
        return (found.length - clearance if found.obstacle else math.inf), None


def _direction(pose: Pose, target: Optional[np.ndarray]) -> Tuple[float, float]:
    """How far a point is to the side of straight back (rad, > 0: to be turned to the left), and how
    far away (m, along the ground); straight back without a point."""
    if target is None:
        return 0.0, LOOKAHEAD
    inverse = pose.orientation * np.array([-1.0, -1.0, -1.0, 1.0])
    x, y, _ = rotate(inverse, target - pose.position)
    return math.atan2(-y, -x), max(math.hypot(x, y), 1e-3)
