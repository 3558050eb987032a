"""What a recovery behavior is: the base class of all of them, and what one returns."""

from typing import NamedTuple

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import is_success
from mesh_navigation.base.robot import Robot
from mesh_navigation.plugins.plugin import MeshPlugin


class RecoveryResult(NamedTuple):
    """How a behavior ended."""

    outcome: int
    """A value of `RecoveryOutcome`, or a behavior's own: 1 to 9 (success) or 171 to 199."""
    message: str
    """One sentence for people, with numbers."""

    @property
    def succeeded(self) -> bool:
        """Whether it did what it is for."""
        return is_success(self.outcome)


class MeshRecovery(MeshPlugin):
    """Base class of recovery behaviors: what to try when there is no plan, or no way to follow it.

    A behavior of one's own derives from it and is described in an XML file as planners are (see
    `MeshPlanner`), with ``base_class_type="mesh_navigation::MeshRecovery"``.

    The contract:

    * Construction takes no arguments and does nothing long. ``initialize`` is called once per map.
    * ``run`` is the one method to override. It may run several times at once, in different threads
      (one per concurrency slot): what belongs to one run stays in local variables.
    * It may drive: ``robot.drive(velocity)`` in cycles of about 0.05 s (``clock.wait_until``), each
      after a look at ``robot.state()`` and at the costs ahead. The robot is stopped when no command
      comes for 0.2 s, when it returns or raises, whatever the reason, and when it was canceled.
    * Cancel, also for want of patience (recovery_patience): look at ``cancellation`` at least every
      0.1 s, then return CANCELED. The server waits half a second, then answers without the
      behavior, and what it still commands does not reach the robot.
    * TF, and what sensors see, may have gaps: ``robot.awaited_state(clock, cancellation)`` lets the
      robot stand meanwhile.
    * Any exception is reported: `RobotLost` as TF_ERROR, all others as INTERNAL_ERROR.
    * Units are m, rad and s, the frame is the map's (``self.map.frame_id``).
    """

    def run(self, robot: Robot, clock: Clock, cancellation: Cancellation) -> RecoveryResult:
        """Do it.

        Args:
            robot: to ask and to drive.
            clock: to wait by; it may be that of a simulation.
            cancellation: ends it.

        Raises:
            RobotLost: the pose is not known.
        """
        raise NotImplementedError(f"{type(self).__name__} does not override run()")
