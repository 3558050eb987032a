"""A robot that can be taken away from whoever drives it."""

import threading

from mesh_navigation.robot import STOP, Robot, RobotState, Velocity
from mesh_navigation.trail import Trail


class GuardedRobot(Robot):
    """Passes everything on to a robot until it is closed; commands that come later are dropped."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lock = threading.Lock()
        self._closed = False

    @property
    def trail(self) -> Trail:  # type: ignore[override]
        """That of the robot."""
        return self._robot.trail

    def state(self) -> RobotState:
        return self._robot.state()

    def drive(self, velocity: Velocity) -> None:
        # Under the lock: no command can overtake the last stop.
        with self._lock:
            if not self._closed:
                self._robot.drive(velocity)

    def close(self) -> None:
        """Stop the robot; from now on it obeys others only."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._robot.drive(STOP)
