"""Wait: others may go away."""

from mesh_map.base.parameter import Parameter

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock, Stopwatch
from mesh_navigation.base.outcomes import RecoveryOutcome
from mesh_navigation.base.robot import Robot
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult


class Wait(MeshRecovery):
    """Stands for a while, by the time of the server's clock."""

    parameters = (Parameter("seconds", 5.0, 0.0, 3600.0, "how long (s)"),)

    def run(self, robot: Robot, clock: Clock, cancellation: Cancellation) -> RecoveryResult:
        """Waits; a parameter that changes meanwhile counts the next time."""
        seconds = self.values["seconds"]
        watch = Stopwatch(clock)
        while not cancellation.canceled:
            left = seconds - watch.seconds()
            if left <= 0.0:
                return RecoveryResult(RecoveryOutcome.SUCCESS, f"waited for {seconds:.1f} s")
            clock.wait_until(clock.now() + left, cancellation)
        text = f"waiting stopped after {watch.seconds():.1f} of {seconds:.1f} s"
        return RecoveryResult(RecoveryOutcome.CANCELED, f"{text}: {cancellation.reason}")
