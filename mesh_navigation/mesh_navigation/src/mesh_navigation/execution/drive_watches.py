"""Whether a robot that is driven gets on, judged by its poses and its clock."""

import math
from typing import Mapping, Optional

from mesh_map.base.parameter import Value

from mesh_navigation.base.pose import Pose
from mesh_navigation.base.progress_watch import ProgressWatch, angle_between
from mesh_navigation.base.robot import RobotState, Velocity

# What is slower counts as standing (m/s, rad/s).
STANDING = 1e-3
# Less than this is no motion but the noise of localization (m, rad alike); more of it is believed
# where odometry says that the robot stands. (Some odometry always says so.)
STILL, STILL_BY_ODOMETRY = 0.01, 0.1
# A robot that was told to move this many times what it may have moved unnoticed does not obey.
CLEARLY = 3.0
# A cycle that took longer (s) says nothing about the robot: it was stopped meanwhile.
LONGEST_CYCLE = 2.0


class OscillationWatch:
    """Notices a robot that moves without getting on."""

    def __init__(self) -> None:
        self._progress: Optional[ProgressWatch] = None

    def restart(self) -> None:
        """Begin anew with the next pose."""
        self._progress = None

    def fault(self, pose: Pose, now: float, values: Mapping[str, Value]) -> str:
        """A sentence if the robot does not get on, else empty.

        It gets on by oscillation_distance, or by turning by oscillation_angle, each time within
        oscillation_timeout; 0: not watched.
        """
        timeout = values["oscillation_timeout"]
        if timeout <= 0.0:
            self._progress = None
            return ""
        progress = self._progress = self._progress or ProgressWatch()
        distance, angle = values["oscillation_distance"], values["oscillation_angle"]
        progress.got_on(pose, now, distance, angle)
        seconds = progress.seconds(now)
        if seconds <= timeout:
            return ""
        return (
            f"for {seconds:.1f} s (oscillation_timeout {timeout:.1f} s) the robot did not get on "
            f"by {distance:.2f} m (oscillation_distance) or {angle:.2f} rad (oscillation_angle)"
        )


class ObedienceWatch:
    """Notices a robot that is told to move and does not."""

    def __init__(self) -> None:
        self._base: Optional[Pose] = None
        self._since = self._last = 0.0
        self._distance = self._angle = 0.0
        self._odometry_stands = True

    def restart(self) -> None:
        """Begin anew with the next command."""
        self._base = None

    def fault(self, state: RobotState, command: Velocity, now: float, tolerance: float) -> str:
        """A sentence if the robot does not obey, else empty.

        Args:
            state: of the robot, before the command.
            command: that it gets now.
            now: the time (s).
            tolerance: for how long it may ignore commands (s), <= 0: without end.
        """
        linear, angular = math.hypot(command.x, command.y), abs(command.yaw)
        if tolerance <= 0.0 or (linear < STANDING and angular < STANDING):
            self._base = None
            return ""
        if self._base is None or not 0.0 <= now - self._last <= LONGEST_CYCLE:
            self._begin(state, now)
        measured = state.velocity
        self._odometry_stands = self._odometry_stands and (
            math.hypot(measured.x, measured.y) < STANDING and abs(measured.yaw) < STANDING
        )
        if not self._stays(state.pose, STILL_BY_ODOMETRY if self._odometry_stands else STILL):
            self._begin(state, now)
        elapsed, self._last = now - self._last, now
        self._distance += linear * elapsed
        self._angle += angular * elapsed
        if now - self._since <= tolerance or not (self._odometry_stands or self._is_clear()):
            return ""
        return (
            f"the robot does not move for {now - self._since:.1f} s (cmd_vel_ignored_tolerance "
            f"{tolerance:.1f} s), told to move by {self._distance:.2f} m and {self._angle:.2f} rad"
        )

    def _begin(self, state: RobotState, now: float) -> None:
        self._base, self._since, self._last = state.pose, now, now
        self._distance = self._angle = 0.0
        self._odometry_stands = True

    def _stays(self, pose: Pose, noise: float) -> bool:
        assert self._base is not None
        way = math.dist(pose.position, self._base.position)
        return way < noise and angle_between(pose, self._base) < noise

    def _is_clear(self) -> bool:
        """Whether what was commanded cannot be the noise of localization."""
        return max(self._distance, self._angle) > CLEARLY * STILL
