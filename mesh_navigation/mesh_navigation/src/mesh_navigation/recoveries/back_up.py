"""Back up the way the robot came."""

import math
from typing import Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.parameter import Parameter, Value

from mesh_navigation.anchors import MAX_DISTANCE
from mesh_navigation.cancellation import Cancellation
from mesh_navigation.clock import Clock
from mesh_navigation.ground_ahead import free_way
from mesh_navigation.outcomes import RecoveryOutcome
from mesh_navigation.pose import Pose, rotate, vector_text
from mesh_navigation.progress_watch import ProgressWatch
from mesh_navigation.recovery import MeshRecovery, RecoveryResult
from mesh_navigation.robot import STOP, Robot, RobotState, Velocity
from mesh_navigation.way_back import WayBack

PERIOD = 0.05  # s between two commands
ARRIVED = 0.01  # m from the end that are good enough
SLOWEST = 0.02  # m/s on the last centimeters
LOOKAHEAD = 0.3  # m, to the point of the way that is steered to
TURN_FIRST = math.radians(60)  # if that point is farther to the side, the robot turns on the spot
STUCK = 3.0  # s without getting on by MOVED m or TURNED rad
MOVED, TURNED = 0.02, 0.05


class _Way(NamedTuple):
    """What one run works with."""

    back: WayBack
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
        back = WayBack(robot.state().pose, robot.trail.back())
        way = _Way(back, self.values, ProgressWatch())
        gone = speed = 0.0
        try:
            while not cancellation.canceled:
                state = robot.state()
                gone = back.gone(state.pose.position)
                end, velocity = self._next(way, state, gone, speed, clock.now())
                if end is not None:
                    return end
                robot.drive(velocity)
                speed = -velocity.x
                clock.wait_until(clock.now() + PERIOD, cancellation)
        finally:
            robot.drive(STOP)
            robot.trail.forget_last(back.passed)
        text = f"backing up stopped after {gone:.2f} m: {cancellation.reason}"
        return RecoveryResult(RecoveryOutcome.CANCELED, text)

    def _next(
        self, way: _Way, state: RobotState, gone: float, speed: float, now: float
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
        found = free_way(self.map, start, -pose.heading, clearance + stopping)
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
