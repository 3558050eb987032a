"""Which velocity reaches the base at which moment: the guard without its process."""

import math
from typing import NamedTuple, Optional, Set

from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.velocity_guard.velocity_bounds import VelocityBounds, VelocityLimits

# A drive is silent after this time (s), or after so many periods of control.
SILENCE, SILENT_PERIODS = 0.2, 3.0
# s of zeros, after a drive and after the server's end; and from one zero to the next.
LAST_ZEROS, ZERO_PERIOD = 1.0, 0.05


class Moment(NamedTuple):
    """By both clocks."""

    time: float
    """By which robots drive: that of ROS, which a simulation may stop or set back (s)."""
    wall: float
    """Of the computer; only goes on (s)."""


class VelocityGuard:
    """Passes commands of one drive at a time on, bounded, and stops a drive that falls silent.

    A drive begins with its first command that moves the robot. Of several, the newest one (that
    with the greatest number) has the robot until it ends; then the next older one goes on. For one
    thread. Methods return what is to be sent at that moment, None for nothing.
    """

    def __init__(self, limits: VelocityLimits, now: Moment) -> None:
        self.obstruction = ""
        """Why the robot has to stand, whatever is commanded; empty: it need not."""
        self._bounds = VelocityBounds(limits)
        self._drives: Set[int] = set()
        self._heard, self._period = now, 0.0
        self._ticked = now  # when the time was seen to go on
        self._zeros_end = self._next_zero = -math.inf  # of wall time
        self._server_gone = False

    @property
    def is_driving(self) -> bool:
        """Whether there is a drive."""
        return bool(self._drives)

    def is_over(self, now: Moment) -> bool:
        """Whether the server has ended, and the last zero was sent."""
        return self._server_gone and now.wall >= self._zeros_end

    def command(
        self, drive: int, velocity: Velocity, period: float, now: Moment, age: float = 0.0
    ) -> Optional[Velocity]:
        """A command of a drive.

        Args:
            drive: its number.
            velocity: what is not finite becomes `STOP`.
            period: in which its commands come (s).
            now: the moment.
            age: how long ago it was given (s). One that a silent drive would not live by any more
                is a stop: the guard stood still, and who took its place may have stopped the robot.
        """
        if not velocity.is_finite:
            velocity = STOP
        if velocity != STOP:
            self._drives.add(drive)
        if not self._drives:
            return self._bounds.stop()  # The end of what did not drive.
        if drive != max(self._drives):
            return None
        self._heard, self._period = Moment(now.time - age, now.wall - age), period
        self._zeros_end = -math.inf
        if self.obstruction or age > self._patience():
            return self._bounds.stop()
        return self._bounds.bounded(velocity, now.time, period)

    def end(self, drive: int, now: Moment) -> Optional[Velocity]:
        """A drive is over."""
        if drive not in self._drives:
            return None
        self._drives.remove(drive)
        return None if self._drives else self._last_zeros(now)

    def server_ended(self, now: Moment) -> Optional[Velocity]:
        """The server is gone, however it ended."""
        if self._server_gone:
            return None
        self._server_gone = True
        self._drives.clear()
        return self._last_zeros(now)

    def tick(self, now: Moment) -> Optional[Velocity]:
        """Called again and again, at least every `ZERO_PERIOD` while there is a drive."""
        if now.time != self._ticked.time:
            # It was set back, or has only begun: silence counts from here.
            if now.time < self._heard.time or not self._heard.time:
                self._heard = self._heard._replace(time=now.time)
            self._ticked = now
        if now.wall < self._zeros_end or self.why_stopped(now):
            return self._zero(now)
        return None

    def why_stopped(self, now: Moment) -> str:
        """Why a drive gets zeros in place of its commands; empty if it does not, or there is none.

        As of the last `tick`.
        """
        if not self._drives:
            return ""
        if self.obstruction:
            return self.obstruction
        silent, patience = now.time - self._heard.time, self._patience()
        if silent > patience:
            return f"no command for {silent:.2f} s, {patience:.2f} s are allowed"
        if now.wall - max(self._ticked.wall, self._heard.wall) > SILENCE:
            return f"/clock stands, and there is no command, for {SILENCE:.1f} s"
        return ""

    def _patience(self) -> float:
        return max(SILENCE, SILENT_PERIODS * self._period)

    def _last_zeros(self, now: Moment) -> Optional[Velocity]:
        self._zeros_end, self._next_zero = now.wall + LAST_ZEROS, now.wall
        return self._zero(now)

    def _zero(self, now: Moment) -> Optional[Velocity]:
        if now.wall < self._next_zero:
            return None
        self._next_zero = now.wall + ZERO_PERIOD
        return self._bounds.stop()
