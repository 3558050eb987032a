"""A robot and a clock for executions that run as fast as the computer can."""

import math
import threading
from typing import Callable

import numpy as np

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.pose import Pose, multiply
from mesh_navigation.base.robot import STOP, Robot, RobotState, Trail, Velocity
from mesh_navigation.simulation.surface_robot import SurfaceRobot

COMMAND_TIMEOUT = 0.5  # s that a velocity holds without a new one
STEP = 0.02  # s


class SimulatedRobot(Robot):
    """A `SurfaceRobot` that obeys the newest command. From any thread.

    Attributes:
        body: the robot on the surface; ask it from the thread that lets time pass.
        time: s since it began.
        last_command: as it was given.
    """

    def __init__(
        self,
        body: SurfaceRobot,
        *,
        pose_noise: float = 0.0,
        heading_noise: float = 0.0,
        command_timeout: float = COMMAND_TIMEOUT,
        seed: int = 0,
    ) -> None:
        """
        Args:
            body: the robot on the surface.
            pose_noise: standard deviation of the place that `state` tells (m, along each axis).
            heading_noise: of its heading (rad).
            command_timeout: without a new command for longer (s), it stops.
            seed: of this noise.
        """
        self.body = body
        self.trail = Trail()
        self.time = 0.0
        self.last_command = STOP
        self._commanded = -math.inf
        self._timeout = command_timeout
        self._noise = np.array([pose_noise, pose_noise, pose_noise, heading_noise])
        self._random = np.random.default_rng(seed)
        self._lock = threading.RLock()

    def state(self) -> RobotState:
        with self._lock:
            pose, velocity, time = self.body.pose, self.body.velocity, self.time
            if self._noise.any():
                *shift, turn = self._noise * self._random.standard_normal(4)
                left = np.array([0.0, 0.0, math.sin(turn / 2), math.cos(turn / 2)])
                pose = Pose(pose.position + shift, multiply(pose.orientation, left))
        return RobotState(time, pose, velocity)

    def drive(self, velocity: Velocity) -> None:
        with self._lock:
            self.last_command = velocity if velocity.is_finite else STOP
            self._commanded = self.time

    def put(self, pose: Pose) -> None:
        """Put it elsewhere, see `SurfaceRobot.put`."""
        with self._lock:
            self.body.put(pose)

    def advance(self, seconds: float) -> None:
        """Let it drive for so long."""
        with self._lock:
            held = max(0.0, min(seconds, self._commanded + self._timeout - self.time))
            if held > 0:
                self.body.step(self.last_command, held)
            if seconds > held:
                self.body.step(STOP, seconds - held)
            self.time += seconds


class SimulatedClock(Clock):
    """Time that passes only while somebody waits for it; the robot drives meanwhile.

    One thread may wait at a time; others may ask for the time.
    """

    def __init__(
        self,
        robot: SimulatedRobot,
        on_step: Callable[[float], None] = lambda time: None,
        step: float = STEP,
    ) -> None:
        """
        Args:
            robot: which drives.
            on_step: called with the time after each step: to watch, push, or cancel.
            step: s at most between two calls.
        """
        self._robot, self._on_step, self._step = robot, on_step, step

    def now(self) -> float:
        return self._robot.time

    def wait_until(self, moment: float, cancellation: Cancellation) -> None:
        while not cancellation.canceled:
            left = moment - self._robot.time
            if not left > 1e-9:
                return
            self._robot.advance(left if left < self._step * 1.001 else self._step)
            self._on_step(self._robot.time)
