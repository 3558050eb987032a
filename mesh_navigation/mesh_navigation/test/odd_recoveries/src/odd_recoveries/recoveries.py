"""Recovery behaviors that misbehave, each in one way; all of them drive."""

import math
import time

from mesh_map.base.parameter import Parameter

from mesh_navigation.base.robot import RobotLost, Velocity
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult

BACK = Velocity(-0.2)


class OutcomeRecovery(MeshRecovery):
    """Ends with the outcome that a parameter says."""

    parameters = (Parameter("outcome", 0, 0, 1000),)

    def run(self, robot, clock, cancellation):
        robot.drive(BACK)
        outcome = self.values["outcome"]
        return RecoveryResult(outcome, f"outcome {outcome}, as asked for")


class SlowRecovery(MeshRecovery):
    """Drives until it is canceled."""

    def run(self, robot, clock, cancellation):
        while not cancellation.canceled:
            robot.drive(BACK)
            clock.wait_until(clock.now() + 0.02, cancellation)
        return RecoveryResult(151, f"slow, and stopped: {cancellation.reason}")


class DeafRecovery(MeshRecovery):
    """Drives on, whatever it is told."""

    def run(self, robot, clock, cancellation):
        for _ in range(100):
            robot.drive(BACK)
            time.sleep(0.03)
        return RecoveryResult(0, "too late")


class ThrowingRecovery(MeshRecovery):
    """Raises what no caller expects."""

    def run(self, robot, clock, cancellation):
        robot.drive(Velocity(math.nan))
        robot.drive(BACK)
        raise ZeroDivisionError("by zero")


class LostRecovery(MeshRecovery):
    """Does not know where the robot is."""

    def run(self, robot, clock, cancellation):
        robot.drive(BACK)
        raise RobotLost("nowhere to be seen")


class LameRecovery(MeshRecovery):
    """Cannot be initialized."""

    def initialize(self, name, mesh_map, given={}):
        raise RuntimeError("no legs")
